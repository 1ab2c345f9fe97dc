"""Ways to forces, one file each."""
