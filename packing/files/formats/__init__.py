"""File formats of other codes and laboratories: one module each, and the table of them."""
