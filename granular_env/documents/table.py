"""Tables of a TOML document: strict pydantic models whose errors are lists of faults, and unions selected by a key."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self, get_args

from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler, ModelWrapValidatorHandler, ValidationError, model_validator
from pydantic_core import CoreSchema, core_schema

from granular_env.components.errors import ParameterError, one_line, spelling_hint
from granular_env.components.support.validation import validation_faults


class Table(BaseModel):
    """Base class of the models of all tables of a document: frozen, with strict types, no unknown keys, finite numbers only.

    The message for a missing field shows the field's description, or the text "advice" in its `json_schema_extra`.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False, validate_default=True)

    @classmethod
    def advice_for_unknown(cls, key: str, given: Mapping[str, Any]) -> str:
        """Return the hint in the message on an unknown key of the table; "" for the usual hint, the nearest known key."""
        return ""

    @model_validator(mode="wrap")
    @classmethod
    def _translate_errors(cls, content: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Convert pydantic's validation errors to a `ParameterError` with faults, described with the keys of this table."""
        try:
            return handler(content)
        except ValidationError as error:
            raise ParameterError(*validation_faults(error, content, cls)) from None


@dataclass(frozen=True)
class TableChoice:
    """A marker for a union of tables selected by a key: ``Annotated[Triangle | Constant, TableChoice("profile")]``.

    Each table declares the key as a field whose type is a Literal with the value that selects the table.
    """

    key: str

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Make pydantic validate only the selected table of the union, so that only the faults of this table are reported."""
        return core_schema.no_info_plain_validator_function(lambda given: self._select_table(given, get_args(source)))

    def _select_table(self, content: Any, tables: tuple[type[Table], ...]) -> Table:
        if isinstance(content, tables):
            return content
        if not isinstance(content, Mapping):
            raise ParameterError(f"got {one_line(content)}", expected=f'a table with {self.key} = "..."')
        choices = {value: table for table in tables for value in get_args(table.model_fields[self.key].annotation)}
        value = content.get(self.key)
        if not isinstance(value, str) or value not in choices:
            received = "missing" if value is None else f"got {one_line(value)}"
            raise ParameterError(received, hint=spelling_hint(str(value), choices), at=(self.key,))
        return choices[value].model_validate(content)
