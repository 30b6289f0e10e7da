"""A detonation in a tube that gives way: its environments, and the atlas of the paper about it."""
