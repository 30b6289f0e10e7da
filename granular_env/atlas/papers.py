"""The papers that have an atlas: name -> module that holds `PAPER`."""

from __future__ import annotations

from importlib import import_module

from granular_env.components.errors import ParameterError, nearest

from .model import Paper

_PAPERS = {"nesterenko-1983": "granular_env.domains.chain.nesterenko_1983"}


def names() -> list[str]:
    """Names of the papers."""
    return sorted(_PAPERS)


def paper(name: str) -> Paper:
    """A paper by its name; `ParameterError` with the nearest one where there is none."""
    if name not in _PAPERS:
        raise ParameterError(f"paper {name!r}: there is no atlas of it; {nearest(name, names())}")
    return import_module(_PAPERS[name]).PAPER
