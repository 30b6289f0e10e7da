"""Fracture: laws, cracks, outcome. A point parts when a crack forms at it, and is eroded when it no longer carries stress."""
