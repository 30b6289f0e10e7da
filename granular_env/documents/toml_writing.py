"""Writing of TOML: values, whole documents, and the name in a file that keeps its comments."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def rename(text: str, name: str) -> str:
    """Return the text of a TOML file with its own key `name` set; comments stay."""
    return re.sub(r"^name\s*=.*$", lambda _: f"name = {toml_value(name)}", text, count=1, flags=re.MULTILINE)


def toml_value(value: Any) -> str:
    """Return a value as TOML; floats in their shortest exact form, keys of tables in quotes where they need them."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        return "{ " + ", ".join(_lines(value)) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(toml_value(part) for part in value if part is not None) + "]"
    return repr(value)


def to_toml(content: Mapping[str, Any]) -> str:
    """Return a document as TOML: its own keys, its tables, one level of tables within them, and lists of tables.

    None has no form in TOML; such keys are left out.
    """
    lines = _lines({key: value for key, value in content.items() if not _is_table(value)})
    for key, value in content.items():
        if isinstance(value, Mapping):
            lines += _table(_key(key), value)
        elif _is_table(value):
            for part in value:
                lines += ["", f"[[{_key(key)}]]", *_lines(part)]
    return "\n".join(lines) + "\n"


def _table(head: str, content: Mapping[str, Any]) -> list[str]:
    inner = {key: value for key, value in content.items() if isinstance(value, Mapping) and value}
    own = _lines({key: value for key, value in content.items() if key not in inner})
    lines = ["", f"[{head}]", *own] if own or not inner else []
    for key, value in inner.items():
        lines += ["", f"[{head}.{_key(key)}]", *_lines(value)]
    return lines


def _lines(table: Mapping[str, Any]) -> list[str]:
    return [f"{_key(key)} = {toml_value(value)}" for key, value in table.items() if value is not None]


def _key(key: object) -> str:
    text = str(key)
    return text if _BARE_KEY.fullmatch(text) else json.dumps(text, ensure_ascii=False)


def _is_table(value: Any) -> bool:
    tables = isinstance(value, list) and bool(value) and all(isinstance(part, Mapping) for part in value)
    return tables or isinstance(value, Mapping)
