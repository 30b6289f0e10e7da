"""The base class of breaking criteria, and the function `failure_measure`, which each criterion registers for its constants."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from ...support.dispatch import dispatch_by_class
from ...support.parameter_fields import field
from ...support.tagged_union import Named


class LinkStress(NamedTuple):
    """The quantities of a link that a breaking criterion uses.

    Attributes:
        eps: strain along the link.
        gamma: shear angle of the link.
        normal: traction along the link, tension positive [Pa].
        tangential: traction across the link [Pa].
        equivalent: von Mises equivalent stress [Pa].
        mean: mean stress, tension positive [Pa].
        factor: factor of the strength of this link.
        number: number of the link in the fields.
    """

    eps: float
    gamma: float
    normal: float
    tangential: float
    equivalent: float
    mean: float
    factor: float
    number: int


@dispatch_by_class
def failure_measure(law, link):
    """Return the quantity of a link that its criterion tests, the limit, and the number of the cause of breaking.

    Args:
        law: constants of the criterion, whose class selects the function.
        link: a `LinkStress`.
    """


class Criterion(Named):
    """A condition under which a linked pair breaks."""

    causes: ClassVar[Mapping[str, str]]
    """The causes of breaking, in the order in which `failure_measure` numbers them: kind of event -> description."""
    unit: ClassVar[str] = "Pa"
    """Unit of the quantity that the criterion tests, and of its limit."""

    @abstractmethod
    def constants(self) -> Any:
        """Return the constants of the criterion, in a `NamedTuple` for whose class `failure_measure` is registered."""

    def unbreakable_constants(self) -> Any:
        """Return constants of the same class with which links never break."""
        kind = type(self.constants())
        return kind(*(math.inf for _ in kind._fields))


class UnbreakableLaw(NamedTuple):
    """The law of links that never break."""

    limit: float = math.inf


class Unbreakable(Criterion):
    """No criterion: pairs always stay linked."""

    name: Literal["none"] = field("none", "which criterion", "1")
    causes = {}

    def constants(self) -> UnbreakableLaw:
        """Return a law with an infinite limit."""
        return UnbreakableLaw()


@failure_measure.register(UnbreakableLaw)
def _unbreakable_failure_measure(law, link):
    return 0.0, law.limit, 0


class WeakerLaw(NamedTuple):
    """The law if there are several materials: each link has two laws, and breaks if one of them is met.

    Attributes:
        laws: constants of all laws, which belong to one criterion.
        rows: for each link the indices of its two laws in `laws`, shape (links, 2).
    """

    laws: tuple[Any, ...]
    rows: npt.NDArray[np.int64]


@failure_measure.register(WeakerLaw)
def _weaker_failure_measure(law, link):
    value, limit, cause = failure_measure(law.laws[law.rows[link.number, 0]], link)
    other_value, other_limit, other_cause = failure_measure(law.laws[law.rows[link.number, 1]], link)
    if other_value / other_limit > value / limit:
        return other_value, other_limit, other_cause
    return value, limit, cause
