"""Parameters at and beyond their limits: a component is built and steps, or an error names the refused parameter."""

from __future__ import annotations

import copy
import math
import random
import signal
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
from support import tube_tools

import granular_env as ge
from granular_env.components.catalogue import component_class
from granular_env.components.errors import GranularWarning, ParameterError, StepError
from granular_env.components.support import memory_limits

Path = tuple[str | int, ...]
# A component, its parameters, and the changes to them.
Case = tuple[str, dict[str, Any], dict[Path, Any]]

# Smaller and larger than any physical value, denormal, not finite, and of another type.
NUMBERS = [
    0.0, -0.0, -1.0, 5e-324, 1e-300, 1e-100, 1e-41, 1e-39, 1e-18, 1e-9, 1.0, 1e9, 1e18, 1e39, 1e41, 1e100, 1e300, 1.7e308,
    math.nan, math.inf, -math.inf, -1e300, 10**400,
]  # fmt: skip
COUNTS = [-1, 0, 1, 2, 3, 4, 5, 9, 10, 2**31, 2**63, 10**18, 10**400, 2.5]
OTHERS = [None, True, "abc", "", [], {}, [1.0], [1.0, 2.0, 3.0], {"name": "abc"}, {"name": None}, [math.nan, 0.0]]
# Factors that make a set of parameters inconsistent: values close to the valid one.
FACTORS = [0.5, 0.999, 1.001, 2.0, 1e-3, 1e3, -1.0]
LARGEST_STATE, LONGEST = 50_000_000, 10.0

NOTCH = {"length": 0.003, "depth": 0.0004, "width": 0.0004, "around": 0.003, "columns": 1}
PLATE = {"name": "plate", "length": 0.006, "width": 0.006, "along": 13, "across": 13, "notch": NOTCH}
BRITTLE = {"name": "principal_stress", "stress": 2.2e7, "scatter": 0.1, "grip_length": 1e-3}
TUBE_NOTCH = {**NOTCH, "around": 0.5 * math.pi}
NOTCHED_TUBE = {**tube_tools.BODY, "along": 13, "around": 13, "notch": TUBE_NOTCH}
# Parameter tables that cover every kind of sub-table.
BASES: dict[str, list[dict[str, Any]]] = {
    "detonation": [
        {"length": 0.03, "cells": 60, "regions": [tube_tools.HOT], "gauges": [0.01, 0.02],
         "right": {"name": "diaphragm", "burst_pressure": 3e5}},
        {"length": 0.03, "cells": 60, "gas": {"gamma": 1.2, "gas_constant": 280.0, "heat_release": 4e6}, 
         "left": "open", "reaction": "arrhenius", "cross_section": [1e-3] * 60},
        {"length": 0.03, "cells": 60, "gas": {"gamma": 1.4}, "left": "piston",
         "regions": [{"x": [0.0, 0.01], "velocity": 100.0}]},
        {"length": 0.03, "cells": 60, "reaction": "constant_volume", "right": "absorbing", "limiter": "minmod"},
    ],
    "shell": [
        {"body": PLATE, "material": "thermoviscoplastic", "boundaries": {"start": "clamped", "end": "platen"},
         "fracture": BRITTLE, "gauges": [[0.002, 0.002]]},
        {"body": NOTCHED_TUBE, "boundaries": {"start": "clamped"}, "fracture": BRITTLE},
        {"body": {"name": "tube", "along": 4, "around": 12, "layers": 2}, "gauges": [[0.0, 0.0]]},
        {"body": {"name": "rod", "along": 6, "across": 4}, "material": "thermoviscoplastic", "boundaries": {"start": "wall"},
         "fracture": {"name": "plastic_strain"}},
        {"body": {"name": "plate", "along": 7, "across": 7}, "basis": "quadratic", "boundaries": {"left": "moved"},
         "integration": {"surface": "cell", "through": 2}},
    ],
    "tube": [
        {"gas": tube_tools.GAS, "shell": {"body": tube_tools.BODY, "boundaries": {"start": "clamped", "end": "symmetry"}},
         "position": 0.0152, "vent": 0.01},
        {"gas": tube_tools.GAS, "shell": {"body": NOTCHED_TUBE, "material": "thermoviscoplastic", "fracture": BRITTLE},
         "position": 0.0152, "coupling": "two_way", "outside_pressure": 1e5},
    ],
}  # fmt: skip


def full_tables() -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield component and parameters, with all parameters given."""
    for name, bases in BASES.items():
        for base in bases:
            yield name, component_class(name).Parameters(**base).model_dump()


def leaves(given: Any, path: Path = ()) -> Iterator[Path]:
    """Yield the paths of all values of a table, including nested tables."""
    if path:
        yield path
    parts = given.items() if isinstance(given, dict) else enumerate(given[:2]) if isinstance(given, list) else ()
    for key, value in parts:
        yield from leaves(value, (*path, key))


def value_at(given: Any, path: Path) -> Any:
    for key in path:
        given = given[key]
    return given


def extremes(value: Any) -> list[Any]:
    """Return extreme replacements for a value."""
    if isinstance(value, bool | str) or value is None:
        return [*OTHERS, *NUMBERS]
    if isinstance(value, int):
        return [*COUNTS, value - 1, value + 1, *OTHERS]
    if isinstance(value, float):
        return [*NUMBERS, *(value * factor for factor in FACTORS), *OTHERS]
    return OTHERS


@contextmanager
def limits(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Let warnings, long runs and large memory requests fail."""

    def end(*_: object) -> None:
        raise AssertionError(f"not done after {LONGEST:g} s")

    monkeypatch.setattr(memory_limits, "available_memory", lambda: LARGEST_STATE)
    before = signal.signal(signal.SIGALRM, end)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", GranularWarning)
            yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def names_a_parameter(error: ParameterError, name: str) -> bool:
    """Return whether each fault names a parameter of the component or a lack of memory."""
    known = component_class(name).Parameters.model_fields
    return all(
        (fault.location and str(fault.location[0]) in known)
        or any(str(fault).removeprefix(f"component {name!r}: ").startswith(one) for one in known)
        or "GB of memory" in str(fault)
        for fault in error.faults
    )


def attempt(name: str, given: dict[str, Any]) -> bool:
    """Build and use a component; return whether it could be built."""
    signal.setitimer(signal.ITIMER_REAL, LONGEST)
    try:
        component = ge.make(name, **given)
    except ParameterError as error:
        assert names_a_parameter(error, name), str(error)
        return False
    try:
        component.step(component.step_size)
    except StepError as error:
        assert error.faults[0].location, str(error)
    for variable in component.variables.values():
        if variable.causality != "parameter":
            value = np.asarray(component.get(variable.name), dtype=np.float64)
            assert not np.isnan(value).any(), variable.name
            assert (value >= variable.minimum).all(), (variable.name, value.min())
    component.report(), component.cautions(), component.conclusions(), component.drawables()
    return True


def random_changes(seed: int, count: int) -> Iterator[Case]:
    """Yield tables with one to three changed values, which may contradict each other."""
    source, tables = random.Random(seed), list(full_tables())
    for _ in range(count):
        name, given = source.choice(tables)
        # Change only leaves, never a table together with a value in it.
        paths = [path for path in leaves(given) if not isinstance(value_at(given, path), dict | list)]
        chosen = source.sample(paths, source.randint(1, 3))
        changes = {path: source.choice(extremes(value_at(given, path))) for path in chosen}
        yield name, changed(given, changes), changes


def changed(given: dict[str, Any], changes: dict[Path, Any]) -> dict[str, Any]:
    found = copy.deepcopy(given)
    for path, value in changes.items():
        value_at(found, path[:-1])[path[-1]] = value
    return found


def try_all(cases: Iterator[Case]) -> tuple[int, int]:
    """Return the number of built cases and the number of refused cases."""
    built = refused = 0
    for name, given, changes in cases:
        try:
            was_built = attempt(name, given)
        except Exception as error:
            raise AssertionError(f"{type(error).__name__} came out of {name} with {changes}: {error}") from error
        built, refused = built + was_built, refused + (not was_built)
    return built, refused


def test_a_body_that_breaks_everywhere_has_no_piece() -> None:
    body = {"name": "plate", "along": 5, "across": 5, "length": 0.004, "width": 0.004}
    plate = ge.make("shell", body=body, fracture={"name": "principal_stress", "stress": 1e-22})
    plate.reset(nodal_velocity=np.random.default_rng(1).normal(size=plate.nodes.shape))
    plate.step(80 * plate.step_size)
    assert plate.get("pieces") == plate.variables["pieces"].minimum == 0.0


def test_extreme_parameters_are_refused_by_name_or_work(monkeypatch: pytest.MonkeyPatch) -> None:
    with limits(monkeypatch):
        built, refused = try_all(random_changes(seed=1, count=60))
    assert built >= 3 and refused >= 40


@pytest.mark.slow
def test_thousands_of_inconsistent_sets_are_refused_by_name_or_work(monkeypatch: pytest.MonkeyPatch) -> None:
    with limits(monkeypatch):
        built, refused = try_all(random_changes(seed=2, count=10_000))
    assert built > 500 and refused > 5000
