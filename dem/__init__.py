"""A compact discrete element method: scene in, packing out."""
