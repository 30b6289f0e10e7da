"""The record of a trial, one method with one seed: every evaluation, the best so far, and what a method needs to go on.

Kept as packed arrays with a JSON header (`components/support/serialization.py`), never as a pickle, and written whole or not
at all: a kill at any moment leaves the file of a moment before.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.components.errors import ExperimentError, Fault, LogError, Option
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.serialization import digest, pack, unpack
from granular_env.output_files import replacing

START_ANEW = ("pass ", Option("overwrite"), " to start anew")
_FORMAT, _VERSION = "granular-env trial", 1
RETURN, SLOPES, TRAINING, PLAYED = 0, 1, 2, 3
"""Kinds of evaluation: a return, an objective with its slopes, a policy's training, a baseline that was looked at."""


def fingerprint(point: FloatArray) -> int:
    """Return a number that changes when any bit of a point does."""
    return int.from_bytes(digest(np.ascontiguousarray(point, dtype="<f8").tobytes()), "little")


class TrialRecord:
    """The record of a trial.

    Attributes:
        best: the arrays of the best so far: ``{"point": ...}``, or a policy's weights.
        best_return: its return, averaged over the search's episodes; -inf where nothing has one.
        agent: arrays that a method goes on from (a policy in training).
        notes: numbers and words for the results.
        finished: whether the method has ended.
    """

    def __init__(self) -> None:
        self._kinds: list[int] = []
        self._points: list[int] = []
        self._values: list[float] = []
        self._steps: list[int] = []
        self._slopes: list[FloatArray] = []
        self.best: dict[str, npt.NDArray[Any]] = {}
        self.best_return = -math.inf
        self.agent: dict[str, npt.NDArray[Any]] = {}
        self.notes: dict[str, Any] = {}
        self.finished = False
        self.spent = 0

    def __len__(self) -> int:
        return len(self._kinds)

    def add(self, kind: int, point: FloatArray | None, value: float, steps: int, slopes: FloatArray | None = None) -> None:
        """One more evaluation, which simulated so many control steps."""
        self._kinds.append(kind)
        self._points.append(0 if point is None else fingerprint(point))
        self._values.append(value)
        self._steps.append(steps)
        self.spent += steps
        if slopes is not None:
            self._slopes.append(np.array(slopes))
        if kind == RETURN and point is not None and value > self.best_return:
            self.keep({"point": np.array(point)}, value)

    def keep(self, arrays: Mapping[str, npt.NDArray[Any]], value: float) -> None:
        """Keep what is the best from now on."""
        self.best, self.best_return = dict(arrays), value

    def value(self, place: int, kind: int, point: FloatArray) -> float:
        """Return the value of the evaluation at a place; `ExperimentError` where it was of another point."""
        if self._kinds[place] != kind or self._points[place] != fingerprint(point):
            other = (
                f"evaluation {place + 1} of the record is of another point than the method asks for now: it was made with "
                "other versions of numpy, scipy or cma, or on a machine that computes differently"
            )
            raise ExperimentError(Fault(received=other, hint=START_ANEW))
        return self._values[place]

    def slopes(self, place: int) -> FloatArray:
        """Return the slopes of the evaluation at a place, one of the kind `SLOPES`."""
        return self._slopes[self._kinds[:place].count(SLOPES)]

    @property
    def is_flat(self) -> bool:
        """Return whether slopes were asked for, and all of them are 0."""
        return bool(self._slopes) and not np.any(self._slopes)

    def count(self, kind: int) -> int:
        """Return the number of evaluations of a kind."""
        return self._kinds.count(kind)

    def curve(self) -> tuple[npt.NDArray[np.int64], FloatArray]:
        """Control steps simulated so far, and the best return until then, at every evaluation of a return."""
        chosen = np.array(self._kinds) == RETURN
        spent = np.cumsum(np.array(self._steps, dtype=np.int64))[chosen]
        return spent, np.maximum.accumulate(np.array(self._values)[chosen]) if chosen.any() else np.empty(0)

    # -- files ------------------------------------------------------------------------------------------------------

    def save(self, path: Path, owner: Mapping[str, Any]) -> None:
        """Write all of it; `owner` says whose it is (study, method, seed)."""
        header = {
            "format": _FORMAT, "version": _VERSION, "owner": dict(owner), "notes": self.notes, "finished": self.finished,
            "best_return": None if math.isinf(self.best_return) else self.best_return,
        }  # fmt: skip
        arrays: dict[str, npt.NDArray[Any]] = {
            "kinds": np.array(self._kinds, dtype=np.uint8),
            "points": np.array(self._points, dtype=np.uint64),
            "values": np.array(self._values, dtype=np.float64),
            "steps": np.array(self._steps, dtype=np.int64),
            "slopes": np.array(self._slopes, dtype=np.float64),
            **{f"best/{name}": array for name, array in self.best.items()},
            **{f"agent/{name}": array for name, array in self.agent.items()},
        }
        with replacing(path, ExperimentError) as part:
            with part.open("wb") as file:
                file.write(pack(header, arrays))
                file.flush()
                os.fsync(file.fileno())

    @classmethod
    def load(cls, path: Path, owner: Mapping[str, Any]) -> TrialRecord:
        """Return a record from its file.

        Raises:
            ExperimentError: it is no such file, is damaged, or belongs to another study.
        """
        try:
            header, arrays = unpack(path.read_bytes())
        except (OSError, LogError) as error:
            raise ExperimentError(Fault(received=f"cannot be read: {error}", hint=START_ANEW, source=str(path))) from error
        if header.get("format") != _FORMAT or header.get("version") != _VERSION:
            came = f"{header.get('format')!r} of version {header.get('version')!r}"
            raise ExperimentError(
                f"it is {came}", expected=f"{_FORMAT!r} of version {_VERSION}", hint=START_ANEW, source=str(path)
            )
        if header.get("owner") != dict(owner):
            hint = ("choose another folder, or ", *START_ANEW)
            raise ExperimentError(Fault(received="it belongs to another study", hint=hint, source=str(path)))
        try:
            return cls._from_arrays(header, arrays)
        except (KeyError, TypeError, ValueError) as error:
            fault = Fault(received=f"it is no whole record: {error}", hint=START_ANEW, source=str(path))
            raise ExperimentError(fault) from error

    @classmethod
    def _from_arrays(cls, header: Mapping[str, Any], arrays: Mapping[str, npt.NDArray[Any]]) -> TrialRecord:
        record = cls()
        record._kinds, record._points = arrays["kinds"].tolist(), arrays["points"].tolist()
        record._values, record._steps = arrays["values"].tolist(), arrays["steps"].tolist()
        if len({len(record._kinds), len(record._points), len(record._values), len(record._steps)}) > 1:
            raise ValueError("its columns have different lengths")
        record._slopes = list(arrays["slopes"])
        record.spent, record.finished, record.notes = sum(record._steps), bool(header["finished"]), dict(header["notes"])
        record.best_return = -math.inf if header["best_return"] is None else float(header["best_return"])
        for name, array in arrays.items():
            what, _, rest = name.partition("/")
            if what in ("best", "agent"):
                getattr(record, what)[rest] = array
        return record


def load_or_start(path: Path, owner: Mapping[str, Any]) -> TrialRecord:
    """Return the record of a trial that goes on, or an empty one where there is no file yet."""
    return TrialRecord.load(path, owner) if path.exists() else TrialRecord()
