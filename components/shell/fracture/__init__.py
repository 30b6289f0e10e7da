"""Fracture: laws, cracks, outcome. A point parts if a crack forms at it, and is eroded if it no longer carries stress."""
