"""Exact solutions for the grid: plane strain, isotropic, small strains. No step calls them."""

from __future__ import annotations

from ...materials.elastic import rayleigh_speed
from .dashpots import reflected_energy
from .fronts import Front, load_fronts
from .line_load import LineLoad
from .plane_waves import mesh_frequencies, rayleigh_ellipse

__all__ = ["Front", "LineLoad", "load_fronts", "mesh_frequencies", "rayleigh_ellipse", "rayleigh_speed", "reflected_energy"]
