"""A detonation in a tube that gives way: its environments."""
