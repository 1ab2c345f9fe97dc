"""Many packings: made on any executor, stored, resumed."""
