"""Discs in a box: the environment of one task, an example of a small domain without a native batch."""
