"""Figures with matplotlib: of a run, of a plane at some instants, of one variable; the style that all share."""
