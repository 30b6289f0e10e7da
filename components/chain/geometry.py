"""Arrays of a chain, computed once: masses, contact stiffnesses, overlaps at rest, reference positions."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..errors import ParameterError
from ..materials.elastic import Material, to_material
from ..support.elementary_functions import nth_root
from ..support.float_arrays import FloatArray
from ..support.powers import power
from ..support.round_numbers import round_down_to_125
from .integrators import Scheme
from .laws import Dissipative
from .layout import MOST_LAW_CONSTANTS
from .parameters import WALLS, ChainParameters, UniformRadii
from .theory.collisions import duration_times_frequency

# Suggested step of PEFRL in units of (m / k)^(2/5) v^(-1/5), for an error of 3e-4 in ordinary runs; smaller with gaps.
_STEP_FACTOR, _STEP_FACTOR_WITH_GAPS = 0.1, 0.03
# Largest product of a suggested step and the dissipation / mass of a contact; the chain warns above 0.3.
_STEP_TIMES_DISSIPATION = 0.2
# The same product if the force jumps at first contact: explicit schemes then have about this relative error in velocity. The
# step is reduced to a fifth at most, because grains hardly rebound from very strong dashpots.
_STEP_TIMES_JUMP, _SHORTEST_FOR_JUMP = 2e-3, 0.2
_STEP_WITHOUT_CONTACTS = 1e-6
# Masses and stiffnesses outside this range are unit errors, and their powers would leave the range of a float.
_SMALLEST, _LARGEST, _MICROMETRES = 1e-60, 1e60, 1e6


@dataclass(frozen=True)
class Geometry:
    """Arrays of a chain with n grains and n + 1 contact places; place j is left of grain j, 0 and n are at the walls.

    All arrays are read-only.

    Attributes:
        radius: shape (n,) [m].
        mass: shape (n,) [kg].
        stiffness: k of F = k overlap^p, shape (n + 1,), 0 without a wall [N/m^p]; p = 1.5 for spheres.
        largest_stiffness: the largest k of the law, e.g. in unloading, which steps have to resolve, shape (n + 1,).
        rest_overlap: overlap in the reference configuration, negative for a gap, shape (n + 1,) [m].
        reduced_radius: R* of each contact, shape (n + 1,) [m].
        reduced_mass: m* of each contact, shape (n + 1,) [kg].
        smaller_radius: shape (n + 1,) [m].
        position: of the grains' centres in the reference configuration, the first at 0, shape (n,) [m].
        sound_speed: longitudinal, of each grain's material, shape (n,) [m/s].
        yield_strength: of the weaker side of each contact, NaN if neither is known, shape (n + 1,) [Pa].
        static_force: in each contact in the reference configuration, shape (n + 1,) [N].
        static_overlap: caused by this force, shape (n + 1,) [m].
        law_constants: of each contact in addition to its stiffness, shape (n + 1, 3).
        contact_slice: slice of the places that have a contact.
    """

    radius: FloatArray
    mass: FloatArray
    stiffness: FloatArray
    largest_stiffness: FloatArray
    rest_overlap: FloatArray
    reduced_radius: FloatArray
    reduced_mass: FloatArray
    smaller_radius: FloatArray
    position: FloatArray
    sound_speed: FloatArray
    yield_strength: FloatArray
    static_force: FloatArray
    static_overlap: FloatArray
    law_constants: FloatArray
    contact_slice: slice


def geometry(parameters: ChainParameters) -> Geometry:
    """Compute all arrays that follow from the parameters."""
    count = parameters.grains
    radius = parameters.arrangement.radii(_radius(parameters))
    materials = parameters.arrangement.materials(_materials(parameters))
    mass = _mass(parameters, radius, materials)
    walls = (parameters.left in WALLS, parameters.right in WALLS)
    real = slice(0 if walls[0] else 1, count + 1 if walls[1] else count)
    left_radius, right_radius = _side_values(
        radius, _wall_radius(parameters.left, radius[0]), _wall_radius(parameters.right, radius[-1])
    )
    reduced_radius = _half_harmonic_mean(left_radius, right_radius)
    reduced_mass = _half_harmonic_mean(*_side_values(_inertia(parameters, mass), np.inf, np.inf))
    stiffness = np.zeros(count + 1)
    stiffness[real] = _stiffness(parameters, materials, reduced_radius)[real]
    yield_strength, static_force = _yield_strength(parameters, materials), static_forces(parameters, mass)
    law, static_overlap, rest_overlap = parameters.law, np.zeros(count + 1), np.zeros(count + 1)
    constants = law.contact_constants(stiffness, reduced_radius, yield_strength, real)
    law_constants = np.zeros((count + 1, MOST_LAW_CONSTANTS))
    law_constants[real, : constants.shape[1]] = constants
    largest_stiffness = np.zeros(count + 1)
    largest_stiffness[real] = law.largest_stiffness(stiffness[real], constants)
    gap = np.broadcast_to(np.asarray(parameters.gap), count + 1)[real]
    static_overlap[real] = law.static_overlap(static_force[real], stiffness[real], constants)
    rest_overlap[real] = static_overlap[real] - gap
    spacing = radius[:-1] + radius[1:] - rest_overlap[1:-1]
    position = np.concatenate(([0.0], np.cumsum(spacing)))
    _refuse_extreme_sizes(mass, stiffness[real], position, law.exponent)
    arrays = Geometry(
        radius, mass, stiffness, largest_stiffness, rest_overlap, reduced_radius, reduced_mass,
        np.minimum(left_radius, right_radius), position,
        _grain_values(materials, "longitudinal_speed"), yield_strength, static_force, static_overlap, law_constants, real,
    )  # fmt: skip
    # A later change would have no effect, because the chain copies the arrays.
    for values in vars(arrays).values():
        if isinstance(values, np.ndarray):
            values.setflags(write=False)
    return arrays


def _refuse_extreme_sizes(mass: FloatArray, stiffness: FloatArray, position: FloatArray, exponent: float) -> None:
    """Refuse sizes for which masses, stiffnesses, lengths or derived quantities leave the range of a float."""
    # For a high exponent, overlaps of micrometres and less require a large stiffness.
    stiffest = _LARGEST * _MICROMETRES ** max(0.0, exponent - 1.5)
    for name, values, least, most, unit in (
        ("mass", mass, _SMALLEST, _LARGEST, "kg"),
        ("contact_stiffness", stiffness, _SMALLEST, stiffest, f"N/m^{exponent:g}"),
        ("gap", position, -_LARGEST, _LARGEST, "m between the first grain and another"),
    ):
        wrong = ~((values > least) & (values < most))
        if wrong.any():
            where = int(np.argmax(wrong))
            raise ParameterError(
                f"radius, material, gap and overrides result in {values[where]:g} {unit}",
                expected=f"{least:g} to {most:g}",
                hint="check their units, which must be SI",
                at=f"{name}[{where}]",
            )


def smoothness_factor(exponent: float) -> float:
    """Return the factor by which the suggested step is shortened for F = k d^p: for p < 1.5 contacts close abruptly."""
    return min(1.0, 0.25 + 1.5 * (exponent - 1.0))


def step_times_frequency(exponent: float, scheme: Scheme, evaluations: float) -> float:
    """Return step x sqrt(p k d^(p-1) / m*), d the largest overlap, for which F is evaluated `evaluations` times per contact."""
    return duration_times_frequency(exponent) * scheme.evaluations / evaluations


def minimum_evaluations(exponent: float, scheme: Scheme) -> float:
    """Return the number of force evaluations during one contact below which the chain warns."""
    return scheme.minimum_evaluations / smoothness_factor(exponent)


def suggested_step_size(parameters: ChainParameters, chain: Geometry, scheme: Scheme) -> float:
    """Return the default step [s], 1, 2 or 5 x 10^k: for spheres at most 0.1 (m/k)^(2/5) v^(-1/5) of the quickest contact."""
    law = parameters.law
    lighter = np.minimum(*_side_values(_inertia(parameters, chain.mass), np.inf, np.inf))
    ratio = float(np.min(lighter[chain.contact_slice] / chain.largest_stiffness[chain.contact_slice], initial=np.inf))
    if not math.isfinite(ratio):  # no contact can accelerate a grain
        return _STEP_WITHOUT_CONTACTS
    gapped = bool(np.any(chain.rest_overlap < 0.0))
    scale = _collision_time(ratio, parameters.velocity_scale, law.exponent)
    factor = scheme.step_factor * smoothness_factor(law.exponent)
    step = (_STEP_FACTOR_WITH_GAPS if gapped else _STEP_FACTOR) * factor * scale
    if np.any(chain.rest_overlap > 0.0):
        step = min(step, _precompressed_step_size(chain, parameters, scheme))
    if isinstance(law, Dissipative):
        rate = _dissipation_rate(law, chain, parameters.velocity_scale)
        step = min(step, _STEP_TIMES_DISSIPATION / rate) if rate > 0.0 else step
        if law.has_force_jump and rate > 0.0:
            step = min(step, max(_STEP_TIMES_JUMP / rate, _SHORTEST_FOR_JUMP * step))
    return round_down_to_125(step)


def _precompressed_step_size(chain: Geometry, parameters: ChainParameters, scheme: Scheme) -> float:
    """Return the step that resolves contacts and the highest lattice frequency under static load [s]; infinite without load."""
    tangent, exponent = _tangent_stiffness(chain, parameters), parameters.law.exponent
    contact = float(np.max(tangent[chain.contact_slice] / chain.reduced_mass[chain.contact_slice], initial=0.0))
    lattice = float(np.max(2.0 * (tangent[:-1] + tangent[1:]) / chain.mass))
    angles = (
        (step_times_frequency(exponent, scheme, minimum_evaluations(exponent, scheme)), contact),
        (scheme.pressed_angle * smoothness_factor(exponent), lattice),
    )
    # A negligible force gives no frequency and thus no limit.
    return min((angle / math.sqrt(square) for angle, square in angles if square > 0.0), default=math.inf)


def _dissipation_rate(law: Dissipative, chain: Geometry, speed: float) -> float:
    """Return the largest c / m* of the contacts, c the dissipative force per speed at their deepest overlap [1/s]."""
    real = chain.contact_slice
    overlap, reduced = _deepest_overlap(chain, speed, law.exponent)[real], chain.reduced_mass[real]
    return float(np.max(law.damping_coefficients(chain.law_constants[real], overlap) / reduced, initial=0.0))


def _deepest_overlap(chain: Geometry, speed: float, exponent: float) -> FloatArray:
    """Return the overlap at rest plus that of a collision, an upper bound of the largest overlap, shape (n + 1,) [m].

    It is 0 at places without a contact or between immovable bodies.
    """
    overlap = np.zeros(len(chain.stiffness))
    moved = (chain.stiffness > 0.0) & np.isfinite(chain.reduced_mass)
    ratios = (0.5 * (exponent + 1.0) * speed * speed) * chain.reduced_mass[moved] / chain.stiffness[moved]
    overlap[moved] = [power(ratio, 1.0 / (exponent + 1.0)) for ratio in ratios]
    overlap[moved] += np.maximum(chain.rest_overlap[moved], 0.0)
    return overlap


def _collision_time(mass_by_stiffness: float, speed: float, exponent: float) -> float:
    """Return the time scale of a collision with F = k d^p, (m/k)^(1/(p + 1)) v^(-(p - 1)/(p + 1)) [s]."""
    if exponent == 1.5:
        root = nth_root(mass_by_stiffness, 5)
        return root * root / nth_root(speed, 5)
    return power(mass_by_stiffness, 1.0 / (exponent + 1.0)) / power(speed, (exponent - 1.0) / (exponent + 1.0))


def _tangent_stiffness(chain: Geometry, parameters: ChainParameters) -> FloatArray:
    """Return the tangent stiffness of the contacts at their deepest overlap, shape (n + 1,) [N/m]."""
    exponent = parameters.law.exponent
    overlap = _deepest_overlap(chain, parameters.velocity_scale, exponent)
    slope = (
        np.sqrt(overlap)
        if exponent == 1.5
        else np.array([power(depth, exponent - 1.0) if depth > 0.0 else 0.0 for depth in overlap])
    )
    return exponent * chain.largest_stiffness * slope


def static_forces(parameters: ChainParameters, mass: FloatArray) -> FloatArray:
    """Return the static force at each contact place, ends included, shape (n + 1,) [N]; 0 if gaps leave grains unsupported.

    A free end carries `precompression`; a wall or piston carries the reaction. Between two walls or pistons the less loaded
    one carries `precompression`.

    Raises:
        ParameterError: a free end would have to carry gravity, or gravity would pull a contact apart.
    """
    p = parameters
    gaps = p.gap if isinstance(p.gap, list) else [p.gap]
    if p.gravity == 0.0 or any(gap > 0.0 for gap in gaps):
        return np.full(p.grains + 1, p.precompression)
    weight = p.gravity * mass
    # The weight of a prescribed grain is carried by its piston.
    weight[[0] if p.left == "piston" else []] = 0.0
    weight[[-1] if p.right == "piston" else []] = 0.0
    above = np.concatenate(([0.0], np.cumsum(weight)))
    return above + _left_end_force(p, above)


def _left_end_force(p: ChainParameters, cumulative_weight: FloatArray) -> float:
    """Return the static compressive force at the left end [N], which follows from `precompression` and the weights."""
    total = float(cumulative_weight[-1])
    if p.left == "free" and p.right == "free":
        raise ParameterError(
            f"{p.gravity:g} m/s^2 acts on a chain with two free ends, which has no equilibrium",
            hint="make one end a wall or a piston, or set gap > 0 to let the grains fall",
            at="gravity",
        )
    if p.left == "free":
        force, end = p.precompression, "right"
    elif p.right == "free":
        force, end = p.precompression - total, "left"
    else:
        return p.precompression + max(0.0, -total)
    lowest = force + float(cumulative_weight.min())
    if lowest < 0.0:
        raise ParameterError(
            f"{p.gravity:g} m/s^2 would pull the grains away from the {end} end with {-lowest:.6g} N, but contacts "
            "carry no tension",
            hint=f"reverse gravity, or give precompression of at least {p.precompression - lowest:.6g} N",
            at="gravity",
        )
    return force


def _radius(parameters: ChainParameters) -> FloatArray:
    given = parameters.radius
    if isinstance(given, UniformRadii):
        return given.draw_radii(parameters.grains)
    return np.full(parameters.grains, given) if isinstance(given, float) else np.array(given)


def _materials(parameters: ChainParameters) -> list[Material]:
    given = parameters.material
    if isinstance(given, list):
        return [to_material(one) for one in given]
    return [to_material(given)] * parameters.grains


def _mass(parameters: ChainParameters, radius: FloatArray, materials: list[Material]) -> FloatArray:
    density = _grain_values(materials, "density")
    mass = parameters.arrangement.masses(4.0 / 3.0 * math.pi * density * (radius * radius * radius))
    given = parameters.mass
    if isinstance(given, dict):
        for index, value in given.items():
            mass[index] = value
    elif given is not None:
        mass[:] = given
    return mass


def _inertia(parameters: ChainParameters, mass: FloatArray) -> FloatArray:
    """Return the mass that a contact accelerates; prescribed grains of pistons count as infinitely heavy."""
    inertia = mass.copy()
    inertia[[0] if parameters.left == "piston" else []] = np.inf
    inertia[[-1] if parameters.right == "piston" else []] = np.inf
    return inertia


def _grain_values(materials: list[Material], name: str) -> FloatArray:
    first = materials[0]
    if all(one is first for one in materials):
        return np.full(len(materials), getattr(first, name), dtype=np.float64)
    return np.array([getattr(one, name) for one in materials], dtype=np.float64)


def _yield_strength(parameters: ChainParameters, materials: list[Material]) -> FloatArray:
    """Return the yield strength of the weaker side; free ends, pistons and rigid planes count as the adjacent grain."""
    grains = _grain_values(materials, "yield_strength")
    walls = [
        grains[end] if given is None else to_material(given).yield_strength or np.nan
        for end, given in ((0, parameters.left_wall_material), (-1, parameters.right_wall_material))
    ]
    return np.fmin(*_side_values(grains, float(walls[0]), float(walls[1])))


def _wall_radius(boundary: str, end_radius: float) -> float:
    """Return the radius of a wall: a fixed grain has the radius of the end grain; a plane has no curvature."""
    return end_radius if boundary == "fixed_grain" else np.inf


def _side_values(values: FloatArray, left: float, right: float) -> tuple[FloatArray, FloatArray]:
    """Return the values on the left and the right side of each contact place."""
    return np.concatenate(([left], values)), np.concatenate((values, [right]))


def _half_harmonic_mean(left: FloatArray, right: FloatArray) -> FloatArray:
    """Return 1 / (1/left + 1/right); infinite if both are infinite."""
    with np.errstate(divide="ignore"):
        return 1.0 / (1.0 / left + 1.0 / right)


def _stiffness(parameters: ChainParameters, materials: list[Material], reduced_radius: FloatArray) -> FloatArray:
    """Return the given k, or Hertz's k = (4/3) E* sqrt(R*), 1/E* the sum of both sides' (1 - nu^2)/E, shape (n + 1,)."""
    if parameters.contact_stiffness is not None:
        return np.full(len(reduced_radius), parameters.contact_stiffness)
    left, right = _side_values(
        _grain_values(materials, "plane_compliance"),
        _wall_compliance(parameters.left, parameters.left_wall_material, materials[0]),
        _wall_compliance(parameters.right, parameters.right_wall_material, materials[-1]),
    )
    return 4.0 / 3.0 / (left + right) * np.sqrt(reduced_radius)


def _wall_compliance(boundary: str, wall_material: str | Material | None, grain: Material) -> float:
    if boundary == "rigid_plane":
        return 0.0
    return (to_material(wall_material) if wall_material is not None else grain).plane_compliance
