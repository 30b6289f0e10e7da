"""Drives: a few numbers that determine the action of every control step of an episode."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from granular_env.components.support.float_arrays import FloatArray


@dataclass(frozen=True)
class DriveShape:
    """A map from a point (the numbers chosen by a method) to a drive (the action of every control step).

    Knots are evenly spaced over the driven steps, from the first to the last step. Between two knots the action is
    interpolated linearly or keeps the value of the earlier knot; after the driven steps it is 0. Finally `rate` limits the
    change of the action from one step to the next, and from 0 to the first step.

    Attributes:
        steps: control steps of an episode.
        entries: number of entries of an action.
        knots: number of knots of each entry of the action.
        between: "linear" or "held".
        driven: number of control steps spanned by the knots; in later steps the action is 0.
        lowest, highest: smallest and largest value of a knot, in units of the action's scale.
        rate: largest change of the action per control step, in units of its scale; None for no limit.
    """

    steps: int
    entries: int
    knots: int
    between: str = "linear"
    driven: int | None = None
    lowest: float = -1.0
    highest: float = 1.0
    rate: float | None = None

    @property
    def size(self) -> int:
        """Number of coordinates of a point: knots x entries."""
        return self.knots * self.entries

    def actions(self, points: FloatArray) -> FloatArray:
        """Return the drive that each point determines.

        Args:
            points: shape (members, size); each row has the knots of the first entry of the action, then of the second.

        Returns:
            Shape (members, steps, entries).
        """
        knots = np.clip(points, self.lowest, self.highest).reshape(len(points), self.entries, self.knots)
        before, after, part = self._knot_weights()
        wished = np.zeros((len(points), self.steps, self.entries))
        between = knots[:, :, before] + part * (knots[:, :, after] - knots[:, :, before])
        wished[:, : len(part)] = between.transpose(0, 2, 1)
        return wished if self.rate is None else _limit_rate(wished, self.rate)

    def pullback(self, point: FloatArray, slopes: FloatArray) -> FloatArray:
        """Return the derivatives of a function of the drive with respect to the point, shape (size,).

        Args:
            point: shape (size,).
            slopes: derivatives of the function with respect to the drive, shape (steps, entries).
        """
        if self.rate is not None:
            unlimited = replace(self, rate=None)
            slopes = _limit_rate_pullback(unlimited.actions(point[None])[0], slopes, self.rate)
        before, after, part = self._knot_weights()
        pulled = np.zeros((self.entries, self.knots))
        for entry in range(self.entries):
            along = slopes[: len(part), entry]
            np.add.at(pulled[entry], before, (1.0 - part) * along)
            np.add.at(pulled[entry], after, part * along)
        return pulled.reshape(-1)

    def fit_point(self, actions: FloatArray) -> FloatArray:
        """Return the point whose drive fits the given actions best in the least-squares sense, shape (size,).

        Args:
            actions: shape (any number of control steps, entries); the actions of missing steps count as 0.
        """
        before, after, part = self._knot_weights()
        wished = np.zeros((self.steps, self.entries))
        wished[: len(actions)] = actions[: self.steps]
        weights = np.zeros((len(part), self.knots))
        weights[np.arange(len(part)), before] = 1.0 - part
        weights[np.arange(len(part)), after] += part
        # Solve the normal equations without LAPACK, whose rounding depends on the machine; trials are compared bitwise.
        pivot, side = (weights * weights).sum(axis=0), (weights[:, :-1] * weights[:, 1:]).sum(axis=0)
        knots = (weights[:, :, None] * wished[: len(part), None, :]).sum(axis=0)
        for k in range(1, self.knots):
            factor = side[k - 1] / pivot[k - 1]
            pivot[k] -= factor * side[k - 1]
            knots[k] -= factor * knots[k - 1]
        knots[-1] /= pivot[-1]
        for k in reversed(range(self.knots - 1)):
            knots[k] = (knots[k] - side[k] * knots[k + 1]) / pivot[k]
        return np.clip(knots.T.reshape(-1), self.lowest, self.highest)

    def _knot_weights(self) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], FloatArray]:
        """Return for each driven step the knots before and after it, and its position between them (0 to 1), each (driven,)."""
        driven = min(self.driven or self.steps, self.steps)
        step = np.arange(driven)
        if self.between == "held" or self.knots == 1:
            before = step * self.knots // driven
            return (before, before, np.zeros(driven))
        along = step * (self.knots - 1) / max(driven - 1, 1)
        before = np.minimum(along.astype(np.int64), self.knots - 2)
        return (before, before + 1, along - before)


def _limit_rate(requested: FloatArray, rate: float) -> FloatArray:
    followed, last = np.empty_like(requested), np.zeros((len(requested), requested.shape[2]))
    for step in range(requested.shape[1]):
        last = last + np.clip(requested[:, step] - last, -rate, rate)
        followed[:, step] = last
    return followed


def _limit_rate_pullback(requested: FloatArray, slopes: FloatArray, rate: float) -> FloatArray:
    """Return derivatives with respect to `requested` from those with respect to the actions after the rate limit (`slopes`)."""
    followed = _limit_rate(requested[None], rate)[0]
    before = np.vstack([np.zeros((1, requested.shape[1])), followed[:-1]])
    free = np.abs(requested - before) < rate
    pulled, carried = np.zeros_like(slopes), np.zeros(slopes.shape[1])
    for step in reversed(range(len(slopes))):
        carried = carried + slopes[step]
        pulled[step] = np.where(free[step], carried, 0.0)
        carried = np.where(free[step], 0.0, carried)
    return pulled
