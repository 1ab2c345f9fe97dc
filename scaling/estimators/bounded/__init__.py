"""The most probable forces that balance, push and keep to Coulomb's limit."""
