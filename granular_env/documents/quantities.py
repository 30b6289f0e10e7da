"""Fields of documents that accept quantities as text, such as "100us" or "3 mm"."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, ValidatorFunctionWrapHandler, WrapValidator

from granular_env.components.support.quantities import Quantity, parse_quantity, to_si

__all__ = ["Quantity", "Seconds", "Texts", "Value", "parse_quantity", "to_si"]


def _keep_quantity(given: Any, handler: ValidatorFunctionWrapHandler) -> float:
    value = to_si(given, None)
    number = handler(value)
    return value if isinstance(value, Quantity) else number


Seconds = Annotated[float, BeforeValidator(lambda value: to_si(value, "s"))]
"""A time [s]."""
Texts = BeforeValidator(lambda value: to_si(value, None))
"""Annotation of a field with values whose units are known only with the component."""
Value = Annotated[float, WrapValidator(_keep_quantity)]
"""A value in a unit that is known only with the component; `to_si` checks it then."""
