"""Fracture of a body: laws, cracks, and the outcome for the body."""
