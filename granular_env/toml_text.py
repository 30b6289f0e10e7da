"""Values and documents as the text of a TOML file."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def toml_value(value: Any) -> str:
    """Return a value as TOML writes it; entries that are None are left out."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, BaseModel):
        value = value.model_dump()
        # What has nothing but a name may be given as that name.
        return toml_value(value["name"] if value.keys() == {"name"} else value)
    if isinstance(value, Mapping):
        parts = [f"{_key(key)} = {toml_value(part)}" for key, part in value.items() if part is not None]
        return "{ " + ", ".join(parts) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    return repr(value)


def toml_text(content: Mapping[str, Any]) -> str:
    """Return a document as text, its tables under heads of their own, as people write them."""
    plain = {key: value for key, value in content.items() if not isinstance(value, Mapping) and not _is_tables(value)}
    lines = _lines(plain)
    for key, value in content.items():
        if isinstance(value, Mapping):
            lines += _table(_key(key), value)
        elif _is_tables(value):
            for table in value:
                lines += ["", f"[[{_key(key)}]]", *_lines(table)]
    return "\n".join(lines) + "\n"


def _table(head: str, table: Mapping[str, Any]) -> list[str]:
    """Return the lines of a table; if it holds nothing but tables, each of them has a head."""
    if table and all(isinstance(value, Mapping) for value in table.values()):
        return [line for key, value in table.items() for line in _table(f"{head}.{_key(key)}", value)]
    return ["", f"[{head}]", *_lines(table)]


def _lines(table: Mapping[str, Any]) -> list[str]:
    return [f"{_key(key)} = {_long(value)}" for key, value in table.items() if value is not None]


def _long(value: Any) -> str:
    """Return a value; text of several lines as such."""
    if isinstance(value, str) and "\n" in value and '"""' not in value and "\\" not in value and not value.endswith('"'):
        return f'"""\n{value}"""'
    return toml_value(value)


def _key(key: object) -> str:
    return str(key) if _BARE_KEY.fullmatch(str(key)) else json.dumps(str(key), ensure_ascii=False)


def _is_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(entry, Mapping) for entry in value)
