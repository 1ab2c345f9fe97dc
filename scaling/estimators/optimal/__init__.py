"""The best linear unbiased estimate, and whether its noise is plausible."""
