"""Environments of a detonation in a deformable tube."""
