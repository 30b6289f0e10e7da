"""Scenes in rerun: what is sent of a log or of a live component, rerun's program, and its viewers."""
