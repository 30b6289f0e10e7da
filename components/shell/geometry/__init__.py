"""Bodies as lattices of nodes."""
