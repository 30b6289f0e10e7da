"""Writing of TOML: single values, whole documents, and a new name in an existing text, whose comments are kept."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def replace_name(text: str, name: str) -> str:
    """Return the text of a TOML file with its top-level key `name` set; comments are kept."""
    return re.sub(r"^name\s*=.*$", lambda _: f"name = {toml_value(name)}", text, count=1, flags=re.MULTILINE)


def toml_value(value: Any) -> str:
    """Return a value as TOML, with floats in their shortest exact form, and keys of tables quoted if necessary."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        return "{ " + ", ".join(_toml_lines(value)) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(toml_value(part) for part in value if part is not None) + "]"
    return repr(value)


def to_toml(content: Mapping[str, Any]) -> str:
    """Return a document as TOML: top-level keys, tables and lists of tables, with nested tables in one line.

    TOML has no None; keys with the value None are omitted.
    """
    own, tables = list[str](), list[str]()
    for key, value in content.items():
        if isinstance(value, Mapping):
            tables += ["", f"[{_toml_key(key)}]", *_toml_lines(value)]
        elif isinstance(value, list) and value and all(isinstance(part, Mapping) for part in value):
            for part in value:
                tables += ["", f"[[{_toml_key(key)}]]", *_toml_lines(part)]
        else:
            own += _toml_lines({key: value})
    return "\n".join([*own, *tables]) + "\n"


def _toml_lines(table: Mapping[str, Any]) -> list[str]:
    return [f"{_toml_key(key)} = {toml_value(value)}" for key, value in table.items() if value is not None]


def _toml_key(key: object) -> str:
    text = str(key)
    return text if _BARE_KEY.fullmatch(text) else json.dumps(text, ensure_ascii=False)
