"""Derivatives with respect to parameters, from those with respect to the chain's table: the transpose of `geometry`.

The internal step is kept constant, whatever the parameters would suggest; so are the start displacements and velocities
relative to the rest configuration. A gradient has the shape of the parameter as given: one number for all, or one each; radii
from an arrangement or at random have one each. Gradients for contacts have n + 1 places, 0 without a contact.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ...errors import ParameterError, spelling_hint
from ...support.float_arrays import FloatArray
from ...support.jit import jit
from ..arrangements import Uniform
from ..component import Chain
from ..laws import LAWS, Dissipative
from ..laws.functions import force_pullback
from ..layout import GRAVITY, INVERSE_MASS, LAW_CONSTANTS, LEFT_STATIC, MASS, REST_OVERLAP, RIGHT_STATIC, SCALARS, STIFFNESS
from ..state import chain_state
from .gradient import Adjoints


def parameter_gradient(chain: Chain, adjoints: Adjoints, name: str) -> float | FloatArray:
    """Return the derivative with respect to the drive, shape (steps, 2), a start value (n,) or a parameter (its own shape).

    Raises:
        ParameterError: there is no such derivative; the message gives advice.
    """
    if name not in KNOWN:
        raise ParameterError(f"{name!r} has no gradient", hint=spelling_hint(name, KNOWN), at="with_respect_to")
    return KNOWN[name](chain, adjoints)


class _GeometryDerivatives:
    """Derivatives with respect to masses, stiffnesses and static forces, including their effects on the static overlaps."""

    def __init__(self, chain: Chain, adjoints: Adjoints) -> None:
        p, g, n = chain.parameters, chain.geometry, chain.parameters.grains
        self.real = g.contact_slice
        real = np.zeros(n + 1, dtype=bool)
        real[g.contact_slice] = True
        rest = np.where(real, adjoints.table[REST_OVERLAP, : n + 1], 0.0)
        # The static overlap solves F(d, k) = F0: dd/dF0 = 1 / (dF/dd) and dd/dk = -(dF/dk) / (dF/dd).
        pressed = g.static_overlap > 0.0
        slopes = static_force_slopes(chain)
        by_force, by_stiffness = np.zeros(n + 1), np.zeros(n + 1)
        by_force[pressed] = 1.0 / slopes[0, pressed]
        by_stiffness[pressed] = -slopes[1, pressed] / slopes[0, pressed]
        self.unloaded = real & ~pressed
        self.static = rest * by_force
        self.static[0] += adjoints.table[SCALARS, LEFT_STATIC]
        self.static[n] += adjoints.table[SCALARS, RIGHT_STATIC]
        self.stiffness = np.where(real, adjoints.table[STIFFNESS, : n + 1], 0.0) + rest * by_stiffness
        self.gap = -rest
        inner = slice(1, n + 1)
        self.mass = adjoints.table[MASS, inner] - adjoints.table[INVERSE_MASS, inner] / (g.mass * g.mass)
        # The motion of a prescribed grain does not depend on its mass.
        self.moved = chain.table[INVERSE_MASS, inner] > 0.0
        self.weight = _weight_adjoint(chain, self.static) if _has_static_weight(chain) else np.zeros(n)
        self.mass = np.where(self.moved, self.mass + p.gravity * self.weight, 0.0)


def static_force_slopes(chain: Chain) -> FloatArray:
    """Return dF/dd and dF/dk of every contact at its static overlap, shape (2, n + 1)."""
    adjoint, slopes = np.zeros_like(chain.table), np.zeros((2, chain.parameters.grains + 1))
    _write_static_force_slopes(chain.state.law, chain.table, adjoint, chain.geometry.static_overlap, slopes)
    return slopes


@jit
def _write_static_force_slopes(kind, table, adjoint, overlap, out):
    chain, reverse = chain_state(kind, table), chain_state(kind, adjoint)
    for j in range(len(overlap)):
        out[0, j] = force_pullback(chain.law, reverse.law, j, overlap[j], 1.0)
        out[1, j] = reverse.law.stiffness[j]


def _has_static_weight(chain: Chain) -> bool:
    """Return whether contacts carry weight at the start, i.e. with gravity and without gaps."""
    return chain.parameters.gravity != 0.0 and not np.any(np.asarray(chain.parameters.gap) > 0.0)


def _weight_adjoint(chain: Chain, static: FloatArray) -> FloatArray:
    """Return the derivative with respect to the weight of each grain, which the contacts on one side of it carry."""
    p = chain.parameters
    carried = np.cumsum(static[::-1])[::-1][1:]
    total = p.gravity * float(chain.table[MASS, 1 : p.grains + 1].sum())
    from_the_left = p.left != "free" and (p.right == "free" or total < 0.0)
    return carried - static.sum() if from_the_left else carried


def _refuse_dependent_constants(chain: Chain, name: str) -> None:
    """Refuse a law whose constants depend on stiffness or radius, because the derivative would lack this dependence."""
    g, chosen = chain.geometry, chain.parameters.law
    # Scale k and R* by different factors, so that constants that depend only on k / R* change too.
    moved = chosen.contact_constants(1.5 * g.stiffness, 1.25 * g.reduced_radius, g.yield_strength, g.contact_slice)
    if not np.array_equal(moved, g.law_constants[g.contact_slice, : moved.shape[1]]):
        raise ParameterError(
            f"{name!r} has no derivative for law {chosen.name!r}, whose constants depend on stiffness or radius",
            hint=f"leave {name!r} out",
            at="with_respect_to",
        )


def _refuse_unloaded_contacts(chain: Chain, derivatives: _GeometryDerivatives, name: str) -> None:
    if derivatives.unloaded.any():
        where = int(np.argmax(derivatives.unloaded))
        raise ParameterError(
            f"{name!r} has no derivative here: contact {where} carries no static force, and its overlap at rest "
            f"grows as (force)^(1/{chain.parameters.law.exponent:g})",
            hint=f"give precompression, or leave {name!r} out",
            at="with_respect_to",
        )


def _radius_gradient(chain: Chain, adjoints: Adjoints) -> float | FloatArray:
    p, g, n, derivatives = chain.parameters, chain.geometry, chain.parameters.grains, _GeometryDerivatives(chain, adjoints)
    _refuse_dependent_constants(chain, "radius")
    if _has_static_weight(chain):
        _refuse_unloaded_contacts(chain, derivatives, "radius")
    gradient = np.where(has_computed_mass(chain), 3.0 * g.mass / g.radius * derivatives.mass, 0.0)
    if p.contact_stiffness is None:
        # K ~ sqrt(R*), 1/R* = 1/R_left + 1/R_right.
        by_curvature = np.zeros(n + 1)
        by_curvature[g.contact_slice] = (0.5 * derivatives.stiffness * g.stiffness * g.reduced_radius)[g.contact_slice]
        gradient += (by_curvature[1:] + by_curvature[:-1]) / (g.radius * g.radius)
        for end, column, place in ((p.left, 0, 0), (p.right, -1, n)):
            if end == "fixed_grain":  # it has the radius of the adjacent grain
                gradient[column] += by_curvature[place] / (g.radius[column] * g.radius[column])
    one_for_all = isinstance(p.radius, float) and isinstance(p.arrangement, Uniform)
    return float(gradient.sum()) if one_for_all else gradient


def has_computed_mass(chain: Chain) -> npt.NDArray[np.bool_]:
    """Return which grains have the mass density x volume, shape (n,)."""
    p = chain.parameters
    natural = np.isnan(p.arrangement.masses(np.full(p.grains, np.nan)))
    if isinstance(p.mass, dict):
        natural[list(p.mass)] = False
    elif p.mass is not None:
        natural[:] = False
    return natural


def _mass_gradient(chain: Chain, adjoints: Adjoints) -> float | FloatArray:
    derivatives = _GeometryDerivatives(chain, adjoints)
    if _has_static_weight(chain):
        _refuse_unloaded_contacts(chain, derivatives, "mass")
    return float(derivatives.mass.sum()) if isinstance(chain.parameters.mass, float) else derivatives.mass


def _contact_stiffness_gradient(chain: Chain, adjoints: Adjoints) -> float | FloatArray:
    derivatives = _GeometryDerivatives(chain, adjoints)
    _refuse_dependent_constants(chain, "contact_stiffness")
    return (
        float(derivatives.stiffness.sum()) if isinstance(chain.parameters.contact_stiffness, float) else derivatives.stiffness
    )


def _precompression_gradient(chain: Chain, adjoints: Adjoints) -> float:
    derivatives = _GeometryDerivatives(chain, adjoints)
    _refuse_unloaded_contacts(chain, derivatives, "precompression")
    return float(derivatives.static.sum())


def _gap_gradient(chain: Chain, adjoints: Adjoints) -> float | FloatArray:
    derivatives = _GeometryDerivatives(chain, adjoints)
    return derivatives.gap if isinstance(chain.parameters.gap, list) else float(derivatives.gap[derivatives.real].sum())


def _gravity_gradient(chain: Chain, adjoints: Adjoints) -> float:
    derivatives = _GeometryDerivatives(chain, adjoints)
    if chain.parameters.gravity == 0.0:
        raise ParameterError(
            "'gravity' has no gradient at gravity = 0", hint="set gravity, or leave 'gravity' out", at="with_respect_to"
        )
    if _has_static_weight(chain):
        _refuse_unloaded_contacts(chain, derivatives, "gravity")
    weighed = chain.table[MASS, 1 : chain.parameters.grains + 1]
    return float(adjoints.table[SCALARS, GRAVITY] + (weighed * derivatives.weight).sum())


def _dissipation_gradient(chain: Chain, adjoints: Adjoints) -> float | FloatArray:
    chosen = chain.parameters.law
    if not isinstance(chosen, Dissipative):
        known = " or ".join(name for name, one in LAWS.items() if issubclass(one, Dissipative))
        raise ParameterError(f"law {chosen.name!r} has no dissipation", hint=f"use law {known}", at="with_respect_to")
    real = chain.geometry.contact_slice
    if not isinstance(chosen.dissipation, list):
        return float(adjoints.table[LAW_CONSTANTS, real].sum())
    gradient = np.zeros(chain.parameters.contact_places)
    gradient[real] = adjoints.table[LAW_CONSTANTS, real]
    return gradient


KNOWN: dict[str, Callable[[Chain, Adjoints], float | FloatArray]] = {
    "drive": lambda chain, adjoints: adjoints.inputs,
    "radius": _radius_gradient,
    "mass": _mass_gradient,
    "contact_stiffness": _contact_stiffness_gradient,
    "precompression": _precompression_gradient,
    "dissipation": _dissipation_gradient,
    "gap": _gap_gradient,
    "gravity": _gravity_gradient,
    "velocity": lambda chain, adjoints: adjoints.velocity,
    "displacement": lambda chain, adjoints: adjoints.displacement,
}
"""Name of each parameter, input or start value that has a gradient -> function that returns the gradient."""
