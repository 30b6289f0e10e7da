"""Printed units and names: superscripts instead of ^, and no text for the unit 1."""

from __future__ import annotations

import re

_RAISED = str.maketrans("0123456789.-", "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079\u00b7\u207b")


def typeset_unit(unit: str) -> str:
    """Return a unit for display: ``m/s^2`` with a superscript 2, and no text for ``1``."""
    return "" if unit == "1" else re.sub(r"\^(-?[0-9.]+)", lambda power: power[1].translate(_RAISED), unit)


def label_with_unit(name: str, unit: str) -> str:
    """Return a name with its unit in brackets: ``contact force [N]``."""
    words, printed = name.replace("_", " "), typeset_unit(unit)
    return f"{words} [{printed}]".strip() if printed else words
