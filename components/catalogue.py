"""The catalogue of components: it finds the class of a component by its name.

Components of this package are listed here; third parties add theirs through the entry-point group ``granular_env.components``.
"""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .errors import ParameterError, one_line, spelling_hint

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from .component import Component

ENTRY_POINT_GROUP = "granular_env.components"

# Name -> module and class.
_OWN = {
    "automata": "automata.component:Automata",
    "chain": "chain.component:Chain",
    "coupled": "coupled.component:Coupled",
    "detonation": "detonation.component:DetonationTube",
    "discs": "discs:Discs",
    "grid": "grid.component:Grid",
    "oscillator": "oscillator:Oscillator",
    "shell": "shell.component:Shell",
    "tube": "tube.component:Tube",
}


def component_names() -> list[str]:
    """Return all known component names, those of this package first."""
    return [*_OWN, *(point.name for point in _plugin_entry_points() if point.name not in _OWN)]


def built_in_names() -> list[str]:
    """Return the names of this package's own components; a log from an untrusted source may name no others."""
    return list(_OWN)


def component_summary(name: str) -> str:
    """Return the first sentence of a component's docstring, without importing components of this package."""
    if name in _OWN:
        module, _, attribute = _OWN[name].partition(":")
        source = (Path(__file__).parent / f"{module.replace('.', '/')}.py").read_text(encoding="utf-8")
        found = re.search(rf'^class {attribute}\b.*?"""(.*?)(?:"""|\n\n)', source, re.DOTALL | re.MULTILINE)
        text = found[1] if found else ""
    else:
        try:
            text = component_class(name).__doc__ or ""
        except ParameterError as error:
            return f"Cannot be loaded: {error}"
    return re.split(r"\. (?=[A-Z`])", " ".join(text.partition("\n\n")[0].split()), maxsplit=1)[0].rstrip(".") + "."


def component_class(name: str) -> type[Component]:
    """Import and return the class with a catalogue name.

    Raises:
        ParameterError: there is no such component, or a third-party component cannot be loaded.
    """
    if isinstance(name, str) and name in _OWN:
        module, _, attribute = _OWN[name].partition(":")
        return getattr(import_module(f".{module}", __package__), attribute)
    for point in _plugin_entry_points():
        if point.name == name:
            return _load_class(point)
    raise ParameterError(
        f"got {one_line(name)}", expected="the name of a component", hint=spelling_hint(name, component_names())
    )


def make(name: str, **parameters: Any) -> Component:
    """Return a new component by its catalogue name."""
    return component_class(name)(**parameters)


def _plugin_entry_points() -> list[EntryPoint]:
    from importlib.metadata import entry_points

    return list(entry_points(group=ENTRY_POINT_GROUP))


def _load_class(entry_point: EntryPoint) -> type[Component]:
    from .component import Component

    source = f"component {entry_point.name!r}"
    try:
        loaded = entry_point.load()
    except Exception as error:
        came = f"loading {entry_point.value} failed: {type(error).__name__}: {error}"
        raise ParameterError(came, hint="install or fix the package that provides it", source=source) from error
    if not (isinstance(loaded, type) and issubclass(loaded, Component)):
        raise ParameterError(f"got {entry_point.value}", expected="a subclass of Component", source=source)
    return loaded
