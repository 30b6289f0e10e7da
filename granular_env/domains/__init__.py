"""Domains, one folder for each physical system, and the table of what each offers to the generic packages.

Only domains name a physical system. The generic packages (environments, studies, sweeps, viewing) import this module but no
domain: `find_domain` returns the `Domain` of a component. An offer is given as the name of a module or "module:attribute",
which is imported on first use. If it is None, the generic package uses its default or reports that the offer is missing.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from types import ModuleType
from typing import Any


@dataclass(frozen=True)
class Environment:
    """A registered environment.

    Attributes:
        entry_point: "module:function" of the function that makes a single environment.
        reward_threshold: the return at which the task counts as solved.
    """

    entry_point: str
    reward_threshold: float


@dataclass(frozen=True)
class Domain:
    """What one physical system offers to the generic packages; each attribute is optional.

    Attributes:
        environments: a mapping registered name -> `Environment`.
        rows: a class that stores the states of many components in common arrays (one row each) and advances them together,
            for `RowTask`s and native batches of environments, see `chain.rows.ChainRows`.
        gradients: a module with `RUNS` (cost of one gradient in forward runs) and `value_and_grad(env, drive, seeds, stage)`,
            which returns the smooth objective of a task and its derivatives with respect to the actions, for studies.
        watch: a class of observers that record a `history` of a run, constructed with the time between two frames [s].
        columns: a module with the sweep columns computed from this history: `MEASUREMENTS` (measurement -> column name ->
            function(history, which, arguments)), `UNITS` of the columns, and `measurement_function(name)`.
        views: a subclass of `viewing.domain_views.Views`, which adds domain-specific parts to a scene.
        contacts: function(points, displacement, read) that returns the quantity shown at the contacts between points, see
            `chain.viewing.contact_quantity`.
        dispersion: function(component, phases) that returns name -> frequencies [Hz] of small waves along a row, one for each
            phase difference of neighbours [rad]; see `chain.viewing.dispersion`.
        remark: function(parameters) that returns a note to print below pictures of the component; "" for none.
    """

    environments: str | None = None
    rows: str | None = None
    gradients: str | None = None
    watch: str | None = None
    columns: str | None = None
    views: str | None = None
    contacts: str | None = None
    dispersion: str | None = None
    remark: str | None = None

    def load_attribute(self, offer: str) -> Any:
        """Import and return the object that an attribute of this domain names, or None if the attribute is None."""
        name = getattr(self, offer)
        return None if name is None else import_object(name)


DOMAINS: dict[str, Domain] = {
    "automata": Domain(environments="granular_env.domains.automata.tasks:ENVIRONMENTS"),
    "chain": Domain(
        environments="granular_env.domains.chain.tasks:ENVIRONMENTS",
        rows="granular_env.domains.chain.rows:ChainRows",
        gradients="granular_env.domains.chain.control.episode_gradient",
        watch="granular_env.domains.chain.measurement.observer:Watch",
        columns="granular_env.domains.chain.measurement.columns",
        views="granular_env.domains.chain.viewing.views:ChainViews",
        contacts="granular_env.domains.chain.viewing.contact_quantity:contact_quantity",
        dispersion="granular_env.domains.chain.viewing.dispersion:dispersion_curves",
    ),
    "discs": Domain(environments="granular_env.domains.discs.tasks:ENVIRONMENTS"),
    "grid": Domain(environments="granular_env.domains.grid.tasks:ENVIRONMENTS"),
    "shell": Domain(remark="granular_env.domains.shell:remark"),
    "tube": Domain(
        environments="granular_env.domains.tube.tasks:ENVIRONMENTS",
        remark="granular_env.domains.shell:remark",
    ),
}
"""Name of a component -> its domain."""

_NOTHING = Domain()


def find_domain(component: str) -> Domain:
    """Return the domain of a component by the component's name, or an empty domain if it has none."""
    return DOMAINS.get(component, _NOTHING)


def gradient_domains() -> str:
    """Return the names of the components that have gradients, as text for messages."""
    return ", ".join(name for name, domain in DOMAINS.items() if domain.gradients is not None)


def find_environment_name(name: str) -> str | None:
    """Return the registered name of an environment, given in full or by its last part; None if it is unknown."""
    return next((known for known in load_environments() if name in (known, known.rpartition("/")[2])), None)


def load_environments() -> dict[str, Environment]:
    """Return all registered environments, by name."""
    return {name: one for domain in DOMAINS.values() for name, one in (domain.load_attribute("environments") or {}).items()}


def import_object(name: str) -> Any:
    """Import and return "module:attribute" or a module."""
    module, _, attribute = name.partition(":")
    found = import_module(module)
    return getattr(found, attribute) if attribute else found


def __getattr__(name: str) -> ModuleType:
    if name not in DOMAINS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return import_module(f"{__name__}.{name}")
