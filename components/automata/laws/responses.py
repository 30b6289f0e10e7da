"""Response functions of a pair: the four of Psakhie et al. (2003), figure 3.

(a) is linear. Beyond an onset stress the others follow a line of smaller slope, and differ in unloading: (b) returns to the
origin with a reduced modulus, (c) is elastic and leaves a permanent strain, (d) combines both. beta is the fraction
of the excess stress that reduces the modulus: 1 in (b), 0 in (c).

With the equivalent stress s above the limit s_l = onset + H q, where q is the accumulated inelastic strain, the stress deviator
of the pair is multiplied by M = s_new / s, s_new = s_l + H dq, dq = (s - s_l) / (g (3 G + H)) (Wilkins 1964). The fraction beta
of 1 - M lowers the stiffness g, g -> M_d g with M_d = 1 - beta (1 - M); the rest, M_p = M / M_d, is flow:

    eps_p -> eps - M_p (eps - eps_p) - (1 - M_p) theta / 3,        gamma_p -> gamma - M_p (gamma - gamma_p).
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from pydantic import SerializeAsAny

from ...support.float_arrays import FloatArray
from ...support.jit import internal_inlined
from ...support.parameter_fields import Magnitude, NotNegativeMagnitude, field
from ...support.tagged_union import Named, OneOrEach

# Smallest fraction g of the shear modulus that a degraded pair keeps. Its decisive stress is the mean of both automata, and the
# other pairs may keep this mean above the limit forever.
WORN_OUT = 1e-6


class ResponseConstants(NamedTuple):
    """Onset stress [Pa], slope H of the stress over the inelastic strain [Pa], and the fraction beta, see above."""

    onset: float
    hardening: float
    degradation: float


class LinkResponses(NamedTuple):
    """The response laws of links.

    Attributes:
        constants: the `ResponseConstants` of each law, shape (laws, 3).
        rows: index of the law of each link, shape (links,).
    """

    constants: FloatArray
    rows: npt.NDArray[np.int64]


class ElasticResponses(NamedTuple):
    """The responses of links that are all elastic and have no history."""

    onset: float = np.inf


class Response(Named):
    """A law for the forces of a linked pair as functions of its strains."""

    elastic: ClassVar[bool] = False
    """True for a law without history."""

    def constants(self) -> ResponseConstants:
        """Return the constants of the law."""
        return ResponseConstants(np.inf, 0.0, 0.0)


class Linear(Response):
    """Forces are proportional to strains in loading and unloading: figure 3, a."""

    name: Literal["linear"] = field("linear", "which response", "1")
    elastic = True


class Degrading(Response):
    """Beyond the onset the modulus falls; unloading returns straight to the origin: figure 3, b.

    The modulus for a change of volume stays lambda + 2 g G / 3.
    """

    name: Literal["degrading"] = field("degrading", "which response", "1")
    onset: Magnitude = field(..., "equivalent stress sigma_d at which degradation begins", "Pa")
    hardening: NotNegativeMagnitude = field(0.0, "slope of the equivalent stress against the inelastic strain", "Pa")

    def constants(self) -> ResponseConstants:
        """Return onset stress, slope H, and beta = 1."""
        return ResponseConstants(self.onset, self.hardening, 1.0)


class Plastic(Response):
    """Beyond the yield stress a pair flows at constant volume; unloading is elastic and leaves a strain: figure 3, c."""

    name: Literal["plastic"] = field("plastic", "which response", "1")
    yield_stress: Magnitude = field(..., "equivalent stress sigma_y at which flow begins", "Pa")
    hardening: NotNegativeMagnitude = field(0.0, "slope of the yield stress against the plastic strain", "Pa")

    def constants(self) -> ResponseConstants:
        """Return yield stress, slope H, and beta = 0."""
        return ResponseConstants(self.yield_stress, self.hardening, 0.0)


class PlasticDegrading(Response):
    """Beyond the yield stress a pair flows and its modulus falls; unloading is flatter and leaves a strain: figure 3, d."""

    name: Literal["plastic_degrading"] = field("plastic_degrading", "which response", "1")
    yield_stress: Magnitude = field(..., "equivalent stress at which flow and degradation begin", "Pa")
    hardening: NotNegativeMagnitude = field(0.0, "slope of the equivalent stress against the inelastic strain", "Pa")
    degradation: float = field(0.5, "fraction of the excess that degrades the modulus; the rest is flow", "1", ge=0.0, le=1.0)

    def constants(self) -> ResponseConstants:
        """Return yield stress, slope H, and beta."""
        return ResponseConstants(self.yield_stress, self.hardening, self.degradation)


RESPONSES: dict[str, type[Response]] = {
    "linear": Linear,
    "degrading": Degrading,
    "plastic": Plastic,
    "plastic_degrading": PlasticDegrading,
}

ChosenResponses = Annotated[SerializeAsAny[Response] | list[SerializeAsAny[Response]], OneOrEach(RESPONSES)]


@internal_inlined
def link_response_constants(responses, number):
    """Return the `ResponseConstants` of the link with this number."""
    row = responses.rows[number]
    return ResponseConstants(responses.constants[row, 0], responses.constants[row, 1], responses.constants[row, 2])


class History(NamedTuple):
    """Plastic strains along and across a pair, the remaining fraction of its stiffness, and its total inelastic strain."""

    eps: float
    gamma: float
    stiffness: float
    inelastic: float


@internal_inlined
def updated_history(law, history, equivalent, eps, gamma, dilation, shear):
    """Return the history of a pair after a step.

    Args:
        law: a `ResponseConstants`.
        history: a `History`.
        equivalent: equivalent stress of the pair, computed with the history before the step [Pa].
        eps: strain along the pair.
        gamma: shear angle.
        dilation: mean volumetric strain of both automata.
        shear: G [Pa].
    """
    limit = law.onset + law.hardening * history.inelastic
    if not equivalent > limit or history.stiffness <= WORN_OUT:
        return history
    more = (equivalent - limit) / (history.stiffness * (3.0 * shear + law.hardening))
    ratio = (limit + law.hardening * more) / equivalent
    weaker = 1.0 - law.degradation * (1.0 - ratio)
    flow = ratio / weaker
    return History(
        eps - flow * (eps - history.eps) - (1.0 - flow) * dilation / 3.0,
        gamma - flow * (gamma - history.gamma),
        max(weaker * history.stiffness, WORN_OUT),
        history.inelastic + more,
    )
