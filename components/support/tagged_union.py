"""Parameters that are tables chosen by name: `law = "hertz"`, `arrangement = {name = "dimer", ...}`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import GetCoreSchemaHandler, SerializerFunctionWrapHandler, ValidationError, model_serializer
from pydantic_core import CoreSchema, core_schema

from ..errors import ParameterError, nearest, one_line
from .validation import Choices, Parameters, faults_of


class Named(Parameters):
    """A table of parameters, chosen among several by its `name`; each class declares that name, a Literal, as its default."""

    name: Any

    @model_serializer(mode="wrap")
    def _always_with_its_name(self, serialize: SerializerFunctionWrapHandler) -> dict[str, Any]:
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
        return core_schema.no_info_before_validator_function(self.choose, handler(source))

    def choose(self, given: Any) -> Named:
        """Return the table; raise a fault if it is unknown or not valid."""
        if type(given) in self.choices.values():
            return given
        fields = {"name": given} if isinstance(given, str) else given
        known = ", ".join(self.choices)
        if not isinstance(fields, Mapping):
            raise ParameterError(f"got {one_line(given)}", expected="a name, or a table with one", hint=f"known: {known}")
        name = fields.get("name")
        if name is None:
            raise ParameterError("missing", hint=f"known: {known}", at="name")
        if not isinstance(name, str) or name not in self.choices:
            at = () if isinstance(given, str) else ("name",)
            hint = nearest(str(name), self.choices)
            raise ParameterError(f"got {one_line(name)}", expected="a known name", hint=hint, at=at)
        model = self.choices[name]
        try:
            return model(**{str(key): value for key, value in fields.items()})
        except ValidationError as error:
            raise ParameterError(*faults_of(error, fields, model)) from None


@dataclass(frozen=True)
class OneOrEach(ByName):
    """Select one table for all of several items, or a list with one table for each."""

    def choose(self, given: Any) -> Any:
        """Return the table, or a list of tables; raise a fault with its position in the list."""
        if not isinstance(given, (list, tuple)):
            return super().choose(given)
        chosen = []
        for place, one in enumerate(given):
            try:
                chosen.append(super().choose(one))
            except ParameterError as error:
                raise error.within(place) from None
        return chosen
