"""What the figures and pages show, computed and written as tables: `python -m studies`."""
