"""Domains: the only rooms that name a physical system, one folder each; and the table of what each of them offers.

A generic room (environments, studies, sweeps, viewing) imports this module and no domain: `domain_of` gives what the
domain of a component offers. A name in the table is a module, or "module:attribute"; it is imported when it is asked for. What
is None or not named, the domain does not have: the generic room then does what serves any component, or says what is missing.
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
        entry_point: what makes the single one.
        reward_threshold: the return at which the task counts as solved.
    """

    entry_point: str
    reward_threshold: float


@dataclass(frozen=True)
class Domain:
    """The offers of the rooms of one physical system.

    Attributes:
        environments: a mapping registered name -> `Environment`.
        rows: a class that shows components as rows of arrays and advances them together, for tasks that judge rows and for
            native batches, see `chain.rows.ChainRows`.
        gradients: a module with `RUNS` (cost of one gradient in forward runs) and `value_and_grad(env, drive, seeds, stage)`,
            the smooth objective of a task and its derivatives with respect to the actions, for studies.
        watch: a class of observers with a `history`, made with the time between two frames [s].
        columns: a module with what a sweep can take of such a history: `MEASUREMENTS` (measurement -> what is taken of it ->
            taken(history, which, arguments)), `UNITS` of what is taken, and `function`, which gives a measurement by name.
        views: a subclass of `viewing.domain_views.Views`: what a scene shows beside the generic parts.
        contacts: contacts(points, displacement, read), what the views know of the contacts between points, see
            `chain.viewing.contact_quantity`.
        remark: remark(parameters), what pictures of such a component have to say beside what they show; "" for nothing.
    """

    environments: str | None = None
    rows: str | None = None
    gradients: str | None = None
    watch: str | None = None
    columns: str | None = None
    views: str | None = None
    contacts: str | None = None
    remark: str | None = None

    def load(self, offer: str) -> Any:
        """Return what an attribute of this domain names; None where the domain does not have it."""
        name = getattr(self, offer)
        return None if name is None else load(name)


DOMAINS: dict[str, Domain] = {
    "automata": Domain(environments="granular_env.domains.automata.tasks:ENVIRONMENTS"),
    "chain": Domain(
        environments="granular_env.domains.chain.tasks:ENVIRONMENTS",
        rows="granular_env.domains.chain.rows:ChainRows",
        gradients="granular_env.domains.chain.control.episode_gradient",
        watch="granular_env.domains.chain.measurement.observer:Watch",
        columns="granular_env.domains.chain.measurement.columns",
        views="granular_env.domains.chain.viewing.views:ChainViews",
        contacts="granular_env.domains.chain.viewing.contact_quantity:contacts_of",
    ),
    "discs": Domain(environments="granular_env.domains.discs.tasks:ENVIRONMENTS"),
    "grid": Domain(environments="granular_env.domains.grid.tasks:ENVIRONMENTS"),
    "shell": Domain(remark="granular_env.domains.shell:remark"),
    "tube": Domain(
        environments="granular_env.domains.tube.tasks:ENVIRONMENTS",
        remark="granular_env.domains.shell:remark",
    ),
}
"""Name of a component in the catalogue -> what its domain offers."""

_NOTHING = Domain()


def domain_of(component: str) -> Domain:
    """Return what the domain of a component offers, by the component's name; nothing where it has no domain."""
    return DOMAINS.get(component, _NOTHING)


def gradient_domains() -> str:
    """Return the names of the components that have gradients, for messages."""
    return ", ".join(name for name, domain in DOMAINS.items() if domain.gradients is not None)


def find_environment(name: str) -> str | None:
    """Return the registered name of an environment, from that or from its last part; None where there is none."""
    return next((known for known in environments() if name in (known, known.rpartition("/")[2])), None)


def environments() -> dict[str, Environment]:
    """Return all registered environments, by name."""
    return {name: one for domain in DOMAINS.values() for name, one in (domain.load("environments") or {}).items()}


def load(name: str) -> Any:
    """Import "module:attribute", or a module."""
    module, _, attribute = name.partition(":")
    found = import_module(module)
    return getattr(found, attribute) if attribute else found


def __getattr__(name: str) -> ModuleType:
    if name not in DOMAINS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return import_module(f"{__name__}.{name}")
