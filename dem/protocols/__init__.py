"""From scene to packing, and from packing to packing."""
