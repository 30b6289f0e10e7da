"""Actions on hostile logs, and false array metadata with valid checksums."""

from __future__ import annotations

import dataclasses
import random
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from granular_env import viewing
from granular_env.components.errors import GranularError
from granular_env.recording import open_log, recover, verify
from granular_env.recording.near_misses import find_near_misses
from granular_env.recording.records import Record

ACTIONS: dict[str, Callable[[Path], object]] = {
    "verify": verify,
    "series": lambda path: [open_log(path).series(name) for name in open_log(path).variables],
    "inputs": lambda path: [list(open_log(path).input_intervals(name)) for name in open_log(path).input_variables],
    "drawables": lambda path: open_log(path).drawables,
    "events": lambda path: open_log(path).events(),
    "xarray": lambda path: open_log(path).to_xarray(),
    "export": lambda path: open_log(path).export("vtk", path.with_suffix(".vtk"), overwrite=True),
    "recover": lambda path: recover(path, path.with_suffix(".out"), overwrite=True),
    "branch": lambda path: open_log(path).branch(0.0).run(path.with_suffix(".child"), overwrite=True),
}
# Actions that draw a log, a few seconds each.
VIEWS: dict[str, Callable[[Path], object]] = {
    "report": lambda path: viewing.report(open_log(path), path.with_suffix("")),
    "rerun": lambda path: viewing.save_rrd(open_log(path), path.with_suffix(".rrd")),
    "nearest": lambda path: find_near_misses(open_log(path)),
}
# Integers and float bit patterns that are invalid or absurdly large; none that would mean hours of legitimate work.
_WILD = (0, -1, 1, 2, 7, 2**53, 2**61, 2**62, 2**63 - 1, 0x7FF8000000000000, 0x7FF0000000000000, 0x7FEFFFFFFFFFFFFF)
_JSON = (None, True, -1, 0, 3, 1.5, float("1e308"), "", "x", [], {}, [[]], {"a": [None]}, [1, "a"], 2**70)


def count_refusals(path: Path, actions: Iterable[Callable[[Path], object]] = ACTIONS.values()) -> int:
    """Return the number of refused actions; any exception other than GranularError fails the test."""
    refused = 0
    for action in actions:
        try:
            action(path)
        except GranularError as error:
            assert str(error)
            refused += 1
    return refused


def corrupt_record(record: Record, chance: random.Random) -> Record:
    """Return a record with one change: a number in an array, its shape or dtype, or a header value."""
    names = sorted(record.arrays)
    if record.header and (not names or chance.random() < 0.4):
        return dataclasses.replace(record, header=_corrupt_json(dict(record.header), chance))
    if not names:
        return record
    name = chance.choice(names)
    return dataclasses.replace(record, arrays={**record.arrays, name: _corrupt_array(np.array(record.arrays[name]), chance)})


def _corrupt_array(array: np.ndarray, chance: random.Random) -> np.ndarray:
    kind = chance.randrange(7)
    if kind <= 2 and array.size and array.dtype.itemsize == 8:
        array.view(np.int64).reshape(-1)[chance.randrange(array.size)] = chance.choice(_WILD)
        return array
    if kind == 3 and array.ndim:
        return array[: chance.randrange(len(array) + 1)]
    if kind == 4 and array.ndim:
        return np.concatenate([array, array[:1]])
    if kind == 5:
        return array.reshape(-1) if array.ndim > 1 else array.reshape(1, -1) if array.ndim else np.repeat(array, 3)
    with np.errstate(all="ignore"):
        return array.astype(np.int64 if array.dtype.kind == "f" else np.float64)


def _corrupt_json(content: Any, chance: random.Random) -> Any:
    """Replace one value at any depth, or remove a key."""
    if isinstance(content, dict) and content:
        key = chance.choice(sorted(content))
        if chance.random() < 0.15:
            return {name: value for name, value in content.items() if name != key}
        deeper = isinstance(content[key], (dict, list)) and chance.random() < 0.7
        return {**content, key: _corrupt_json(content[key], chance) if deeper else chance.choice(_JSON)}
    if isinstance(content, list) and content:
        place = chance.randrange(len(content))
        return [*content[:place], _corrupt_json(content[place], chance), *content[place + 1 :]]
    return chance.choice(_JSON)
