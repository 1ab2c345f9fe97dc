"""How errors of data become errors of forces: maps, bounds, draws, intervals, the collapse."""
