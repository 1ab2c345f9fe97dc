"""Fuzzers: the public API called with odd values. Run `python -m tests.fuzz.api --help`."""
