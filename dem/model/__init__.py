"""What acts on grains, and between which: law, drive, memory of contacts, neighbour list, cell."""
