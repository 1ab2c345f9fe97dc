"""What a file tells of a packing: its network, law, loads, forces, and how exactly they are known."""
