"""The report: one page that holds all it shows, to be read without a network."""
