"""Tables that pages ask for with a line ``<!-- tables: KIND NAME -->``: parameters, variables, commands, statuses, keys.

Each kind is a function of the name that yields tables: a title, the heads of the columns, and rows.
"""

import importlib
import inspect
import re
import sys
import types
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

import click  # noqa: E402
from pydantic.fields import FieldInfo  # noqa: E402

from granular_env.cli.command import MEANINGS  # noqa: E402
from granular_env.cli.program import COMMANDS, PROGRAM  # noqa: E402
from granular_env.components import catalogue  # noqa: E402
from granular_env.components.component import Component  # noqa: E402
from granular_env.components.support.validation import Parameters  # noqa: E402
from granular_env.descriptions import described_parameters, described_variables  # noqa: E402
from granular_env.documents import Document, load_document, toml_value  # noqa: E402
from granular_env.documents import Table as TomlTable  # noqa: E402
from granular_env.experiments.templates import make_example  # noqa: E402
from granular_env.package_contents import first_sentence, shipped_files  # noqa: E402

Table = tuple[str, Sequence[str], Iterable[Sequence[str]]]
LONGEST_EXAMPLE = 60
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
    for component in catalogue.built_in_names():
        catalogue.component_class(component)  # parts of a component are found among imported ones
    for table in described_parameters(_resolve(path)):
        text = re.sub(r"(`granular-env describe (\w+)`)", r"[\1](\2.md#parameters)", table.text)
        yield f"`{table.key}`: {text}" if table.key else "", ("parameter", "unit", "default", "meaning"), _coded(table.rows, 2)


def variables(name: str) -> Iterator[Table]:
    """Yield the inputs and outputs of the smallest example of a component, and its events."""
    for table in described_variables(make_example(name, {})):
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


def keys(path: str) -> Iterator[Table]:
    """Yield the keys of a document and of each table in it: type, default, meaning, and an example."""
    document = _resolve(path)
    examples = _shipped_examples(document)
    for place, model in toml_tables(document):
        fixed, rows = "", []
        for key, field in own_keys(model).items():
            choices = get_args(field.annotation)
            if get_origin(field.annotation) is Literal and len(choices) == 1 and not field.description:
                fixed = f" with `{key} = {toml_value(choices[0])}`"
            else:
                example = _code(f"{key} = {examples.get((model, key)) or _example_of(field)}")
                rows.append((f"`{key}`", *_key_facts(field), example))
        title = f"### `{place}`{fixed}\n\n{first_sentence(model.__doc__ or '')}" if place else ""
        yield title, ("key", "type", "default", "meaning", "example"), rows


def toml_tables(
    model: type[TomlTable], place: str = "", seen: set[type] | None = None
) -> Iterator[tuple[str, type[TomlTable]]]:
    """Yield the classes of the tables in a document, each once with its place, such as ``[[stop]]``; base classes first."""
    seen = {TomlTable, Document} if seen is None else seen
    for kind in reversed(model.__mro__):
        if issubclass(kind, TomlTable) and kind not in seen:
            seen.add(kind)
            yield place, kind
        elif kind is model:
            return
    # Tables under any key are declared by the type of the extra fields.
    inner = {key: field.annotation for key, field in model.model_fields.items()}
    inner[""] = get_type_hints(model).get("__pydantic_extra__")
    for key, annotation in inner.items():
        for form, kind in _tables_of_type(annotation, ".".join(filter(None, (place.strip("[]"), key)))):
            yield from toml_tables(kind, form, seen)


def _tables_of_type(annotation: Any, name: str, form: str = "[{}]") -> Iterator[tuple[str, type[TomlTable]]]:
    """Yield the tables that a type allows, with the heading of each in a file."""
    if isinstance(annotation, type) and issubclass(annotation, TomlTable):
        for kind in annotation.__subclasses__() or [annotation]:
            yield form.format(name), kind
    origin = get_origin(annotation)
    parts = get_args(annotation)[:1] if origin is Annotated else get_args(annotation)
    for part in () if origin is Literal else parts:
        yield from _tables_of_type(part, f"{name}.KEY" if origin is dict else name, "[[{}]]" if origin is list else form)


def own_keys(model: type[TomlTable]) -> dict[str, FieldInfo]:
    """Return the keys that a class declares, without those of its base classes."""
    own = vars(model).get("__annotations__", {})
    return {field.alias or key: field for key, field in model.model_fields.items() if key in own}


def _key_facts(field: FieldInfo) -> tuple[str, str, str]:
    """Return the type, the default and the meaning of a key; a description may contain its unit and end in its default."""
    text, _, default = (field.description or "").partition("; default: ")
    unit = re.search(r" \[(\S+)\]", text)
    value = field.get_default(call_default_factory=True)
    if field.is_required():
        default = "required"
    elif not default and value not in (None, "", [], {}) and not isinstance(value, TomlTable):
        default = f"`{toml_value(value)}`"
    kind = " or ".join(dict.fromkeys(_type_words(field.annotation)))
    return kind + (f", {unit[1]}" if unit else ""), default, text.replace(unit[0], "") if unit else text


def _example_of(field: FieldInfo) -> str:
    """Return the declared example of a key, its last choice, or its default."""
    choices = [
        one for part in (field.annotation, *get_args(field.annotation)) if get_origin(part) is Literal for one in get_args(part)
    ]
    values = field.examples or choices[-1:] or [field.get_default(call_default_factory=True)]
    return toml_value(values[0])


def _type_words(annotation: Any) -> Iterator[str]:
    origin = get_origin(annotation)
    if origin is Literal:
        yield " or ".join(f"`{toml_value(choice)}`" for choice in get_args(annotation))
    elif origin in (Annotated, Union, types.UnionType):
        for part in get_args(annotation)[: 1 if origin is Annotated else None]:
            yield from _type_words(part)
    elif annotation is not type(None):
        words = {str: "text", int: "whole number", float: "number", bool: "true or false", list: "list", Any: "text"}
        yield words.get(origin or annotation, "table")


def _shipped_examples(document: type[Document]) -> dict[tuple[type, str], str]:
    """Return the shortest value of each key, by the class of its table, in the shipped files of a kind."""
    found: dict[tuple[type, str], str] = {}
    for name in shipped_files(document.shelf):
        for table in _tables_within(load_document(document, name)):
            for key, value in table.model_dump(by_alias=True, exclude_unset=True, serialize_as_any=True).items():
                with suppress(TypeError):
                    text = toml_value(value)
                    for kind in type(table).__mro__:
                        found[kind, key] = min(found.get((kind, key), text), text, key=len)
    return {key: text for key, text in found.items() if len(text) <= LONGEST_EXAMPLE}


def _tables_within(value: Any) -> Iterator[TomlTable]:
    if isinstance(value, TomlTable):
        yield value
        value = {**vars(value), **(value.model_extra or {})}
    if isinstance(value, Mapping | list):
        for part in value.values() if isinstance(value, Mapping) else value:
            yield from _tables_within(part)


KINDS = {
    "entry": entry,
    "parameters": parameters,
    "variables": variables,
    "commands": commands,
    "statuses": statuses,
    "keys": keys,
}


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
