"""Whether packings are at rest, the same, and what their making leaves in them."""
