"""The numeric force equation of a packing and its error theory."""
