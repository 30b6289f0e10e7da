"""The solid with thin walls: the remark below pictures of half a tube, whose other half is not drawn."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_HALF = "Half of the tube is computed and drawn (y > 0); the other half is its mirror image."


def remark(parameters: Mapping[str, Any]) -> str:
    """Return what a picture of a body leaves out: the mirror image of half a tube; "" where nothing is missing.

    Args:
        parameters: of a `shell`, or of a `tube`, which has one; plain values, of a log whatever it holds.
    """
    shell = parameters.get("shell", parameters)
    body = shell.get("body") if isinstance(shell, Mapping) else None
    return _HALF if isinstance(body, Mapping) and body.get("half") is True else ""
