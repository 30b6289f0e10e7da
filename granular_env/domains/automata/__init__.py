"""Specimens of movable automata: their environments and tasks."""
