"""Hooks of mkdocs: pictures with a twin for dark pages, and tables of what a component's parameters and variables are."""

import importlib
import re
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
PICTURE = re.compile(r"!\[(?P<text>[^\]]*)\]\((?P<stem>[^)#\s]+)(?P<suffix>\.(?:png|gif|svg))\)")
ENTRY = re.compile(r"^::: (?P<path>granular_env\.components\.\S+)\n(?:    .*\n)*", re.MULTILINE)


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Show each picture as the one that fits the page, and parameters below the class that declares them."""
    return ENTRY.sub(
        lambda found: found[0] + reference_tables(found["path"]), _pair_pictures(markdown, Path(page.file.abs_src_path).parent)
    )


def _pair_pictures(markdown: str, folder: Path) -> str:
    """Write each picture that has a twin (``NAME-dark.png``) twice, once for each colour scheme."""

    def both(found: re.Match[str]) -> str:
        text, stem, suffix = found["text"], found["stem"], found["suffix"]
        if not (folder / f"{stem}-dark{suffix}").exists():
            return found[0]
        return f"![{text}]({stem}{suffix}#only-light)\n![{text}]({stem}-dark{suffix}#only-dark)"

    return PICTURE.sub(both, markdown)


def reference_tables(path: str) -> str:
    """Return the tables that belong below an entry of the reference: empty but for parameters and components."""
    sys.path.insert(0, str(ROOT))
    from granular_env.components.component import Component
    from granular_env.components.support.validation import Parameters

    thing = _resolve(path)
    own = vars(thing).values() if isinstance(thing, ModuleType) else [thing]
    classes = [one for one in own if isinstance(one, type) and one.__module__ in (path, path.rpartition(".")[0])]
    tables = [_parameters(one, isinstance(thing, ModuleType)) for one in classes if issubclass(one, Parameters)]
    tables += [_variables(one) for one in classes if issubclass(one, Component) and one is not Component]
    return "".join(tables)


def _resolve(path: str) -> Any:
    module, _, name = path.rpartition(".")
    found = getattr(importlib.import_module(module), name, None)
    return importlib.import_module(path) if found is None else found


def _parameters(model: Any, is_named: bool) -> str:
    from granular_env.experiments.templates import default_text, field_unit

    rows = [
        (f"`{key}`", field_unit(field), f"`{default_text(field)}`", field.description or "")
        for key, field in model.model_fields.items()
    ]
    return _table(f"Parameters of `{model.__name__}`:" if is_named else "", ("parameter", "unit", "default", "meaning"), rows)


def _variables(kind: Any) -> str:
    """Return the inputs and outputs of the smallest example of a component, and its events."""
    from granular_env.experiments.templates import make_example

    tables = []
    for causality in ("input", "output"):
        found = [one for one in make_example(kind.name, {}).variables.values() if one.causality == causality]
        rows = [(f"`{one.name}`", one.unit, str(one.shape) if one.shape else "number", _meaning(one)) for one in found]
        tables.append(
            _table(f"{causality.capitalize()}s of the smallest example:", (causality, "unit", "shape", "meaning"), rows)
        )
    events = [(f"`{name}`", words) for name, words in kind.event_kinds.items()]
    return "".join([*tables, _table("Events:", ("event", "what happened"), events)])


def _meaning(variable: Any) -> str:
    return f"{variable.description} (state)" if variable.state else variable.description


def _table(title: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [f"| {' | '.join(cell.replace('|', '&#124;') for cell in row)} |" for row in rows]
    if not lines:
        return ""
    return "\n".join(["", title, "", f"| {' | '.join(head)} |", "|---" * len(head) + "|", *lines, "", ""])
