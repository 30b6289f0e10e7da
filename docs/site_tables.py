"""Tables that pages ask for with a line ``<!-- tables: KIND NAME -->``: parameters, variables, commands, statuses, keys.

Each kind is a function of the name that yields tables: a title, the heads of the columns, and rows.
"""

import importlib
import inspect
import re
import sys
import types
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, Union, get_args, get_origin

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

import click  # noqa: E402
from pydantic import BaseModel  # noqa: E402

from granular_env.cli.command import MEANINGS  # noqa: E402
from granular_env.cli.program import COMMANDS, PROGRAM  # noqa: E402
from granular_env.components import catalogue  # noqa: E402
from granular_env.components.component import Component  # noqa: E402
from granular_env.components.support.validation import Parameters  # noqa: E402
from granular_env.descriptions import parameter_tables, variable_tables  # noqa: E402
from granular_env.documents import Document, read, toml_value  # noqa: E402
from granular_env.documents import Table as TomlTable  # noqa: E402
from granular_env.experiments.templates import default_of, example_of  # noqa: E402
from granular_env.package_contents import first_sentence, shipped_files  # noqa: E402

Table = tuple[str, Sequence[str], Iterable[Sequence[str]]]
# Defaults that are words, not values.
WORDS = ("required", "automatic", "none", "not cut", "")


def text_of(kind: str, name: str) -> str:
    """Return the tables of a kind as markdown; `ValueError` for an unknown kind or name."""
    if kind not in KINDS:
        raise ValueError(f"tables of {kind!r}: there are tables of {', '.join(KINDS)}")
    try:
        return "".join(_markdown(*table) for table in KINDS[kind](name))
    except (ImportError, AttributeError, ValueError) as error:
        raise ValueError(f"tables of {kind} {name!r}: {error}") from error


def parameters(path: str) -> Iterator[Table]:
    """Yield the parameters of a class, and of each table that they choose by name."""
    for component in catalogue.own_names():
        catalogue.component_class(component)  # parts of a component are found among imported ones
    for table in parameter_tables(_resolve(path)):
        text = re.sub(r"(`granular-env describe (\w+)`)", r"[\1](\2.md#parameters)", table.text)
        yield f"`{table.key}`: {text}" if table.key else "", ("parameter", "unit", "default", "meaning"), _coded(table.rows, 2)


def variables(name: str) -> Iterator[Table]:
    """Yield the inputs and outputs of the smallest example of a component, and its events."""
    for table in variable_tables(example_of(name, {})):
        is_event = table.text == "events"
        title = "Events:" if is_event else f"{table.text.capitalize()} of the smallest example:"
        yield title, (table.text[:-1], *(("meaning",) if is_event else ("unit", "shape", "meaning"))), _coded(table.rows)


def entry(path: str) -> Iterator[Table]:
    """Yield the tables that belong below an entry of the reference: none but for parameters and components."""
    thing = _resolve(path)
    own = vars(thing).values() if isinstance(thing, types.ModuleType) else [thing]
    for one in own:
        if not isinstance(one, type) or one.__module__ not in (path, path.rpartition(".")[0]):
            continue
        if issubclass(one, Parameters) and one.model_fields.keys() - {"name"}:
            title = f"Parameters of `{one.__name__}`:" if isinstance(thing, types.ModuleType) else ""
            yield title, *next(parameters(f"{one.__module__}.{one.__name__}"))[1:]
        elif issubclass(one, Component) and one is not Component:
            yield from variables(one.name)


def commands(name: str = "") -> Iterator[Table]:
    """Yield the arguments and options of each command, below its usage and its description."""
    for command in COMMANDS:
        context = click.Context(command, info_name=f"{PROGRAM} {command.name}")
        usage = " ".join(command.get_usage(context).removeprefix("Usage: ").split())
        texts = [inspect.cleandoc(text) for text in (command.help, command.epilog) if text]
        title = "\n\n".join([f"## {command.name}", f"```text\n{usage}\n```", *texts])
        options = [one for one in command.get_params(context) if "--help" not in one.opts]
        yield title, ("argument or option", "default", "meaning"), _coded(_option_row(one, context) for one in options)


def _option_row(option: click.Parameter, context: click.Context) -> tuple[str, str, str]:
    """Return an argument's or an option's name, the default that its help declares, and the rest of the help."""
    name, text = option.get_help_record(context) or (option.make_metavar(context), "")
    found = re.search(r" ?\(default: (.*?)\)(?=\.|$| )", text)
    default = "required" if option.required else found[1] if found else ""
    return name, default, text.replace(found[0] if found else "  [required]", "")


def statuses(name: str = "") -> Iterator[Table]:
    """Yield the exit statuses of the program."""
    yield "", ("status", "meaning"), [(str(int(status)), meaning) for status, meaning in MEANINGS.items()]


KINDS = {"entry": entry, "parameters": parameters, "variables": variables, "commands": commands, "statuses": statuses}


def _resolve(path: str) -> Any:
    module, _, name = path.rpartition(".")
    found = getattr(importlib.import_module(module), name, None)
    return importlib.import_module(path) if found is None else found


def _coded(rows: Iterable[Sequence[str]], *places: int) -> Iterator[Sequence[str]]:
    """Yield rows with the first cell, and those at `places` unless they are words, as code."""
    for row in rows:
        yield [_code(cell) if place in (0, *places) and cell not in WORDS else cell for place, cell in enumerate(row)]


def _code(text: str) -> str:
    # In a table a bar can be written in HTML only.
    return f"<code>{text}</code>" if "|" in text else f"`{text}`"


def _markdown(title: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    # A cell that ends in a brace would be read as a list of attributes.
    cells = [[re.sub(r"}$", "&#125;", cell.replace("|", "&#124;")) for cell in row] for row in rows]
    lines = [f"| {' | '.join(row)} |" for row in cells]
    heading = [f"| {' | '.join(head)} |", "|---" * len(head) + "|"] if lines else []
    return "\n".join(["", title, "", *heading, *lines, ""])
