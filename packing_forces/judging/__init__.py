"""What can be said of forces from the data at hand: checks, expected errors, choice, verdicts."""
