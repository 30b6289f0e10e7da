"""The thin-walled solid (`shell`): a remark below pictures of half a tube, because its mirror image is not drawn."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_HALF = "Half of the tube is computed and drawn (y > 0); the other half is its mirror image."


def remark(parameters: Mapping[str, Any]) -> str:
    """Return a remark on the mirror image that a picture of a half tube omits; "" for other (also invalid) parameters."""
    shell = parameters.get("shell", parameters)
    body = shell.get("body") if isinstance(shell, Mapping) else None
    return _HALF if isinstance(body, Mapping) and body.get("half") is True else ""
