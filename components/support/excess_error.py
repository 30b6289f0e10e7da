"""The error of a step that leads too far: which element of a variable is beyond its limit, and by how much."""

from __future__ import annotations

import numpy as np

from ..errors import StepError
from .float_arrays import FloatArray


def excess_error(variable: str, unit: str, size: FloatArray, limit: float, time: float, advice: str) -> StepError:
    """Return the error for the first element whose size is above the limit, or no number.

    Args:
        variable: its name.
        unit: of the sizes and the limit.
        size: of each element, shape (n,); at least one is above the limit.
        limit: what is allowed.
        time: up to which all was well [s].
        advice: what the limit means, and what to do.
    """
    index = int(np.argmin(size <= limit))
    return StepError(
        f"reached {size[index]:g} {unit} soon after {time:g} s, expected at most {limit:g} {unit}, {advice}",
        time=time, at=(variable, index), variable=variable, index=index, value=float(size[index]), limit=limit,
    )  # fmt: skip
