"""Discs in a box: the environment of a task on them, as an example of a small domain without a native batch."""
