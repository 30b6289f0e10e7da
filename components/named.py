"""Parameters that are tables of their own, and chosen by name."""

from __future__ import annotations

from typing import Any

from pydantic import SerializerFunctionWrapHandler, model_serializer

from .contract import Parameters


class Named(Parameters):
    """A table of parameters that its `name` chooses among several; each declares that name, a Literal, as its default."""

    name: Any

    @model_serializer(mode="wrap")
    def _always_with_its_name(self, serialize: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Also where defaults are left out: names may differ while all fields agree, and identities must tell them apart."""
        return {"name": self.name, **serialize(self)}
