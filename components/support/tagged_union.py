"""Parameters that are tables chosen by name: `law = "hertz"`, `arrangement = {name = "dimer", ...}`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import GetCoreSchemaHandler, SerializerFunctionWrapHandler, ValidationError, model_serializer
from pydantic_core import CoreSchema, core_schema

from ..errors import ParameterError, one_line, spelling_hint
from .validation import Choices, Parameters, validation_faults


class Named(Parameters):
    """A table of parameters, chosen among several by its `name`; each class declares its name as a Literal with default."""

    name: Any

    @model_serializer(mode="wrap")
    def _serialize_with_name(self, serialize: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Include the name even if defaults are omitted: tables that differ only by name must have different identities."""
        return {"name": self.name, **serialize(self)}


@dataclass(frozen=True)
class ByName(Choices):
    """Select the table of a field, given as a name, as a mapping with its name, or as an instance.

        law: Annotated[SerializeAsAny[Law], ByName({"hertz": Hertz, "power": Power})]

    A bare name selects the table with its defaults.
    """

    choices: Mapping[str, type[Named]]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Select the table before pydantic validates it."""
        return core_schema.no_info_before_validator_function(self.choose_table, handler(source))

    def choose_table(self, selection: Any) -> Named:
        """Return the table that a name, a mapping or an instance selects; raise `ParameterError` if it is not valid."""
        if type(selection) in self.choices.values():
            return selection
        fields = {"name": selection} if isinstance(selection, str) else selection
        known = ", ".join(self.choices)
        if not isinstance(fields, Mapping):
            raise ParameterError(
                f"got {one_line(selection)}", expected="a name, or a table with the key name", hint=f"known: {known}"
            )
        name = fields.get("name")
        if name is None:
            raise ParameterError("missing", hint=f"known: {known}", at="name")
        if not isinstance(name, str) or name not in self.choices:
            at = () if isinstance(selection, str) else ("name",)
            hint = spelling_hint(str(name), self.choices)
            raise ParameterError(f"got {one_line(name)}", expected="a known name", hint=hint, at=at)
        model = self.choices[name]
        try:
            return model(**{str(key): value for key, value in fields.items()})
        except ValidationError as error:
            raise ParameterError(*validation_faults(error, fields, model)) from None


@dataclass(frozen=True)
class OneOrEach(ByName):
    """Select one table for all of several items, or a list with one table for each."""

    def choose_table(self, selection: Any) -> Any:
        """Return the table, or a list of tables; raise a fault with its position in the list."""
        if not isinstance(selection, (list, tuple)):
            return super().choose_table(selection)
        chosen = []
        for place, one in enumerate(selection):
            try:
                chosen.append(super().choose_table(one))
            except ParameterError as error:
                raise error.with_outer_location(place) from None
        return chosen
