"""The time as an agent sees it, where an environment shows a clock."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ..components.support.jit import jit


@jit
def show_clock(elapsed, steps, out):
    """Write the time into `out`: cos(pi k elapsed / steps), k = 1 and so on."""
    # cos((k + 1) x) = 2 cos(x) cos(k x) - cos((k - 1) x): one cosine instead of many, to 1e-14.
    cosine = math.cos(math.pi * (elapsed / steps))
    before, now = 1.0, cosine
    for k in range(len(out)):
        out[k] = now
        before, now = now, 2.0 * cosine * now - before


def clock_readings(elapsed: int, steps: int, count: int) -> npt.NDArray[np.float32]:
    """Return the time as an agent sees it, see `show_clock`; shape (count,).

    An agent that does not see how late it is cannot do the right thing before a deadline (Pardo et al. 2018): what is at
    rest looks the same at any time.
    """
    out = np.empty(count, np.float32)
    show_clock(elapsed, steps, out)
    return out
