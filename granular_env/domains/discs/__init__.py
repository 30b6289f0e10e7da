"""Discs in a box: one environment; an example of a small domain that has no native batch."""
