"""Exact solutions for the gas: the Riemann problem, shocks, detonations, their reaction zone and the Taylor wave behind them.

No step calls them.
"""

from __future__ import annotations

from ..chapman_jouguet import Detonation, Flow, chapman_jouguet
from .riemann import RiemannSolution, riemann_problem
from .shocks import reflected_pressure, state_behind_shock
from .taylor_wave import TaylorWave, fit_decay
from .znd import ReactionZone

__all__ = [
    "Detonation", "Flow", "ReactionZone", "RiemannSolution", "TaylorWave", "state_behind_shock", "chapman_jouguet", "fit_decay",
    "reflected_pressure", "riemann_problem",
]  # fmt: skip
