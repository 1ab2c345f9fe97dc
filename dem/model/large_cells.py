"""From how many grains on a cell is large: what rests slowly, and fails in few places of many.

Large cells end with less drag (``dem.protocols.plan``), and Newton's method holds back the groups
of grains that it does not balance (``dem.balance.shift``).  Smaller cells need neither.
"""

#: Cells of more grains than these are large.
MANY = 10_000
