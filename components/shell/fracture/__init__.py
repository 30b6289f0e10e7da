"""Fracture: laws that say when a point parts, cracks between nodes, and what they leave."""
