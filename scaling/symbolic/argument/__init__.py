"""The Comment's argument and the expansion of the error, step by step."""
