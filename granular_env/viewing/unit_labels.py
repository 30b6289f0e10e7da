"""Printed units and names: superscripts instead of ^, SI prefixes for large and small values, and no text for the unit 1."""

from __future__ import annotations

import math
import re

_RAISED = str.maketrans("0123456789.-", "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079\u00b7\u207b")
_PREFIXES = {-9: "n", -6: "\u00b5", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
# Symbols that take a prefix, and the largest power of ten of their prefixes.
_LARGEST_PREFIX = {"s": 0, "rad": 0, "m": 3, "N": 9, "Pa": 9, "J": 9, "W": 9, "Hz": 9}
# A unit without a prefix is kept for values between these limits.
_PLAIN = 0.1, 1e4
_MOST_POWER = 300


def typeset_unit(unit: str) -> str:
    """Return a unit for display: ``m/s^2`` with a superscript 2, and no text for ``1``."""
    return "" if unit == "1" else re.sub(r"\^(-?[0-9.]+)", lambda power: power[1].translate(_RAISED), unit)


def label_with_unit(name: str, unit: str) -> str:
    """Return a name with its unit in brackets: ``contact force [N]``."""
    words, printed = name.replace("_", " "), typeset_unit(unit)
    return f"{words} [{printed}]".strip() if printed else words


def scaled_unit(unit: str, largest: float) -> tuple[float, str]:
    """Return a suitable unit for values up to a magnitude: the factor by which to multiply them, and the unit's text.

    The first symbol of the unit gets an SI prefix (mm/s, MPa). If it takes none, as in kg m/s or 1, a power of ten precedes
    the unit.
    """
    first = re.match(r"([A-Za-z]+)(?:\^(\d))?(?![\w.^])", unit)
    exponent = int(first[2] or 1) if first is not None and first[1] in _LARGEST_PREFIX else 1
    if not 0.0 < largest < math.inf or _PLAIN[0] <= largest < _PLAIN[1]:
        return 1.0, typeset_unit(unit)
    # The small addend keeps 1e-3 s, computed with a rounding error, 1 ms instead of 1000 us.
    power = 3 * math.floor(math.log10(largest) / (3 * exponent) + 1e-9)
    power = max(-_MOST_POWER, power)
    if first is not None and power in _PREFIXES and power <= _LARGEST_PREFIX.get(first[1], -_MOST_POWER):
        return 10.0 ** (-power * exponent), _PREFIXES[power] + typeset_unit(unit)
    text = f"10{str(power * exponent).translate(_RAISED)} {typeset_unit(unit)}".strip()
    return 10.0 ** (-power * exponent), text


def scaled_label(name: str, unit: str, largest: float) -> tuple[float, str]:
    """Return the factor for values up to a magnitude, and the name with the suitable unit: ``contact force [kN]``."""
    factor, text = scaled_unit(unit, largest)
    return factor, label_with_unit(name, text)
