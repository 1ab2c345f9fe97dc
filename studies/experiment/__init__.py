"""What an experiment gets wrong: contacts, scales, digits, stiffness."""
