"""Forged states: snapshots with valid checksums but numbers or list lengths that no component saved."""

from __future__ import annotations

import os
import pickle
import random
import signal
import sys
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from granular_env.components.component import Component
from granular_env.components.errors import GranularError
from granular_env.components.snapshot import Snapshot

_WHOLE = (-1, -2, 0, 1, 2, 3, 5, 17, 100, 1000, 10**6, 10**9, 2**31, -(2**31), 2**40, -(2**40), 2**53, 2**62, -(2**63))
_FLOATS = (
    float("nan"), float("inf"), -float("inf"), 1e300, -1e300, 1e308, 1e154, -1e154, 1e18, -1e18, 1e9, 1e6, 17.0, 2.0, 1.0, 0.5,
    0.0, -0.0, -0.25, -1.0, -2.0, 1e-9, 1e-300, 5e-324,
)  # fmt: skip
# A case that takes longer than this counts as hanging [s].
_PATIENCE = 60


def forge_snapshot(component: Component, snapshot: Snapshot, chance: random.Random) -> Snapshot:
    """Return a snapshot with some numbers of an array replaced, or with rows added to or removed from a list."""
    block = component._block  # noqa: SLF001
    whole = [block, *_all_parts(component)]
    arrays = {
        (number, name): array.copy()
        for number, one in enumerate(whole)
        for name, array in block.state_arrays(snapshot.data, one).items()
    }
    covered = {(0, name) for name in block.views if name not in block.fields}  # memory of the parts
    covered |= {key for key in arrays if key[1] == "_counts"}
    lists = [(whole.index(one), name) for one, name in block._tables]  # noqa: SLF001
    choices = [key for key in arrays if key not in covered and arrays[key].size]
    whole_numbers = [key for key in choices if arrays[key].dtype.kind in "iu" or key in lists]
    if lists and chance.random() < 0.3:
        _change_length(arrays, lists, chance)
    else:
        key = chance.choice(whole_numbers if whole_numbers and chance.random() < 0.4 else choices)
        flat = arrays[key].reshape(-1)
        for _ in range(chance.choice((1, 1, 2, 5, 50))):
            flat[chance.randrange(flat.size)] = _wild_value(flat.dtype, chance)
    return _assemble_snapshot(component, snapshot, whole, arrays, lists, covered)


def _all_parts(component: Component) -> Iterable[Any]:
    for part, _, _ in component._included:  # noqa: SLF001
        yield part._block  # noqa: SLF001
        yield from _all_parts(part)


def _wild_value(dtype: np.dtype, chance: random.Random) -> Any:
    if dtype.kind == "i":
        return chance.choice(_WHOLE)
    return float(chance.choice(_WHOLE)) if chance.random() < 0.3 else chance.choice(_FLOATS)


def _change_length(arrays: dict[Any, np.ndarray], lists: list[Any], chance: random.Random) -> None:
    """Add rows to a list or remove rows, sometimes for all lists of its component."""
    key = chance.choice(lists)
    some = [one for one in lists if one[0] == key[0]] if chance.random() < 0.5 else [key]
    more = chance.choice((-100, -2, -1, 1, 2, 3, 100))
    for one in some:
        rows = arrays[one]
        if more < 0:
            arrays[one] = rows[: max(len(rows) + more, 0)]
            continue
        added = np.zeros((more, *rows.shape[1:]), rows.dtype)
        if len(rows) and chance.random() < 0.5:
            added[:] = rows[[chance.randrange(len(rows)) for _ in range(more)]]
        flat = added.reshape(-1)
        for place in range(flat.size):
            if chance.random() < 0.2:
                flat[place] = chance.randrange(4) if chance.random() < 0.5 else _wild_value(flat.dtype, chance)
        arrays[one] = np.concatenate([rows, added])


def _assemble_snapshot(
    component: Component,
    snapshot: Snapshot,
    whole: list[Any],
    arrays: dict[Any, np.ndarray],
    lists: list[Any],
    covered: set[Any],
) -> Snapshot:
    block = component._block  # noqa: SLF001
    words = np.frombuffer(snapshot.data, np.int64)[: block.memory.size].copy()
    for number, one in enumerate(whole):
        start = block._first_word(one)  # noqa: SLF001
        for name, view in one.views.items():
            if (number, name) not in covered:
                begin = start + one._words[name]  # noqa: SLF001
                words[begin : begin + view.size] = arrays[number, name].reshape(-1).view(np.int64)
    for number, name in lists:
        one = whole[number]
        words[block._count_word(one, name)] = len(arrays[number, name])  # noqa: SLF001
    data = b"".join([words.tobytes(), *(arrays[key].tobytes() for key in lists)])
    return Snapshot(snapshot.identity, snapshot.tick, data, snapshot.inputs)


def try_snapshot(component: Component, snapshot: Snapshot) -> str:
    """Restore a forged state, step, and read all variables; return the outcome "refused", "failed" or "lasted"."""
    try:
        component.restore(Snapshot.from_bytes(snapshot.to_bytes()))
    except GranularError:
        return "refused"
    _read_all_variables(component)
    try:
        for ticks in (1, 2, 7, 20):
            component.step(ticks * component.step_size)
    except GranularError:
        _read_all_variables(component)
        return "failed"
    _read_all_variables(component)
    return "lasted"


def _read_all_variables(component: Component) -> None:
    """Read all variables; GranularError is allowed for values that the state does not determine."""
    outputs = [name for name, variable in component.variables.items() if variable.causality != "parameter"]
    readings: list[Callable[[], Any]] = [lambda name=name: component.get(name) for name in outputs]
    for read in (
        *readings, component.events, component.balances, component.report, component.conclusions, component.cautions,
        component.drawables, lambda: Snapshot.from_bytes(component.save().to_bytes()),
    ):  # fmt: skip
        try:
            read()
        except GranularError:
            pass


def outcomes(cases: int, run: Callable[[int], str]) -> tuple[Counter[str], list[str]]:
    """Run cases in forked child processes, so that a signal ends only the child.

    Args:
        cases: number of cases.
        run: takes the number of a case and returns its outcome.

    Returns:
        The count of each outcome, and the cases that ended in a signal or in an error other than GranularError.
    """
    found, bad, first = Counter[str](), list[str](), 0
    while first < cases:
        ends, status = _run_in_child(range(first, cases), run)
        for number, end in ends:
            found[end.partition(":")[0]] += 1
            if end.startswith("escaped"):
                bad.append(f"case {number}: {end}")
        first = ends[-1][0] + 1 if ends else first
        if os.WIFSIGNALED(status) or os.WEXITSTATUS(status):
            how = f"signal {os.WTERMSIG(status)}" if os.WIFSIGNALED(status) else f"exit {os.WEXITSTATUS(status)}"
            found["killed"] += 1
            bad.append(f"case {first}: {how}")
            first += 1
    return found, bad


def _run_in_child(numbers: Iterable[int], run: Callable[[int], str]) -> tuple[list[tuple[int, str]], int]:
    """Return the outcomes of the cases until the child ended, and its status."""
    here, there = os.pipe()
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        os.close(here)
        with os.fdopen(there, "wb") as told, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for number in numbers:
                signal.alarm(_PATIENCE)
                try:
                    end = run(number)
                except GranularError as error:
                    end = f"family: {error}"
                except BaseException as error:
                    place = traceback.extract_tb(error.__traceback__)[-1]
                    end = f"escaped: {type(error).__name__} {error} at {place.filename}:{place.lineno}"
                pickle.dump((number, end), told)
                told.flush()
        os._exit(0)
    os.close(there)
    ends: list[tuple[int, str]] = []
    with os.fdopen(here, "rb") as told:
        while True:
            try:
                ends.append(pickle.load(told))
            except EOFError:
                break
    return ends, os.waitpid(child, 0)[1]
