"""Numbers with a unit as text, such as "100us", "3 mm" or "210 GPa", converted to SI."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from fractions import Fraction
from functools import cache

from ..errors import Location, ParameterError

_PREFIXES = {"": 0, "n": -9, "u": -6, "m": -3, "c": -2, "k": 3, "M": 6, "G": 9}
# Symbol -> its definition, a factor and a unit; symbols that define themselves are the base units of this table.
_SYMBOLS = {
    "s": (1, "s"), "m": (1, "m"), "g": (1, "g"), "K": (1, "K"), "rad": (1, "rad"), "V": (1, "V"),
    "N": (1, "kg m/s^2"), "Pa": (1, "N/m^2"), "J": (1, "N m"), "W": (1, "J/s"), "Hz": (1, "1/s"),
    "min": (60, "s"), "h": (3600, "s"), "deg": (Fraction(math.pi / 180.0), "rad"),
}  # fmt: skip
_QUANTITY = re.compile(r"\s*(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)\s*(?P<unit>\D.*?)?\s*", re.ASCII)
_FACTOR = re.compile(rf"(?P<prefix>[{''.join(_PREFIXES)}]?)(?P<symbol>{'|'.join(_SYMBOLS)})\^?(?P<exponent>-?\d(?:\.\d)?)?")
_SPELLINGS = str.maketrans({"\u00b5": "u", "\u03bc": "u", "\u00b0": "deg", "\u00b2": "^2", "\u00b3": "^3", "\u00b7": " "})
# Unit -> description of a valid value in messages.
_EXPECTED = {
    "1": "a number", "kg": "a mass such as 5g or 5e-3", "m": "a length such as 3mm or 3e-3", "m/s": "a speed such as 5m/s or 5",
    "N": "a force such as 2kN or 2e3", "Pa": "a stress such as 5MPa or 5e6", "s": "a time such as 100us or 1e-4",
}  # fmt: skip


def parse_quantity(text: str, unit: str, at: str | Location = ()) -> float:
    """Return the number in the SI unit `unit` that a text denotes; a text without a unit is in that unit already.

    The result is the float nearest to the written value: ``parse_quantity("100us", "s")`` is exactly 1e-4.

    Args:
        text: a number and a unit with or without an SI prefix (n, u or µ, m, c, k, M, G), such as "3 mm" or "7.8 g/cm^3".
        unit: the expected unit, such as "s", "Pa" or "kg/m^3".
        at: location of the value, for messages.

    Raises:
        ParameterError: the text is not a number with a unit of this quantity.
    """
    match = _QUANTITY.fullmatch(text)
    try:
        if match is None:
            raise ValueError
        number = Fraction(match["number"])
        if match["unit"]:
            (size, written), (unit_size, expected) = _parse_unit(match["unit"]), _parse_unit(unit)
            if written != expected:
                raise ValueError
            number = number * size / unit_size
        return float(number)
    except (ValueError, OverflowError):
        expected = _EXPECTED.get(unit, f"a number in {unit}")
        raise ParameterError(f"got {text!r}", expected=expected, at=at) from None


@cache
def _parse_unit(text: str) -> tuple[Fraction, dict[str, Fraction]]:
    """Return the size of a unit in base units, and the exponent of each base unit; `ValueError` for an unknown unit."""
    size, exponents = Fraction(1), defaultdict[str, Fraction](Fraction)
    for position, part in enumerate(text.translate(_SPELLINGS).split("/")):
        for factor in part.strip(" ()").split():
            if factor != "1":
                match = _FACTOR.fullmatch(factor)
                if match is None:
                    raise ValueError(text)
                multiple, symbol = _SYMBOLS[match["symbol"]]
                own_size, own = (Fraction(1), {symbol: Fraction(1)}) if symbol == match["symbol"] else _parse_unit(symbol)
                power = Fraction(match["exponent"] or 1) * (-1 if position else 1)
                size *= (Fraction(10) ** _PREFIXES[match["prefix"]] * multiple * own_size) ** power
                for base, exponent in own.items():
                    exponents[base] += exponent * power
    return size, {base: exponent for base, exponent in exponents.items() if exponent}
