"""Bounds of the magnitudes of lengths and moduli, within which squares and products of several of them stay finite numbers."""

from __future__ import annotations

from collections.abc import Iterable

from ..errors import Location
from .validation import refusal

LEAST, MOST = 1e-40, 1e40


def refuse_absurd(values: Iterable[tuple[Location, float]]) -> None:
    """Refuse positive numbers, each with its place, that are smaller or larger than any that can be computed with."""
    for place, value in values:
        if not LEAST <= value <= MOST:
            raise refusal(f"got {value:g}", f"{LEAST:g} to {MOST:g}", at=place)


def refuse_far(values: Iterable[tuple[Location, float]]) -> None:
    """Refuse coordinates, each with its place, that are farther out than any that can be computed with."""
    for place, value in values:
        if not abs(value) <= MOST:
            raise refusal(f"got {value:g}", f"{-MOST:g} to {MOST:g}", at=place)
