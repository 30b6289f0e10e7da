"""The papers that have an atlas, by name."""

from __future__ import annotations

from granular_env.components.errors import ParameterError, nearest
from granular_env.domains import DOMAINS, load

from .model import Paper


def _homes() -> dict[str, str]:
    return {name: home for domain in DOMAINS.values() for name, home in domain.papers.items()}


def names() -> list[str]:
    """Return the names of the papers."""
    return sorted(_homes())


def paper(name: str) -> Paper:
    """Return a paper by its name; `ParameterError` with the nearest one where there is none."""
    homes = _homes()
    if name not in homes:
        raise ParameterError(f"there is no atlas of {name!r}", hint=nearest(name, names()), at="paper")
    return load(homes[name])
