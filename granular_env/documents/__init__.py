"""Documents: common reading, overriding, validation and writing of TOML files (experiments, studies, plans of sweeps).

A kind of document is a pydantic model on `Document` (`document.py`), made of `Table`s (`table.py`). `load` takes a shipped
name, a file, or a mapping, and keys to override (`overrides.py`). All faults are reported in one error, each with its location
and the file or the override that contains it. `files.py` finds and reads files, `toml_writing.py` writes TOML.
"""

from .document import Document, load
from .files import begins_as_log, find, read
from .overrides import Overrides, parse_assignments
from .table import ByKey, Table
from .toml_writing import rename, to_toml, toml_value

__all__ = [
    "ByKey",
    "Document",
    "Overrides",
    "Table",
    "begins_as_log",
    "find",
    "load",
    "parse_assignments",
    "read",
    "rename",
    "to_toml",
    "toml_value",
]
