"""Completion of the keys that `--set` takes: those of the document or the component that the command names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

# How the commands call what they are given.
_NAMED_BY = ("experiment", "plan", "study", "file", "name", "log")


def set_keys(ctx: click.Context, param: click.Parameter, begun: str) -> list[CompletionItem[str]]:
    """Complete a key, with the sign that its value follows."""
    from granular_env.components.errors import GranularError

    # Where the last option still lacks its value, click leaves the arguments unparsed.
    given = [ctx.params[key] for key in _NAMED_BY if ctx.params.get(key)]
    name = next((one for one in (*given, *ctx.args) if not one.startswith("-")), None)
    found: dict[str, str] = {}
    if name is not None and "=" not in begun:
        with suppress(GranularError, OSError):
            found = dict(_keys(name))
    return [CompletionItem(f"{key}=", help=text) for key, text in found.items() if key.startswith(begun)]


def _keys(name: str) -> Iterator[tuple[str, str]]:
    from granular_env.components import catalogue

    if name in catalogue.names():
        yield from _parameters(name, "")
        return
    content = _content(name)
    if "experiment" in content:  # a plan: the keys are those of its experiment
        beside = Path(name).parent / str(content["experiment"])
        content = _content(str(beside) if beside.is_file() else str(content["experiment"]))
    component = content.get("component")
    if isinstance(component, Mapping):
        from granular_env.experiments.experiment import Experiment

        yield from _parameters(str(component.get("type")), "component.")
        yield from ((key, field.description or "") for key, field in Experiment.model_fields.items() if key == "duration")
        content = {key: value for key, value in content.items() if key not in ("name", "description", "source", "component")}
    yield from _inner_keys(content, "")


def _parameters(component: str, prefix: str) -> Iterator[tuple[str, str]]:
    from granular_env.components import catalogue

    model = catalogue.component_class(component).Parameters
    yield from ((f"{prefix}{key}", field.description or "") for key, field in model.model_fields.items())


def _content(name: str) -> dict[str, Any]:
    """Return the content of a file, or of a shipped document of any kind."""
    from granular_env.documents import read
    from granular_env.package_contents import shipped_documents

    return read(Path(name) if Path(name).is_file() else shipped_documents()[name]) if _is_document(name) else {}


def _is_document(name: str) -> bool:
    from granular_env.package_contents import shipped_documents

    return Path(name).suffix == ".toml" and Path(name).is_file() or name in shipped_documents()


def _inner_keys(content: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, str]]:
    """Yield the keys that a document gives itself, with those of its tables."""
    for key, value in content.items():
        if isinstance(value, Mapping):
            yield from _inner_keys(value, f"{prefix}{key}.")
        elif isinstance(value, list) and value and isinstance(value[0], Mapping):
            for place, table in enumerate(value):
                yield from _inner_keys(table, f"{prefix}{key}[{place}].")
        else:
            yield f"{prefix}{key}", "as in the file"
