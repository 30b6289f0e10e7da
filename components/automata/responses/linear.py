"""The linear and elastic response: figure 3, a. No constants, no history."""

from __future__ import annotations

from typing import Literal

from ...support.parameter_fields import field
from .response import Response


class Linear(Response):
    """Forces follow strains in proportion, loading and unloading alike."""

    name: Literal["linear"] = field("linear", "which response", "1")
    elastic = True
