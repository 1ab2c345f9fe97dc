"""Small networks in exact arithmetic: ranks, null spaces, gains."""
