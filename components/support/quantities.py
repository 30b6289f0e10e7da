"""Numbers with a unit as text, such as "100us", "3 mm" or "210 GPa", converted to SI."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from contextlib import suppress
from fractions import Fraction
from functools import cache
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, ValidatorFunctionWrapHandler, WrapValidator

from ..errors import Location, ParameterError

_PREFIXES = {"": 0, "n": -9, "u": -6, "m": -3, "c": -2, "k": 3, "M": 6, "G": 9}
# Symbol -> its definition, a factor and a unit; base units define themselves.
_SYMBOLS = {
    "s": (1, "s"), "m": (1, "m"), "kg": (1, "kg"), "K": (1, "K"), "rad": (1, "rad"), "V": (1, "V"),
    "N": (1, "kg m/s^2"), "Pa": (1, "N/m^2"), "J": (1, "N m"), "W": (1, "J/s"), "Hz": (1, "1/s"), "min": (60, "s"),
    "h": (3600, "s"), "g": (Fraction(1, 1000), "kg"), "deg": (Fraction(math.pi / 180.0), "rad"),
}  # fmt: skip
_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)\s*(\D.*?)?\s*", re.ASCII)
_FACTOR = re.compile(rf"([{''.join(_PREFIXES)}]??)({'|'.join(_SYMBOLS)})\^?(-?\d(?:\.\d)?)?")
_SPELLINGS = str.maketrans({"\u00b5": "u", "\u03bc": "u", "\u00b0": "deg", "\u00b2": "^2", "\u00b3": "^3", "\u00b7": " "})
# Unit -> description of a valid value in messages.
_EXPECTED = {
    "1": "a number", "kg": "a mass such as 5g or 5e-3", "m": "a length such as 3mm or 3e-3", "m/s": "a speed such as 5m/s or 5",
    "N": "a force such as 2kN or 2e3", "Pa": "a stress such as 5MPa or 5e6", "s": "a time such as 100us or 1e-4",
}  # fmt: skip


class Quantity(float):
    """The number in SI that a text denotes, with its text; the float nearest to the written value.

    The SI prefixes are n, u or µ, m, c, k, M and G. A number without a unit is in SI already.

    Raises:
        ValueError: the text is not a number with a known unit.
        OverflowError: the number is too large.
    """

    text: str
    exponents: dict[str, Fraction]

    def __new__(cls, text: str) -> Self:
        """Read the text."""
        match = _QUANTITY.fullmatch(text)
        if match is None:
            raise ValueError(text)
        number, unit = match.groups()
        size, exponents = _parse_unit(unit or "1")
        quantity = super().__new__(cls, Fraction(number) * size)
        quantity.text, quantity.exponents = text, exponents
        return quantity

    def __getnewargs__(self) -> tuple[str]:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Support pickle: tasks of sweeps contain quantities."""
        return (self.text,)


def parse_quantity(text: str, unit: str, at: str | Location = ()) -> float:
    """Return the number in the SI unit `unit`, such as "s" or "kg/m^3", that a text such as "100us" or "7.8 g/cm^3" denotes.

    Raises:
        ParameterError: at `at`, the text is not a number with a unit of this quantity.
    """
    with suppress(ValueError, OverflowError):
        quantity = Quantity(text)
        if not quantity.exponents or quantity.exponents == _parse_unit(unit)[1]:
            return float(quantity)
    raise ParameterError(f"got {text!r}", expected=_EXPECTED.get(unit, f"a number in {unit}"), at=at)


def to_si(value: Any, unit: str | None, at: Location = ()) -> Any:
    """Convert texts with a unit, also in lists and tables, to numbers in SI; leave other values unchanged.

    Args:
        value: numbers, texts or quantities.
        unit: the SI unit that they must have; None if it is not known yet: texts with a unit become quantities.
        at: location of the value, for messages.

    Raises:
        ParameterError: a text is not a quantity with this unit.
    """
    match value:
        case Quantity() if unit is not None:
            return parse_quantity(value.text, unit, at)
        case str():
            match = _QUANTITY.fullmatch(value)
            if match is None or match[2]:
                if unit is not None:
                    return parse_quantity(value, unit, at)
                with suppress(ValueError, OverflowError):
                    return Quantity(value)
        case dict():
            return {key: to_si(part, unit, (*at, key)) for key, part in value.items()}
        case list():
            return [to_si(part, unit, (*at, index)) for index, part in enumerate(value)]
    return value


def _keep_quantity(given: Any, handler: ValidatorFunctionWrapHandler) -> float:
    value = to_si(given, None)
    number = handler(value)
    return value if isinstance(value, Quantity) else number


Seconds = Annotated[float, BeforeValidator(lambda value: to_si(value, "s"))]
"""A time [s] in a document."""
Quantities = BeforeValidator(lambda value: to_si(value, None))
"""Annotation of a field of a document with values whose units are known only with the component."""
Value = Annotated[float, WrapValidator(_keep_quantity)]
"""A value in a unit that is known only with the component; `to_si` checks it then."""


@cache
def _parse_unit(text: str) -> tuple[Fraction, dict[str, Fraction]]:
    """Return the size of a unit in SI, and the exponent of each base unit; `ValueError` for an unknown unit."""
    size, exponents = Fraction(1), defaultdict[str, Fraction](Fraction)
    for position, part in enumerate(text.translate(_SPELLINGS).split("/")):
        for factor in part.strip(" ()").split():
            if factor != "1":
                match = _FACTOR.fullmatch(factor)
                if match is None:
                    raise ValueError(text)
                prefix, symbol, written = match.groups()
                multiple, definition = _SYMBOLS[symbol]
                own_size, own = (Fraction(1), {symbol: Fraction(1)}) if definition == symbol else _parse_unit(definition)
                power = Fraction(written or 1) * (-1 if position else 1)
                size *= (Fraction(10) ** _PREFIXES[prefix] * multiple * own_size) ** power
                for base, exponent in own.items():
                    exponents[base] += exponent * power
    return size, {base: exponent for base, exponent in exponents.items() if exponent}
