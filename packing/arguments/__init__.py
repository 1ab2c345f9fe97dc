"""What a caller may give: numbers, arrays, sizes that fit into memory."""
