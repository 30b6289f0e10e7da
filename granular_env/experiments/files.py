"""Checks of TOML text before it is parsed."""

from __future__ import annotations

import re

from granular_env.components.errors import ExperimentError

# Keys of a TOML file are a few parts long; tomllib takes quadratic time over a key of thousands.
_LONGEST_KEY = 64
_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+"""
_LONG_KEY = re.compile(rf"""(?<![\w"'.-])(?:{_PART}){{{_LONGEST_KEY}}}""")


def refuse_long_keys(where: object, text: str) -> None:
    """`ExperimentError` with the place and line of a dotted key of more parts than any experiment has."""
    found = _LONG_KEY.search(text)
    if found is not None:
        line = text.count("\n", 0, found.start()) + 1
        raise ExperimentError(f"{where}: line {line}: a key of more than {_LONGEST_KEY} parts; keys have a few")
