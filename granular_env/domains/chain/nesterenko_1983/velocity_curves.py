"""Curves of a grain's velocity over time, of which several figures are made."""

from __future__ import annotations

from granular_env.atlas.model import Curve, CurveStyle

from ..measurement import History

MICRO = 1e6
TIME = "time, µs"


def velocity_of(
    history: History, grain: int, label: str, colour: int = 0, scale: float = 1.0, style: CurveStyle = "line"
) -> Curve:
    """Return a grain's velocity over time, in units of `scale`."""
    return Curve(label, history.time * MICRO, history.velocity[:, grain] / scale, style, colour)


def during(history: History, begin: float, end: float, grain: int, label: str, colour: int = 0) -> Curve:
    """Return a grain's velocity in a window of time [s]."""
    own = (history.time >= begin - 1e-12) & (history.time <= end + 1e-12)
    return Curve(label, history.time[own] * MICRO, history.velocity[own, grain], "line", colour)
