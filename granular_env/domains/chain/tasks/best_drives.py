"""The best known drives, which come with the package: one JSON file for each environment and its arguments.

A file holds "environment", "arguments" (those that differ from the defaults), "unit", "control_step" [s], "return", "made"
(how it was found) and "drive", the input in each control step; after its end the input is 0.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np
import numpy.typing as npt

_FOLDER = "best"


@cache
def _all() -> tuple[dict[str, Any], ...]:
    folder = files(__name__.rpartition(".")[0]).joinpath(_FOLDER)
    names = sorted(entry.name for entry in folder.iterdir() if entry.name.endswith(".json"))
    return tuple(json.loads(folder.joinpath(name).read_text("utf-8")) for name in names)


def best_drive(environment: str, arguments: Mapping[str, Any]) -> npt.NDArray[np.float64] | None:
    """Return the best known drive of an environment with these arguments [N or m/s], shape (steps,); None if none is known."""
    for entry in _all():
        if entry["environment"] == environment and entry["arguments"] == dict(arguments):
            return np.array(entry["drive"], dtype=np.float64)
    return None


def best_return(environment: str, arguments: Mapping[str, Any]) -> float | None:
    """Return what that drive returned when it was found."""
    for entry in _all():
        if entry["environment"] == environment and entry["arguments"] == dict(arguments):
            return float(entry["return"])
    return None
