"""What is put in: contact laws, balance, closure, dimensions."""
