"""Restart files of MercuryDPM."""
