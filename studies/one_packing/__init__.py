"""One packing of 1000 grains looked at contact by contact."""
