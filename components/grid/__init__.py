"""A continuum on a mesh of quadrilaterals that moves with it: Wilkins (1964), Psakhie et al. (2003)."""

from __future__ import annotations

from .component import Grid
from .parameters import GridParameters

__all__ = ["Grid", "GridParameters"]
