"""The header (first record) of a log: component, machine, versions and recorded variables."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import platform
import sys
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from ..components.balances import Balance
from ..components.component import Component
from ..components.errors import ParameterError
from ..components.variables import Variable
from .drawables import drawable_facts
from .records import FORMAT, damage_error

METADATA_NAME = "granular-env"
_LONGEST = 20_000
_PACKAGES = ("granular-env", "numpy", "numba", "llvmlite", "mcap")
_VARIABLES = ("header", "variables")


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that affect the bits of results."""
    return {"python": platform.python_version(), **{name: _package_version(name) for name in _PACKAGES}}


@cache
def _package_version(name: str) -> str:
    # Looking up a version reads files of the installation, which takes longer than the rest of opening a log.
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def machine_facts() -> dict[str, Any]:
    """Return the machine's data for the header: CPU, architecture, operating system, cores, and settings of numba."""
    return {
        "cpu": _cpu_model(),
        "architecture": platform.machine(),
        "system": platform.system(),
        "cores": os.cpu_count() or 1,
        "numba_threads": os.environ.get("NUMBA_NUM_THREADS", ""),
        "numba_jit": os.environ.get("NUMBA_DISABLE_JIT", "0") != "1",
    }


@cache
def _cpu_model() -> str:
    try:
        with open("/proc/cpuinfo", encoding="utf-8", errors="replace") as lines:
            return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), "")
    except OSError:
        return platform.processor()


def variable_facts(variable: Variable) -> dict[str, Any]:
    """Return the declaration of a variable (name, unit, shape, ...) as JSON values for the header."""
    names = ("name", "causality", "unit", "dtype", "description", "state", "variability", "nominal")
    facts = {name: getattr(variable, name) for name in names}
    return {**facts, "shape": list(variable.shape), "axes": list(variable.axes)}


def parse_variable(facts: Mapping[str, Any]) -> Variable:
    """Return the variable declared by JSON values from `variable_facts`; raise `LogError` for other values."""
    try:
        shape = tuple(facts["shape"])
        texts, axes = [facts[key] for key in ("name", "causality", "unit", "description", "dtype")], tuple(facts["axes"])
        is_sound = len(shape) <= 4 and all(type(extent) is int and 0 <= extent < 2**40 for extent in shape)
        is_sound &= all(isinstance(text, str) for text in (*texts, *axes)) and len(axes) in (0, len(shape))
        if not is_sound or texts[4] not in ("float64", "int64"):
            raise damage_error("a variable has an invalid shape, text, dtype or axes", _VARIABLES)
        name, causality, unit, description, dtype = texts
        return Variable(name, causality, unit, shape, description, dtype, state=bool(facts["state"]), axes=axes)
    except (KeyError, TypeError) as error:
        raise damage_error(f"the description of a variable is invalid: {error}", _VARIABLES) from error


def header_table(value: Any) -> dict[str, Any]:
    """Return a value of the header if it is a mapping; otherwise an empty mapping."""
    return dict(value) if isinstance(value, dict) else {}


def make_header(
    component: Component, recorded: Sequence[str], options: Mapping[str, Any], experiment: Any, parent: Any, elapsed: int
) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return the JSON values and the arrays of the header for a new log of this component."""
    drawables, arrays = drawable_facts(component.drawables())
    header = {
        "format": FORMAT,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "component": component.name,
        "version": component.version,
        "parameters": component.parameters.model_dump(mode="json"),
        "identity": component.identity,
        "step_size": component.step_size,
        "variables": [variable_facts(component.variables[name]) for name in recorded],
        "inputs": [variable_facts(v) for v in component.variables.values() if v.causality == "input"],
        "state": [v.name for v in component.variables.values() if v.state],
        "balances": [balance_facts(balance) for balance in component.balances()],
        "event_kinds": dict(component.event_kinds),
        "event_details": {kind: dataclasses.asdict(detail) for kind, detail in component.event_details.items()},
        "drawables": drawables,
        "elapsed": elapsed,
        "options": dict(options),
        "experiment": experiment,
        "parent": parent,
        "versions": versions(),
        "machine": machine_facts(),
        "command": "granular-env" if "granular-env" in os.path.basename(sys.argv[0] or "") else "script",
    }
    return header, arrays


@dataclasses.dataclass(frozen=True, slots=True)
class BalanceNames:
    """Names of the variables of a balance (such as of energy), in the order of `balances.Balance`; all have the same unit."""

    quantity: str
    unit: str
    stored: tuple[str, ...]
    lost: tuple[str, ...]
    supplied: tuple[str, ...]

    @property
    def residual(self) -> str:
        """Name of the variable with the balance's residual, by which its entries fail to add up."""
        return f"{self.quantity}_residual"

    @property
    def entries(self) -> tuple[str, ...]:
        """Names of the balance's variables except the residual."""
        return (*self.stored, *self.lost, *self.supplied)


def parse_balance_names(facts: Any) -> tuple[BalanceNames, ...]:
    """Return the variable names of each balance from JSON values of `balance_facts`; raise `LogError` for other values."""
    try:
        found = [
            BalanceNames(one["quantity"], one["unit"], *(tuple(one[part]) for part in ("stored", "lost", "supplied")))
            for one in facts
        ]
    except (KeyError, TypeError) as error:
        raise damage_error(f"the description of a balance is invalid: {error}", "header.balances") from error
    if not all(isinstance(name, str) for one in found for name in (one.quantity, one.unit, *one.entries)):
        raise damage_error("a name in a balance is not a string", "header.balances")
    return tuple(found)


def balance_quantities(facts: Any) -> dict[str, str]:
    """Return name of a balance's variable -> quantity of the balance, from JSON values of `balance_facts`."""
    return {name: one.quantity for one in parse_balance_names(facts) for name in (*one.entries, one.residual)}


def balance_facts(balance: Balance) -> dict[str, Any]:
    """Return the names of a balance's variables as JSON values."""
    parts = {name: list(getattr(balance, name)) for name in ("stored", "lost", "supplied")}
    return {"quantity": balance.quantity, "unit": balance.unit, **parts}


def closing_facts(component: Component) -> dict[str, Any]:
    """Return the JSON values written at the end of a log: the component's report, conclusions and cautions."""
    report = {name: float(value) for name, value in component.report().items()}
    return {
        "report": {name: value if math.isfinite(value) else str(value) for name, value in report.items()},
        "conclusions": list(component.conclusions()),
        "cautions": list(component.cautions()),
    }


def plain_json(name: str, value: Any) -> Any:
    """Return a value converted to JSON types; raise `ParameterError` with its `name` if that is impossible."""
    try:
        return json.loads(json.dumps(value, allow_nan=False))
    except (TypeError, ValueError, RecursionError) as error:
        raise ParameterError(str(error), hint="expected dicts, lists, strings and finite numbers", at=name) from None


def make_metadata(header: Mapping[str, Any]) -> dict[str, str]:
    """Return the texts of the MCAP Metadata record, which stock tools show: the entries of the header, as JSON.

    Long texts, such as the radii of many grains, are truncated; the header has the full text.
    """
    texts = {name: value if isinstance(value, str) else json.dumps(value) for name, value in header.items()}
    return {name: text if len(text) <= _LONGEST else f"{text[:_LONGEST]}\u2026" for name, text in texts.items()}


def header_title(header: Mapping[str, Any]) -> str:
    """Return the name of the experiment or, without one, of the component."""
    experiment = header.get("experiment")
    named = experiment.get("name") if isinstance(experiment, Mapping) else None
    return str(named or header.get("component") or "run")
