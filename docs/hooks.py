"""Hooks of mkdocs: pictures with a twin for dark pages, and tables of what a component's parameters and variables are."""

import importlib
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from mkdocs.exceptions import PluginError

ROOT = Path(__file__).resolve().parent.parent
PICTURE = re.compile(r"!\[(?P<text>[^\]]*)\]\((?P<stem>[^)#\s]+)(?P<suffix>\.(?:png|gif|svg))\)")
ENTRY = re.compile(r"^::: (?P<path>granular_env\.components\.\S+)\n(?:    .*\n)*", re.MULTILINE)
TABLES = re.compile(r"^<!-- tables: (?P<kind>\w+) ?(?P<name>\S*) -->$", re.MULTILINE)
WORDS = ("required", "automatic", "none", "not cut", "")


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Show each picture as the one that fits the page, and the tables that a line or an entry of the reference asks for."""
    markdown = _both_pictures(markdown, Path(page.file.abs_src_path).parent)
    markdown = ENTRY.sub(lambda found: found[0] + tables_of("entry", found["path"]), markdown)
    return TABLES.sub(lambda found: tables_of(found["kind"], found["name"]), markdown)


def _both_pictures(markdown: str, folder: Path) -> str:
    """Write each picture that has a twin (``NAME-dark.png``) twice, once for each colour scheme."""

    def both(found: re.Match[str]) -> str:
        text, stem, suffix = found["text"], found["stem"], found["suffix"]
        if not (folder / f"{stem}-dark{suffix}").exists():
            return found[0]
        return f"![{text}]({stem}{suffix}#only-light)\n![{text}]({stem}-dark{suffix}#only-dark)"

    return PICTURE.sub(both, markdown)


def tables_of(kind: str, name: str) -> str:
    """Return the tables of a line ``<!-- tables: KIND NAME -->`` of a page."""
    sys.path.insert(0, str(ROOT))
    if kind not in KINDS:
        raise PluginError(f"tables of {kind!r}: there are tables of {', '.join(KINDS)}")
    try:
        return "".join(_table(*table) for table in KINDS[kind](name))
    except (ImportError, AttributeError, ValueError) as error:
        raise PluginError(f"tables of {kind} {name!r}: {error}") from error


Table = tuple[str, Sequence[str], Iterable[Sequence[str]]]


def _parameters(path: str) -> Iterator[Table]:
    """Yield the parameters of a class, and of each table that they choose by name."""
    from granular_env.components import catalogue
    from granular_env.descriptions import parameter_tables

    for component in catalogue.own_names():
        catalogue.component_class(component)  # parts of a component are found among imported ones
    for table in parameter_tables(_resolve(path)):
        text = re.sub(r"(`granular-env describe (\w+)`)", r"[\1](\2.md#parameters)", table.text)
        yield f"`{table.key}`: {text}" if table.key else "", ("parameter", "unit", "default", "meaning"), _coded(table.rows, 2)


def _variables(name: str) -> Iterator[Table]:
    """Yield the inputs and outputs of the smallest example of a component, and its events."""
    from granular_env.descriptions import variable_tables
    from granular_env.experiments.templates import example_of

    for table in variable_tables(example_of(name, {})):
        is_event = table.text == "events"
        title = "Events:" if is_event else f"{table.text.capitalize()} of the smallest example:"
        yield title, (table.text[:-1], *(("meaning",) if is_event else ("unit", "shape", "meaning"))), _coded(table.rows)


def _entry(path: str) -> Iterator[Table]:
    """Yield the tables that belong below an entry of the reference: none but for parameters and components."""
    from granular_env.components.component import Component
    from granular_env.components.support.validation import Parameters

    thing = _resolve(path)
    own = vars(thing).values() if isinstance(thing, ModuleType) else [thing]
    for one in own:
        if not isinstance(one, type) or one.__module__ not in (path, path.rpartition(".")[0]):
            continue
        if issubclass(one, Parameters) and one.model_fields.keys() - {"name"}:
            title = f"Parameters of `{one.__name__}`:" if isinstance(thing, ModuleType) else ""
            yield title, *next(_parameters(f"{one.__module__}.{one.__name__}"))[1:]
        elif issubclass(one, Component) and one is not Component:
            yield from _variables(one.name)


KINDS = {"entry": _entry, "parameters": _parameters, "variables": _variables}


def _resolve(path: str) -> Any:
    module, _, name = path.rpartition(".")
    found = getattr(importlib.import_module(module), name, None)
    return importlib.import_module(path) if found is None else found


def _coded(rows: Iterable[Sequence[str]], default: int | None = None) -> Iterator[Sequence[str]]:
    """Yield rows with their name, and their default unless it is a word, as code."""
    for row in rows:
        yield [f"`{cell}`" if place in (0, default) and cell not in WORDS else cell for place, cell in enumerate(row)]


def _table(title: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    # A cell that ends in a brace would be read as a list of attributes.
    cells = [[re.sub(r"}$", "&#125;", cell.replace("|", "&#124;")) for cell in row] for row in rows]
    lines = [f"| {' | '.join(row)} |" for row in cells]
    heading = [f"| {' | '.join(head)} |", "|---" * len(head) + "|"] if lines else []
    return "\n".join(["", title, "", *heading, *lines, ""])
