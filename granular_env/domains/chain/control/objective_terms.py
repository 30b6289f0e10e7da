"""Terms from which objectives are built without writing compiled functions, and a guide to writing a custom objective.

    J = total(chain, velocity(-1).at_end(target=5.0), 1e-4 * contact_force(-1).peak(scale=100.0))

is the squared deviation of the last grain's final velocity from 5 m/s, plus a small multiple of the peak force in the last
contact. Objectives are minimised; a factor of -1 in front of a term maximises its quantity.

A custom objective consists of three jitted functions. For the kinetic energy of grain 5, averaged over the run:

    from granular_env.components.chain.layout import MASS, V
    from granular_env.components.support.jit import jit

    @jit
    def note(chain, step, steps, inputs, constants, sums):
        sums[0] += 0.5 * chain.rows[MASS, 6] * chain.rows[V, 6] ** 2 / steps

    @jit
    def value(sums, constants, slopes):
        slopes[0] = 1.0
        return sums[0]

    @jit
    def pullback(chain, adjoint, step, steps, inputs, input_adjoint, constants, slopes):
        adjoint.rows[V, 6] += slopes[0] * chain.rows[MASS, 6] * chain.rows[V, 6] / steps
        adjoint.rows[MASS, 6] += slopes[0] * 0.5 * chain.rows[V, 6] ** 2 / steps

    J = Objective(note, value, pullback)
    check_objective(J, chain)

`components.chain.differentiable_quantities` provides quantities with their pullbacks;
`derivative_check.check_objective` finds errors in a `pullback`.
Derivatives exist with respect to displacements, velocities, inputs and the constants in `rows`, but not the row PEAK.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from granular_env.components.chain import Chain, differentiable_quantities
from granular_env.components.chain.layout import U, V
from granular_env.components.chain.objective import Objective
from granular_env.components.errors import ParameterError, one_line
from granular_env.components.support.jit import jit
from granular_env.components.support.validation import finite_number

from .gradient import refuse_without_gradients

__all__ = [
    "Objective",
    "Quantity",
    "Term",
    "end_input",
    "contact_force",
    "displacement",
    "energy",
    "kinetic_energy",
    "momentum",
    "total",
    "velocity",
]


_VELOCITY, _DISPLACEMENT, _CONTACT_FORCE, _KINETIC, _ENERGY, _MOMENTUM, _APPLIED = range(7)
_LINEAR, _SQUARED, _PEAK = range(3)
# Columns of a term's constants: quantity (0), first and last grain or contact, kind, target or scale, power, window, weight.
_FIRST, _LAST, _KIND, _TARGET, _POWER, _BEGIN, _END, _WEIGHT, _TERM = range(1, 10)


@dataclass(frozen=True)
class Quantity:
    """A quantity of a chain, evaluated after each control step. Its methods return terms of an objective."""

    code: int
    first: int
    last: int
    name: str

    def at_end(self, target: float | None = None) -> Term:
        """Return the quantity after the last control step or, given a target, its squared deviation from the target."""
        return self._make_term(target, -1, 0, "at the end")

    def mean(self, target: float | None = None, *, begin: int = 0, end: int = 0) -> Term:
        """Return the mean over control steps begin to end - 1 (end = 0: to the last step), or the mean squared deviation."""
        _check_window(begin, end)
        return self._make_term(target, begin, end, "on average")

    def peak(self, scale: float, *, power: int = 32, begin: int = 0, end: int = 0) -> Term:
        """Return a smooth maximum of the quantity |q| in steps begin to end - 1: scale (sum (q / scale)^power)^(1/power).

        Args:
            scale: rough estimate of the peak, in the quantity's unit; it prevents overflow of the powers.
            power: even; a larger power is closer to the true peak but harder to minimise.
            begin: first control step of the window; negative values count from the end.
            end: first control step after the window; 0 or negative values count from the end.
        """
        if not (isinstance(scale, (int, float)) and 0.0 < scale < float("inf")):
            raise ParameterError(f"got {one_line(scale)}", expected="a positive estimate of the peak", at="scale")
        if not isinstance(power, int) or power < 2 or power % 2:
            raise ParameterError(f"got {one_line(power)}", expected="an even number, at least 2", at="power")
        _check_window(begin, end)
        return Term(((self, _PEAK, float(scale), power, begin, end, 1.0),), f"peak of {self.name}")

    def _make_term(self, target: float | None, begin: int, end: int, when: str) -> Term:
        if target is not None:
            target = finite_number("target", target)
        kind, said = (_LINEAR, self.name) if target is None else (_SQUARED, f"({self.name} - {target:g})^2")
        return Term(((self, kind, target or 0.0, 1, begin, end, 1.0),), f"{said} {when}")


@dataclass(frozen=True)
class Term:
    """A term of an objective. Terms can be added, subtracted, and multiplied or divided by numbers."""

    parts: tuple[tuple[Quantity, int, float, int, int, int, float], ...]
    body: str
    factor: float = 1.0

    @property
    def description(self) -> str:
        """The term as one line of text for messages."""
        return self.body if self.factor == 1.0 else f"{self.factor:g} ({self.body})"

    def __add__(self, other: Term) -> Term:
        return Term(self.parts + other.parts, f"{self.description} + {other.description}")

    def __mul__(self, factor: float) -> Term:
        return Term(tuple((*part[:-1], factor * part[-1]) for part in self.parts), self.body, factor * self.factor)

    __rmul__ = __mul__

    def __truediv__(self, divisor: float) -> Term:
        return self * (1.0 / divisor)

    def __neg__(self) -> Term:
        return self * -1.0

    def __sub__(self, other: Term) -> Term:
        return self + -other


def _check_window(begin: Any, end: Any) -> None:
    for name, place in (("begin", begin), ("end", end)):
        if isinstance(place, bool) or not isinstance(place, (int, np.integer)):
            raise ParameterError(f"got {one_line(place)}", expected="a control step (negative: from the end)", at=name)
    if end <= begin and (begin < 0 or end > 0):  # if both are counted from the same side, end must be the later
        raise ParameterError(f"begin, end: got {begin} and {end}", expected="at least one control step between them")


def velocity(grain: int) -> Quantity:
    """Return a grain's velocity [m/s]; -1 is the last grain."""
    return Quantity(_VELOCITY, grain, grain, f"velocity[{grain}]")


def displacement(grain: int) -> Quantity:
    """Return a grain's displacement [m]; -1 is the last grain."""
    return Quantity(_DISPLACEMENT, grain, grain, f"displacement[{grain}]")


def contact_force(contact: int) -> Quantity:
    """Return the force in a contact, with its dissipative part [N]; contact i is left of grain i."""
    return Quantity(_CONTACT_FORCE, contact, contact, f"contact_force[{contact}]")


def kinetic_energy(first: int = 0, last: int = -1) -> Quantity:
    """Return the kinetic energy of grains first to last, both included [J]."""
    return Quantity(_KINETIC, first, last, f"kinetic_energy[{first}:{last}]")


def energy(first: int = 0, last: int = -1) -> Quantity:
    """Return kinetic plus elastic energy of grains first to last [J]; contacts at the border of this group count half."""
    return Quantity(_ENERGY, first, last, f"energy[{first}:{last}]")


def momentum(first: int = 0, last: int = -1) -> Quantity:
    """Return the momentum of grains first to last, both included [kg m/s]."""
    return Quantity(_MOMENTUM, first, last, f"momentum[{first}:{last}]")


def end_input(side: Literal["left", "right"]) -> Quantity:
    """Return the input at an end of the chain: the force on a free end [N] or the velocity of a piston [m/s]."""
    if side not in ("left", "right"):
        raise ParameterError(f"got {one_line(side)}", expected="'left' or 'right'", at="side")
    place = 0 if side == "left" else 1
    return Quantity(_APPLIED, place, place, f"{side} input")


def total(chain: Chain, *terms: Term) -> Objective:
    """Return the sum of terms as an objective for chains of this size and law.

    Raises:
        ParameterError: no terms, an unknown grain or contact, or forces of history-dependent contacts.
    """
    refuse_without_gradients(chain)
    for term in terms:
        if not isinstance(term, Term):
            raise ParameterError(f"got {one_line(term)}", expected="a term, such as velocity(-1).at_end()", at="terms")
    parts = [part for term in terms for part in term.parts]
    if not parts:
        raise ParameterError("got none", expected="at least one term, such as velocity(-1).at_end()", at="terms")
    constants = np.array([_term_row(chain, part) for part in parts])
    said = " + ".join(term.description for term in terms)
    return Objective(
        _add_to_sums, _objective_value, _pullback, constants.reshape(-1), len(parts), description=said,
        grains=chain.parameters.grains, fewest_steps=max(_fewest_steps(begin, end) for *_, begin, end, _ in parts),
    )  # fmt: skip


def _fewest_steps(begin: int, end: int) -> int:
    """Return the smallest number of control steps for which the window (begin, end) is not empty and within the run."""
    return max(begin + 1, -begin, end, 1 - end)


def _term_row(chain: Chain, part: tuple[Quantity, int, float, int, int, int, float]) -> list[float]:
    quantity, kind, target, power, begin, end, weight = part
    parameters, grains = chain.parameters, chain.parameters.grains
    first, last = quantity.first, quantity.last
    if quantity.code == _CONTACT_FORCE:
        first = last = _valid_index(quantity, first, parameters.contact_places)
        if not parameters.has_contact(first):
            raise ParameterError(parameters.missing_contact_reason(first), hint="give an existing contact", at=quantity.name)
    elif quantity.code != _APPLIED:
        first, last = _valid_index(quantity, first, grains), _valid_index(quantity, last, grains)
        if first > last:
            raise ParameterError(f"got {first} to {last}", expected="first grain <= last grain", at=(quantity.name,))
    if quantity.code in (_CONTACT_FORCE, _ENERGY) and chain.parameters.law.has_history:
        raise ParameterError(
            f"contacts of law {chain.parameters.law.name!r} depend on their history", hint="use another law", at=quantity.name
        )  # type: ignore[attr-defined]
    return [quantity.code, first, last, kind, target, power, begin, end, weight]


def _valid_index(quantity: Quantity, index: int, count: int) -> int:
    if isinstance(index, bool) or not isinstance(index, (int, np.integer)) or not -count <= index < count:
        raise ParameterError(f"got {one_line(index)}", expected=f"{-count} to {count - 1}", at=quantity.name)
    return int(index) % count


@jit
def _term_window(constants, base, steps):
    begin, end = int(constants[base + _BEGIN]), int(constants[base + _END])
    return (steps + begin if begin < 0 else begin), (steps + end if end <= 0 else end)


@jit
def _quantity_value(chain, inputs, constants, base):
    code, first, last = int(constants[base]), int(constants[base + _FIRST]), int(constants[base + _LAST])
    if code == _VELOCITY:
        return chain.rows[V, first + 1]
    if code == _DISPLACEMENT:
        return chain.rows[U, first + 1]
    if code == _CONTACT_FORCE:
        return differentiable_quantities.contact_force(chain, first)
    if code == _KINETIC:
        return differentiable_quantities.kinetic_energy(chain, first, last)
    if code == _ENERGY:
        return differentiable_quantities.energy(chain, first, last)
    if code == _MOMENTUM:
        return differentiable_quantities.momentum(chain, first, last)
    return inputs[first]


@jit
def _quantity_pullback(chain, adjoint, input_adjoint, constants, base, slope):
    code, first, last = int(constants[base]), int(constants[base + _FIRST]), int(constants[base + _LAST])
    if code == _VELOCITY:
        adjoint.rows[V, first + 1] += slope
    elif code == _DISPLACEMENT:
        adjoint.rows[U, first + 1] += slope
    elif code == _CONTACT_FORCE:
        differentiable_quantities.contact_force_pullback(chain, adjoint, first, slope)
    elif code == _KINETIC:
        differentiable_quantities.kinetic_energy_pullback(chain, adjoint, first, last, slope)
    elif code == _ENERGY:
        differentiable_quantities.energy_pullback(chain, adjoint, first, last, slope)
    elif code == _MOMENTUM:
        differentiable_quantities.momentum_pullback(chain, adjoint, first, last, slope)
    else:
        input_adjoint[first] += slope


@jit
def _add_to_sums(chain, step, steps, inputs, constants, sums):
    for k in range(len(sums)):
        base = k * _TERM
        begin, end = _term_window(constants, base, steps)
        if begin <= step < end:
            q, kind, target = (
                _quantity_value(chain, inputs, constants, base),
                constants[base + _KIND],
                constants[base + _TARGET],
            )
            if kind == _PEAK:
                sums[k] += differentiable_quantities.peak_feature(q, target, int(constants[base + _POWER]))
            elif kind == _SQUARED:
                sums[k] += (q - target) * (q - target) / (end - begin)
            else:
                sums[k] += q / (end - begin)


@jit
def _objective_value(sums, constants, slopes):
    total = 0.0
    for k in range(len(sums)):
        base = k * _TERM
        weight, term, slope = constants[base + _WEIGHT], sums[k], 1.0
        if constants[base + _KIND] == _PEAK:
            term, slope = differentiable_quantities.peak_value(sums[k], constants[base + _TARGET], constants[base + _POWER])
        total += weight * term
        slopes[k] = weight * slope
    return total


@jit
def _pullback(chain, adjoint, step, steps, inputs, input_adjoint, constants, slopes):
    for k in range(len(slopes)):
        base = k * _TERM
        begin, end = _term_window(constants, base, steps)
        if begin <= step < end:
            kind, target, slope = constants[base + _KIND], constants[base + _TARGET], slopes[k] / (end - begin)
            if kind == _PEAK:
                q = _quantity_value(chain, inputs, constants, base)
                slope = slopes[k] * differentiable_quantities.peak_feature_pullback(q, target, int(constants[base + _POWER]))
            elif kind == _SQUARED:
                slope *= 2.0 * (_quantity_value(chain, inputs, constants, base) - target)
            _quantity_pullback(chain, adjoint, input_adjoint, constants, base, slope)
