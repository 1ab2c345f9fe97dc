"""How packings are drawn: grains, contacts as lines, walls, and copies across a periodic cell."""
