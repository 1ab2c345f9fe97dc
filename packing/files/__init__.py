"""Files of packings, one module a format."""
