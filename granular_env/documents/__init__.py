"""Documents: common reading, overriding, validation and writing of TOML files (experiments, studies, plans of sweeps).

A kind of document is a pydantic model on `Document` (`document.py`), made of `Table`s (`table.py`). `load_document` takes a
shipped name, a file, or a mapping, and keys to override (`overrides.py`). All faults are reported in one error, each with its
location and the file or the override that contains it. `files.py` finds and reads files, `toml_writing.py` writes TOML.
"""

from .document import Document, load_document
from .files import find_file, is_log, read_toml
from .overrides import Overrides, parse_assignments
from .table import Table, TableChoice
from .toml_writing import replace_name, to_toml, toml_value

__all__ = [
    "Document",
    "Overrides",
    "Table",
    "TableChoice",
    "find_file",
    "is_log",
    "load_document",
    "parse_assignments",
    "read_toml",
    "replace_name",
    "to_toml",
    "toml_value",
]
