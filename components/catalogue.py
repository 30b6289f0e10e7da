"""Name -> component class.

Our own components are listed here; third parties add theirs by the entry-point group ``granular_env.components``.
"""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, Any

from .errors import ParameterError, nearest, one_line

if TYPE_CHECKING:
    from .component import Component

ENTRY_POINT_GROUP = "granular_env.components"

# Name -> where the class is, and the first sentence of its docstring, for lists that import nothing.
_OWN = {
    "automata": (
        ".automata.component:Automata",
        "Movable cellular automata: equal discs in a packing, which act on pairs and on volume (Psakhie 2003).",
    ),
    "chain": (
        ".chain.component:Chain",
        "A row of grains between two ends: Nesterenko (1983), equations (1.1) and (1.2), and the contact laws in use today.",
    ),
    "coupled": (
        ".coupled.component:Coupled",
        "A grid and movable cellular automata that share an interface: Psakhie et al. (2003), section 2.3.",
    ),
    "detonation": (
        ".detonation.component:DetonationTube",
        "A reactive gas in a tube, in one dimension: the detonation of Gato & Shie (2010).",
    ),
    "discs": (".discs:Discs", "Discs in a box, tied together by links that break."),
    "grid": (
        ".grid.component:Grid",
        "A continuum in plane strain on a mesh of quadrilaterals that moves with it: Wilkins (1964), Psakhie et al. (2003).",
    ),
    "oscillator": (".oscillator:Oscillator", "A mass on a spring, pushed by a force."),
    "shell": (
        ".shell.component:Shell",
        "A solid with thin walls, meshfree and in three dimensions: the tube of Gato & Shie (2010).",
    ),
    "tube": (
        ".tube.component:Tube",
        "A detonation in a rigid tube, a section of which is a shell: the experiment of Gato & Shie (2010).",
    ),
}


def names() -> list[str]:
    """All known component names, ours first."""
    return [*_OWN, *(point.name for point in _foreign() if point.name not in _OWN)]


def own_names() -> list[str]:
    """Return the names of our own components: those that a log may name without being trusted."""
    return list(_OWN)


def foreign_packages() -> set[str]:
    """Return the packages that third parties' components come from."""
    return {point.module.partition(".")[0] for point in _foreign()}


def foreign_package(name: str) -> str | None:
    """Return the top-level package that a third party's component comes from; None for one of ours."""
    if name in _OWN:
        return None
    return next((point.module.partition(".")[0] for point in _foreign() if point.name == name), None)


def summary(name: str) -> str:
    """Return what a component is, in a sentence; a third party's is imported for it, or it is said that it cannot be."""
    if name in _OWN:
        return _OWN[name][1]
    try:
        found = component_class(name)
    except ParameterError as error:
        return f"Cannot be loaded: {error}"
    return " ".join((found.__doc__ or "").split()).partition(". ")[0].rstrip(".") + "."


def component_class(name: str) -> type[Component]:
    """Return the class behind a catalogue name; imported only now.

    Raises:
        ParameterError: no such component, or a third party's cannot be loaded.
    """
    if isinstance(name, str) and name in _OWN:
        module, _, attribute = _OWN[name][0].partition(":")
        return getattr(import_module(module, __package__), attribute)
    for point in _foreign():
        if point.name == name:
            return _load_class(point)
    raise ParameterError(f"got {one_line(name)}", expected="the name of a component", hint=nearest(name, names()))


def make(name: str, **parameters: Any) -> Component:
    """Return a component by its catalogue name."""
    return component_class(name)(**parameters)


def _foreign() -> list[EntryPoint]:
    return list(entry_points(group=ENTRY_POINT_GROUP))


def _load_class(point: EntryPoint) -> type[Component]:
    try:
        loaded = point.load()
    except Exception as error:
        hint = "install its package again" if isinstance(error, ImportError) else "its package has to be mended"
        came = f"loading {point.value} failed: {type(error).__name__}: {error}"
        raise ParameterError(came, hint=hint, source=f"component {point.name!r}") from error
    from .component import Component

    if not (isinstance(loaded, type) and issubclass(loaded, Component)):
        raise ParameterError(f"got {point.value}", expected="a subclass of Component", source=f"component {point.name!r}")
    return loaded
