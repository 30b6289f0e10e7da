"""Tables of a document: strict pydantic models with faults as data, and unions of tables selected by a key."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self, get_args

from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler, ModelWrapValidatorHandler, ValidationError, model_validator
from pydantic_core import CoreSchema, core_schema

from granular_env.components.errors import ParameterError, one_line, spelling_hint
from granular_env.components.support.validation import validation_faults


class Table(BaseModel):
    """Base class of all tables of a document: frozen, strict types, no unknown keys, finite numbers.

    The message for a missing field uses its description, or "advice" in its `json_schema_extra`.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False, validate_default=True)

    @classmethod
    def advice_for_unknown(cls, key: str, given: Mapping[str, Any]) -> str:
        """Return the hint for an unknown key of the table; "" to suggest the nearest known key."""
        return ""

    @model_validator(mode="wrap")
    @classmethod
    def _translate_errors(cls, content: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Convert pydantic's errors to faults, with the names of this table."""
        try:
            return handler(content)
        except ValidationError as error:
            raise ParameterError(*validation_faults(error, content, cls)) from None


@dataclass(frozen=True)
class TableChoice:
    """A marker for a union of tables selected by a key: ``Annotated[Triangle | Constant, TableChoice("profile")]``.

    Each table declares this key as a field whose type is a Literal with its value.
    """

    key: str

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Validate only the selected table, so that only faults of this table are reported."""
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
