"""Quantities as text in documents and on the command line, such as "100us" or "3 mm"."""

from granular_env.components.support.quantities import parse_quantity

__all__ = ["parse_quantity"]
