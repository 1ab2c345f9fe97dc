"""From symbols to numbers."""
