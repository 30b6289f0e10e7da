"""Documents: pydantic models of whole TOML files, which know their file and overrides to locate faults."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Self, TypeVar

import numpy as np
from pydantic import PrivateAttr, ValidationError

from granular_env.components.errors import ExperimentError, Fault, GranularError, Override, StepError
from granular_env.components.support.html_summary import html_summary
from granular_env.components.support.validation import validation_faults

from .files import find_file, read_toml
from .overrides import Overrides, fault_source, set_key, to_overrides
from .table import Table

D = TypeVar("D", bound="Document")


class Document(Table):
    """Base class of the models of whole files.

    Attributes:
        kind: name of the kind of document in messages.
        shelf: kind of shipped files, as in `shipped_files`.
    """

    kind: ClassVar[str]
    shelf: ClassVar[str]

    _origin: str = PrivateAttr("")
    _folder: Path = PrivateAttr(default_factory=Path)
    _overrides: tuple[Override, ...] = PrivateAttr(())

    def _repr_html_(self) -> str:
        content = self.to_dict()
        rows = [(key, *item) for key, value in content.items() if isinstance(value, dict) for item in value.items()]
        facts = {key: value for key, value in content.items() if not isinstance(value, dict)}
        return html_summary(self.kind, facts, ("table", "key", "value"), rows)

    @property
    def origin(self) -> str:
        """The name of the source file in messages."""
        return self._origin

    @property
    def folder(self) -> Path:
        """The base folder of relative paths in the document."""
        return self._folder

    @property
    def overrides(self) -> tuple[Override, ...]:
        """Return the overrides that were applied to the content of the file."""
        return self._overrides

    @classmethod
    def parse(
        cls, content: Mapping[str, Any], origin: str = "", folder: Path | None = None, overrides: tuple[Override, ...] = ()
    ) -> Self:
        """Return a document from the content of its file; raise one `ExperimentError` with all faults."""
        origin = origin or cls.kind
        try:
            document = cls.model_validate(content)
            document._origin, document._folder, document._overrides = origin, folder or Path(), overrides
            return document
        except ValidationError as error:
            faults = validation_faults(error, content, cls)
        except (ValueError, TypeError, ArithmeticError, RecursionError, LookupError) as error:
            faults = [Fault(received=f"cannot be used: {error}")]
        raise ExperimentError(*(replace(one, source=fault_source(one.location, origin, overrides)) for one in faults))

    def to_dict(self) -> dict[str, Any]:
        """Return plain values for TOML, JSON and `parse`, without the defaults."""
        return self.model_dump(mode="json", by_alias=True, exclude_none=True, exclude_unset=True, serialize_as_any=True)

    @contextmanager
    def locate_errors(self, *location: str | int) -> Iterator[None]:
        """Add to errors raised in the block their location in this document, and the override or file that contains it.

        Raises:
            ExperimentError: instead of the original error, with the same faults.
        """
        try:
            yield
        except (ExperimentError, StepError):
            raise
        except GranularError as error:
            raise ExperimentError(*(self.locate_fault(fault, *location) for fault in error.faults)) from error

    def locate_fault(self, fault: Fault, *location: str | int) -> Fault:
        """Return a fault with its location in this document, and the override or file that contains it."""
        placed = fault.with_outer_location(*location)
        return replace(placed, source=fault_source(placed.location, self.origin, self.overrides))


def load_document(
    model: type[D],
    source: str | os.PathLike[str] | Mapping[str, Any] | D,
    overrides: Overrides = (),
    folder: Path | None = None,
) -> D:
    """Return a document; its keys and values are validated, but the component that it describes is not built.

    Args:
        model: the kind of document.
        source: a shipped name, the path of a TOML file, its content as a mapping, or a document.
        overrides: keys to set, such as ``{"component.grains": 500, "stop.0.above": 2.0}``.
        folder: base folder of files named in a mapping; default: the current folder.

    Raises:
        ExperimentError: names file, table and key, the received and the expected value.
    """
    changes, before = to_overrides(overrides), ()
    if isinstance(source, model):
        if not changes:
            return source
        content, origin, folder, before = source.to_dict(), source.origin, source.folder, source.overrides
    elif isinstance(source, Mapping):
        content, origin = _plain_value(source), model.kind
    else:
        path = find_file(source, model.kind, model.shelf)
        content, origin, folder = read_toml(path), str(path), path.parent
    for override in changes:
        set_key(content, replace(override, value=_plain_value(override.value)))
    return model.parse(content, origin, folder, (*before, *changes))


def _plain_value(value: Any) -> Any:
    """Return a copy of a value, converted to types that a TOML file has (NumPy arrays become lists)."""
    if isinstance(value, Mapping):
        return {str(key): _plain_value(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_plain_value(part) for part in value]
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return os.fspath(value) if isinstance(value, os.PathLike) else value
