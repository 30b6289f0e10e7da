"""Values and whole experiments as TOML text."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def toml_value(value: Any, quoted: bool = False) -> str:
    """Return a value as TOML; floats in their shortest exact form; keys of tables in quotes where they need them, or always."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{toml_key(key, quoted)} = {toml_value(part, quoted)}" for key, part in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(toml_value(part, quoted) for part in value) + "]"
    return repr(value)


def toml_key(key: object, quoted: bool = False) -> str:
    """Return a key as TOML, in quotes where it needs them, or always."""
    text = str(key)
    return text if _BARE_KEY.fullmatch(text) and not quoted else json.dumps(text, ensure_ascii=False)


def toml_document(content: Mapping[str, Any]) -> str:
    """Return a document as TOML: its own keys, then its tables, one level of tables within them, and lists of tables.

    None has no form in TOML; such keys are left out.
    """
    content = _without_none(content)
    lines = [f"{toml_key(key)} = {toml_value(value)}" for key, value in content.items() if not _is_table(value)]
    for key, value in content.items():
        if isinstance(value, Mapping):
            lines += ["", *_table(toml_key(key), value)]
        elif _is_table(value):
            for part in value:
                lines += ["", f"[[{toml_key(key)}]]", *(f"{toml_key(name)} = {toml_value(one)}" for name, one in part.items())]
    return "\n".join(lines) + "\n"


def _table(head: str, content: Mapping[str, Any]) -> list[str]:
    inner = {key: value for key, value in content.items() if isinstance(value, Mapping) and value}
    own = [f"{toml_key(key)} = {toml_value(value)}" for key, value in content.items() if key not in inner]
    lines = [f"[{head}]", *own] if own or not inner else []
    for key, value in inner.items():
        lines += ["", f"[{head}.{toml_key(key)}]", *(f"{toml_key(name)} = {toml_value(one)}" for name, one in value.items())]
    return lines


def _is_table(value: Any) -> bool:
    tables = isinstance(value, list) and bool(value) and all(isinstance(part, Mapping) for part in value)
    return tables or isinstance(value, Mapping)


def _without_none(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _without_none(part) for key, part in value.items() if part is not None}
    if isinstance(value, list | tuple):
        return [_without_none(part) for part in value if part is not None]
    return value
