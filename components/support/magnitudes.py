"""Bounds of the magnitudes of lengths and moduli, within which squares and products of several of them stay finite numbers."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated

from pydantic import AfterValidator, Field

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


def _validate_magnitude(value: float) -> float:
    if value != 0.0:
        refuse_absurd([((), abs(value))])
    return value


def _validate_signed(value: float) -> float:
    refuse_far([((), value)])
    return value


Magnitude = Annotated[float, Field(gt=0.0), AfterValidator(_validate_magnitude)]
"""A number above 0 that can be computed with, as a parameter: a length, a modulus, a pressure, a temperature."""
NotNegativeMagnitude = Annotated[float, Field(ge=0.0), AfterValidator(_validate_magnitude)]
"""The same, or 0."""
SignedMagnitude = Annotated[float, AfterValidator(_validate_signed)]
"""A number of any sign that is not larger than one can compute with, as a parameter."""
SignedPair = Annotated[list[SignedMagnitude], Field(min_length=2, max_length=2)]
"""Two of them."""
