"""The list of contacts: its rules, how it is found, what bears no force."""
