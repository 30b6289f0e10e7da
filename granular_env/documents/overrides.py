"""Overrides of single keys of a document: `{"component.grains": 500}` in a script, `component.grains=500` in a shell.

`start.velocity[40]` is an element or a row of an array or a list; `start.velocity[3,1]` is an element with several axes.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from granular_env.components.errors import ExperimentError, Fault, Override, ParameterError, one_line
from granular_env.components.variables import index_text, parse_element

from .toml_writing import toml_value

Overrides = Mapping[str, Any] | Iterable[Override]

# A word or a quantity, such as 100us, which need no quotes.
_BARE_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_./-]*|[+-]?\.?\d[\d.eE+-]*\s*[A-Za-z\u00b5\u03bc\u00b0][^\"'\[\]{},=]*")


def parse_assignments(texts: Iterable[str]) -> tuple[Override, ...]:
    """Return the overrides from a shell's ``key=value`` texts, with values as in TOML; words and quantities need no quotes.

    Raises:
        ExperimentError: an invalid text or value.
    """
    return tuple(_parse_assignment(text) for text in texts)


def to_overrides(source: Any) -> tuple[Override, ...]:
    """Return the validated overrides from a script's mapping of keys to values.

    Raises:
        ExperimentError: the overrides are not a mapping.
    """
    if isinstance(source, Mapping):
        return tuple(_make_override(key, value) for key, value in source.items())
    overrides = tuple(source) if isinstance(source, Iterable) else (source,)
    if all(isinstance(one, Override) for one in overrides):
        return overrides
    expected = 'a mapping of keys and values, such as {"component.grains": 500}'
    raise ExperimentError(f"got {one_line(source)}", at="overrides", expected=expected)


def set_key(content: dict[str, Any], override: Override) -> None:
    """Set a key of a document. Missing tables on its path are created; a name on its path becomes a table with this name.

    Raises:
        ExperimentError: the key leads into a value that is not a table, or past the end of a list.
    """
    node: Any = content
    *above, last = override.key
    for depth, part in enumerate(above):
        node, key = _key_container(node, part, depth, override)
        if isinstance(node, dict):
            node.setdefault(key, {})
        if depth and above[0] == "component" and isinstance(node[key], str):
            node[key] = {"name": node[key]}
        node = node[key]
    node, key = _key_container(node, last, len(above), override)
    if isinstance(node, dict) and key.lstrip("-").isdecimal():  # a new row replaces single elements set in it before
        for element in [one for one in node if one.startswith(f"{key},")]:
            del node[element]
    node[key] = override.value


def _key_container(node: Any, part: str, depth: int, override: Override) -> tuple[Any, Any]:
    """Return the table or list that contains `part` of a key, and the key or index there; "3,1" indexes nested lists."""
    *rows, index = part.split(",")
    if isinstance(node, dict):
        if not rows or not isinstance(node.get(rows[0]), list):
            return node, part
        node, rows = node[rows[0]], rows[1:]  # for an array given as {index: row}
    for row in rows:
        node = node[_list_index(node, row, override)] if isinstance(node, list) else node
    if not isinstance(node, list):
        whole = ".".join(override.key[:depth])
        raise _override_error(override, f"{whole} is {one_line(node)}, so it has no {part!r}; set {whole} as a whole")
    return node, _list_index(node, index, override)


def _list_index(node: list[Any], text: str, override: Override) -> int:
    if text not in map(str, range(-len(node), len(node))):
        raise _override_error(override, f"got the index {one_line(text)}, expected {-len(node)} to {len(node) - 1}")
    return int(text)


def fault_source(location: Sequence[str | int], origin: str, overrides: Sequence[Override]) -> str | Override:
    """Return what caused a fault: the override that set its key; else the file, named together with relevant overrides.

    Relevant are overrides in the fault's table and in the component's table, on which all other shapes and names depend.
    """
    keys = tuple(map(str, location))
    for override in reversed(overrides):
        key = tuple(part for name in override.key for part in name.split(","))
        if key == keys[: len(key)]:
            return override
    near = [override for override in overrides if override.key[:1] in (keys[:1], ("component",))]
    return f"{origin} with {', '.join(map(str, near))}" if near else origin


def _parse_assignment(text: str) -> Override:
    key, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not key:
        raise _override_error(Override((), None, text), "expected key=value, such as component.grains=500")
    try:
        parsed = tomllib.loads(f"value = {value}")
    except (ValueError, RecursionError, ArithmeticError):
        parsed = {"value": value} if _BARE_WORD.fullmatch(value) else {}
    if parsed.keys() != {"value"}:
        advice = "write a number, a list, or a string in quotes"
        raise _override_error(Override((), None, text), f"{one_line(value, 60)} is not a TOML value; {advice}")
    return _make_override(key, parsed["value"], text)


def _make_override(key: Any, value: Any, text: str | None = None) -> Override:
    names = [part.strip().strip("\"'") for part in key.split(".")] if isinstance(key, str) else []
    parts = tuple(part for name in names for part in _split_index(name))
    shown = toml_value(value) if isinstance(value, str | bool | float) else one_line(value)
    override = Override(parts, value, text or f"{key}={shown}")
    if not all(parts) or not parts:
        came = f"got the key {one_line(key)}, expected names separated by dots, such as component.grains"
        raise _override_error(override, came)
    return override


def _split_index(name: str) -> tuple[str, ...]:
    """Split a name with an index: ("velocity", "3,1") for velocity[3, 1]; any other text is returned alone, unchanged."""
    try:
        element = parse_element(name)
    except ParameterError:
        return (name,)
    return (element.name, index_text(element.index)) if element.index else (name,)


def _override_error(override: Override, text: str) -> ExperimentError:
    return ExperimentError(Fault(received=text, source=override))
