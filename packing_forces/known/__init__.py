"""What a file tells of a packing: network, law, loads, forces, and how exactly."""
