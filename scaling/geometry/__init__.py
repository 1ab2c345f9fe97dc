"""The contact network: who touches whom, its loops and windings, cuts and tilings."""
