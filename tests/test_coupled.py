"""A grid coupled to automata against what is exact for it: patches, conserved quantities, both variants, refusals."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from support.coupled_tools import (
    MEDIUM,
    ROW,
    SMALL,
    between,
    corner,
    coupled,
    cradle,
    inclusion,
    inner,
    layers,
    mesh,
    positions,
    rectangle,
    start,
    start_noise,
)

from granular_env.components.automata.motion import WORK
from granular_env.components.coupled import Coupled, step_sizes, theory
from granular_env.components.coupled.strays import find_strays
from granular_env.components.errors import ParameterError, StepError
from granular_env.components.materials.elastic import Material
from granular_env.components.profiles import Profile
from granular_env.components.support.float_arrays import FloatArray

# A stretch, a shear and a spin at once.
GRADIENT = np.array([[0.7, -1.1], [0.4, 0.3]])
SHAPES: list[Callable[..., Coupled]] = [layers, inclusion, corner, cradle, between]
every_shape = pytest.mark.parametrize("make", SHAPES, ids=lambda make: make.__name__)


# -- patches -------------------------------------------------------------------------------------------------------------


def assert_no_force(medium: Coupled, margin: float) -> None:
    start(medium, lambda points: SMALL * points @ GRADIENT.T, 0.5 * SMALL * (GRADIENT[1, 0] - GRADIENT[0, 1]))
    nodes, automata = inner(medium, margin)
    forces, torques = medium.forces_on_automata()
    free = automata & (medium.interface.free > 0)
    assert nodes[medium.interface.nodes].any() and free.any()
    # Stresses are about 2 SMALL, and forces between neighbours as large.
    assert np.abs(medium.forces_on_nodes()[nodes]).max() <= 1e-12 * SMALL
    assert np.abs(forces[free]).max() <= 1e-12 * SMALL
    assert np.abs(torques[automata]).max() <= 1e-12 * SMALL


@pytest.mark.parametrize("n", [1, 2, 3, 4])
@every_shape
def test_a_homogeneous_strain_leaves_nodes_and_automata_without_force(make: Callable[..., Coupled], n: int) -> None:
    # Within two cells of a free surface the volumetric strain of automata feels it.
    assert_no_force(make(n=n), 0.9 if make is not layers else 1.1)


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_so_it_does_where_a_hexagonal_packing_meets_the_grid(n: int) -> None:
    assert_no_force(layers("hexagonal", n), 2.1)


def test_two_materials_carry_one_traction_through_the_interface() -> None:
    """A stack of a stiff and a soft layer under a stress s_yy: each has the strain that belongs to it."""
    soft = {"density": 1.0, "young": 1.0, "poisson": 0.1}
    for packing in ("square", "hexagonal"):
        height = 4.0 if packing == "square" else 4 * ROW
        medium = Coupled(
            grid={"mesh": mesh(8, 4), "material": MEDIUM},
            automata={"shape": rectangle(8.0, height), "diameter": 1.0, "packing": packing, "material": soft},
            origin=[0.0, 4.0],
        )
        shear = 1.0 / 2.2
        stiffness = 2.0 * shear * 0.1 / 0.8 + 2.0 * shear

        def field(points: Any, stiffness: float = stiffness) -> Any:
            y = np.where(points[:, 1] <= 4.0, points[:, 1] / 3.0, 4.0 / 3.0 + (points[:, 1] - 4.0) / stiffness)
            return SMALL * np.stack([np.zeros(len(y)), y], axis=1)

        start(medium, field)
        nodes, automata = inner(medium, 2.1)
        assert nodes[medium.interface.nodes].any()
        assert np.abs(medium.forces_on_nodes()[nodes]).max() <= 1e-12 * SMALL
        stress = medium.get("automata_stress")[automata]
        np.testing.assert_allclose(stress[:, 1], SMALL, rtol=1e-11)


# -- what is conserved ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scheme", ["force", "momentum"])
@pytest.mark.parametrize("n", [1, 2])
@every_shape
def test_lockstep_keeps_energy_momentum_and_its_moment(make: Callable[..., Coupled], n: int, scheme: str) -> None:
    medium = make(n=n, scheme=scheme, micro_steps=1)
    energy = start_noise(medium, 1)
    mass, before = medium.get("mass"), medium.get("grid_displacement")
    medium.step(400 * medium.step_size)
    assert np.abs(medium.get("grid_displacement") - before).max() > SMALL
    assert abs(medium.get("energy_residual")) <= 1e-12 * energy
    # Velocities are of the order of SMALL, and arms of 10.
    assert np.abs(medium.get("momentum_residual")).max() <= 1e-15 * mass * SMALL
    assert abs(medium.get("angular_momentum_residual")) <= 1e-14 * mass * SMALL
    assert abs(medium.get("interface_work_on_grid")) > 1e-3 * energy
    assert abs(medium.get("interface_work_difference")) <= 1e-14 * energy
    assert abs(medium.get("mass_difference")) <= 1e-15 * mass


@pytest.mark.parametrize("n", [1, 2])
def test_the_variants_of_the_paper_are_the_same_to_rounding(n: int) -> None:
    found = []
    for scheme in ("force", "momentum"):
        medium = inclusion(n=n, scheme=scheme, micro_steps=1)
        start_noise(medium, 2)
        medium.step(400 * medium.step_size)
        found.append([medium.get("grid_velocity"), medium.get("automata_velocity")])
    for of_forces, of_momenta in zip(*found, strict=True):
        assert (of_forces != of_momenta).any()
        # 400 ticks of some roundings each.
        assert np.abs(of_forces - of_momenta).max() <= 1e-12 * SMALL


def test_work_and_impulse_of_every_input_are_accounted_for() -> None:
    """Forces, tractions, driven and absorbing edges of the grid, and forces, tractions, smooth plates of the automata."""
    medium = coupled(
        {
            "mesh": mesh(8, 4),
            "boundaries": {"left": {"name": "absorbing"}, "bottom": {"name": "velocity"}, "right": "traction"},
            "forced_nodes": [12, [4.0, 4.0]],
        },
        {
            "shape": rectangle(8.0, 4.0),
            "boundaries": {"top": {"name": "velocity", "components": "y"}, "right": "traction"},
            "forced_automata": [5, 20],
        },
        origin=[0.0, 4.0],
    )
    free = medium.interface.free
    assert free[5] == 0 and free[20] == 1
    # Bodies move by some hundred times this, and turn.
    small = 1e-3 * SMALL
    signal = Profile.half_sine(1.0, 40 * medium.step_size)
    inputs = {
        "grid_bottom_velocity": small * np.array([1.0, 2.0]),
        "grid_right_traction": small * np.array([-1.0, 0.5]),
        "grid_force": small * np.array([[1.0, 0.0], [0.5, -1.0]]),
        "automata_top_velocity": np.array([0.0, -small]),
        "automata_right_traction": small * np.array([0.5, 1.0]),
        "automata_force": small * np.array([[0.3, -0.2], [1.0, 1.0]]),
    }
    medium.step(50 * medium.step_size, **{name: signal * value for name, value in inputs.items()})
    medium.step(50 * medium.step_size, **inputs)
    medium.step(100 * medium.step_size, **dict.fromkeys(inputs, 0.0))
    moved = float(medium._block["tallies"][1][WORK])  # by the edge of the automata whose velocity is an input
    rest = medium.get("input_work") - moved
    work = abs(rest) + abs(moved)
    assert min(map(abs, (moved, rest, medium.get("absorbed_energy")))) > 0.01 * work
    assert abs(medium.get("energy_residual")) <= 1e-12 * work
    impulse = np.abs(medium.get("boundary_impulse")).max()
    assert np.abs(medium.get("momentum_residual")).max() <= 1e-12 * impulse
    assert abs(medium.get("angular_momentum_residual")) <= 1e-12 * abs(medium.get("boundary_angular_impulse"))
    assert abs(medium.get("interface_work_difference")) <= 1e-12 * work


def test_tractions_on_the_corners_of_automata_are_accounted_for() -> None:
    """Tractions act off the centres of quarter cells, and turn them."""
    medium = coupled(
        {"mesh": mesh(6, 4, cell_size=[1.0, 2.0 * ROW]), "boundaries": {"left": "fixed"}},
        {
            "shape": rectangle(6.0, 8.0 * ROW),
            "packing": "hexagonal",
            "boundaries": {"top": "traction", "right": "traction"},
        },
        origin=[6.0, 0.0],
    )
    assert np.abs(medium._edge_inputs.edges.load.lever).max() == 0.25
    small = 1e-3 * SMALL
    inputs = {"automata_top_traction": [small, 3.0 * small], "automata_right_traction": [2.0 * small, -small]}
    medium.step(200 * medium.step_size, **inputs)
    assert abs(medium.get("energy_residual")) <= 1e-12 * medium.get("input_work")
    turning = abs(medium.get("angular_impulse")) + abs(medium.get("boundary_angular_impulse"))
    assert abs(medium.get("angular_momentum_residual")) <= 1e-12 * turning


def test_nodes_of_an_interface_inside_weigh_as_much_as_others() -> None:
    medium = inclusion()
    nodes, automata = medium.grid.mass, medium.automata.mass
    assert medium.get("mass") == pytest.approx(64.0, rel=1e-14)
    mass = nodes + medium.carried_mass
    np.testing.assert_allclose(mass[medium.interface.nodes], 1.0, rtol=1e-14)
    assert automata[medium.interface.automata].sum() == pytest.approx(medium.carried_mass.sum(), rel=1e-14)


# -- micro-steps ---------------------------------------------------------------------------------------------------------


def stored_energy(medium: Coupled) -> float:
    stored = medium.balances()[0].stored
    return sum(amount for name, amount in stored.items() if name != "leapfrog_energy")


@pytest.mark.parametrize("scheme", ["force", "momentum"])
@pytest.mark.parametrize("n", [2, 4])
@pytest.mark.parametrize("packing", ["square", "hexagonal"])
def test_impulses_keep_the_energy_within_bounds(packing: str, n: int, scheme: str) -> None:
    """1500 ticks of a motion with 5 % noise: the energy stays in 0.95..1.08 of its start, momentum to rounding."""
    medium = layers(packing, n, scheme=scheme, micro_steps=2)
    start_noise(medium, 3, 0.05)
    begin = stored_energy(medium)
    for _ in range(50):
        medium.step(30 * medium.step_size)
        assert 0.95 <= stored_energy(medium) / begin <= 1.08
    assert np.abs(medium.get("momentum_residual")).max() <= 1e-15 * medium.get("mass") * SMALL
    assert abs(medium.get("angular_momentum_residual")) <= 1e-14 * medium.get("mass") * SMALL
    assert abs(medium.get("interface_work_difference")) <= 1e-13 * begin


@pytest.mark.parametrize(("n", "stiffer"), [(4, 20.0), (4, 4.0), (8, 1.0)])
def test_impulses_keep_the_energy_beside_an_inclusion(n: int, stiffer: float) -> None:
    """Small and stiff automata in a hole of the grid, 1500 ticks of 5 % noise."""
    stiff = {"material": {"density": 1.0, "young": stiffer * MEDIUM.young, "poisson": 0.25}}
    medium = inclusion(n, stiff, micro_steps=2)
    start_noise(medium, 3, 0.05)
    begin = stored_energy(medium)
    for _ in range(10):
        medium.step(150 * medium.step_size)
        assert 0.95 <= stored_energy(medium) / begin <= 1.08
    assert medium.cautions() == []


def one_step(medium: Coupled) -> FloatArray:
    """Return the matrix of one step of a body at rest, of all displacements, rotations and velocities that are free."""
    free = {f"grid_{name}": medium.grid.mesh.nodes[:, 1] > 0.0 for name in ("displacement", "velocity")}
    hanging = np.isclose(medium.reference[:, 1], medium.grid.mesh.nodes[:, 1].max())
    free |= {f"automata_{name}": ~hanging for name in ("displacement", "velocity")}
    free |= {f"automata_{name}": np.ones(len(hanging), bool) for name in ("rotation", "angular_velocity")}
    shapes = {name: medium.get(name).shape for name in free}
    rows, columns = [], []
    for name, moving in free.items():
        chosen = np.broadcast_to(moving.reshape(-1, *[1] * (len(shapes[name]) - 1)), shapes[name])
        rows.append(chosen)
        for index in np.argwhere(chosen):
            start = {other: np.zeros(shape) for other, shape in shapes.items()}
            start[name][tuple(index)] = SMALL
            medium.reset(**start)
            medium.step(medium.step_size)
            columns.append({other: medium.get(other) / SMALL for other in free})
    return np.array([np.concatenate([column[name][row] for name, row in zip(free, rows, strict=True)]) for column in columns]).T


def growth_of_a_step(n: int, stiffer: float, wide: int = 1, **parameters: Any) -> float:
    """Return by how much the largest motion grows in a step: a row of cells, held below, and two of automata."""
    grid = {"mesh": mesh(wide, 1), "boundaries": {"bottom": "fixed"}}
    stiff = {"density": 1.0, "young": stiffer * MEDIUM.young, "poisson": 0.25}
    automata = {"shape": rectangle(float(wide), 2.0 / n), "material": stiff}
    medium = coupled(grid, automata, n, origin=[0.0, 1.0], **parameters)
    multipliers = np.linalg.eigvals(one_step(medium))
    # A checkerboard of rotations costs no energy: it turns on, with a multiplier that is 1 twice, to the root of rounding.
    return float(np.abs(multipliers[np.abs(multipliers - 1.0) > 1e-5]).max()) - 1.0


@pytest.mark.parametrize("stiffer", [1.0, 4.0])
@pytest.mark.parametrize("n", [2, 3, 4])
def test_no_motion_grows_with_the_default_step(n: int, stiffer: float) -> None:
    """All multipliers of a step lie on the unit circle."""
    assert abs(growth_of_a_step(n, stiffer, micro_steps=2)) <= 1e-9


@pytest.mark.parametrize("micro", [2, 3, 6])
def test_no_motion_grows_with_the_longest_step_that_is_allowed(micro: int) -> None:
    grid = {"mesh": mesh(1, 1), "boundaries": {"bottom": "fixed"}}
    medium = coupled(grid, {"shape": rectangle(1.0, 0.5)}, 4, origin=[0.0, 1.0])
    stable = medium.step_size / (medium.micro_steps * medium.get("automata_step_part"))
    longest = 0.999999 * step_sizes._steps_between_kicks(micro)[0] * stable
    with pytest.raises(ParameterError, match="of those of the automata"):
        growth_of_a_step(4, 1.0, step_size=1.00001 * longest, micro_steps=micro)
    assert abs(growth_of_a_step(4, 1.0, step_size=longest, micro_steps=micro)) <= 1e-9


def test_motion_grows_beyond_the_longest_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """Some windows of the step beyond n sin(pi / 2n) largest stable ones feed two modes whose phases add up to a turn."""
    monkeypatch.setattr(step_sizes, "_steps_between_kicks", lambda micro: (9.0, 9.0))
    monkeypatch.setattr(step_sizes, "_ALLOWED_IMPULSES", 0.9)
    assert growth_of_a_step(2, 1.0, wide=2, step_size=0.31, micro_steps=3) >= 1e-4


def test_a_step_that_feeds_modes_of_the_automata_is_refused() -> None:
    """Beyond it energy grows without bound, however many micro-steps there are."""
    for micro, most in ((4, 1.38), (10, 1.41)):
        with pytest.raises(ParameterError, match=f"got 0.15 s with micro_steps = {micro}.* {most} of those of the automata"):
            inclusion(4, step_size=0.15, micro_steps=micro)


def test_energy_that_micro_steps_make_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(step_sizes, "_ALLOWED_IMPULSES", 0.9)
    monkeypatch.setattr(step_sizes, "_steps_between_kicks", lambda micro: (9.0, 9.0))
    medium = inclusion(4, step_size=0.27, micro_steps=5)
    start_noise(medium, 3, 1.0)
    medium.step(3000 * medium.step_size)
    assert medium.get("energy_residual") > 0.1 * medium.balances()[0].initial
    assert any("micro-steps have made" in text and "0.27 s" in text for text in medium.cautions())


@pytest.mark.parametrize(("n", "step"), [(2, 0.25), (3, 0.25), (4, 0.2)])
def test_sub_steps_as_the_paper_has_them_are_unstable(n: int, step: float) -> None:
    """Held velocities and mean forces feed on 5 % noise for a time of 250, where impulses with the same micro-steps do not."""
    grown = {}
    for scheme, part in (("literal", 1), ("force", 2)):
        medium = layers("hexagonal", n, scheme=scheme, step_size=step / part, micro_steps=2 * n // part)
        start_noise(medium, 3, 0.05)
        begin = stored_energy(medium)
        medium.step(250.0)
        grown[scheme] = stored_energy(medium) / begin
        lost = np.abs(medium.get("momentum_residual")).max() / (medium.get("mass") * SMALL)
        assert lost > 1e-5 if scheme == "literal" else lost <= 1e-15
    assert grown["literal"] > 100.0 and grown["force"] < 1.08


def ringing(n: int, ticks: int = 200, left: str = "fixed", **parameters: Any) -> float:
    """Return by how much stresses change, in parts of that of a strip which is stretched and at rest; its right end is held."""
    across = {"bottom": "periodic", "top": "periodic"}
    grid = {"mesh": mesh(8, 2), "boundaries": {**across, "left": left}}
    automata = {"shape": rectangle(8.0, 2.0), "boundaries": {**across, "right": "fixed"}}
    medium = coupled(grid, automata, n, origin=[8.0, 0.0], **parameters)
    start(medium, lambda points: SMALL * points * [1.0, 0.0])
    stress, names = 3.0 * SMALL, ("grid_stress", "automata_stress")
    for name in names:
        np.testing.assert_allclose(medium.get(name)[:, 0], stress, rtol=1e-11)
    largest = 0.0
    for _ in range(ticks):
        medium.step()
        largest = max(largest, *(float(np.abs(medium.get(name)[:, 0] - stress).max()) for name in names))
    return largest / stress


@pytest.mark.parametrize("left", ["fixed", "absorbing"])
@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_what_is_stretched_and_at_rest_stays_at_rest(n: int, left: str) -> None:
    """In lockstep, the default, to rounding; an absorbing edge keeps the traction of the start."""
    assert ringing(n, left=left) <= 1e-12


@pytest.mark.parametrize("n", [2, 4])
def test_micro_steps_make_a_static_stress_ring_at_second_order(n: int) -> None:
    """Impulses of cells and automata that balance in the mean come at different times."""
    coarse, fine = (ringing(n, ticks, micro_steps=2, step_size=size) for ticks, size in ((200, 0.1), (400, 0.05)))
    assert 3.5 <= coarse / fine <= 4.5
    assert fine > 1e-3


def test_micro_steps_come_to_what_lockstep_gives() -> None:
    """The difference to lockstep falls with the square of the step."""
    errors = []
    for step in (0.08, 0.04):
        found = []
        for scheme, micro, size in (("force", 2, step), ("force", 1, 0.005)):
            medium = layers(n=2, scheme=scheme, micro_steps=micro, step_size=size)
            start_noise(medium, 3, 0.0)
            medium.step(1.6)
            found.append(medium.get("grid_displacement"))
        errors.append(np.abs(found[0] - found[1]).max())
    assert 3.0 <= errors[0] / errors[1] <= 5.0


# -- where both meet -----------------------------------------------------------------------------------------------------


def test_the_interface_is_found() -> None:
    medium = inclusion(n=2)
    assert len(medium.interface.nodes) == 14 and len(medium.interface.automata) == 28
    two = between(n=3)
    assert len(two.interface.nodes) == 10 and len(two.interface.automata) == 26
    nodes, centres = positions(two)
    interface = two.interface
    hung = (interface.weights[:, :, None] * nodes[interface.ends]).sum(axis=1)
    np.testing.assert_allclose(hung, centres[interface.automata], atol=1e-12)


def test_automata_of_the_interface_move_with_the_nodes() -> None:
    medium = layers(n=3)
    start_noise(medium, 5)
    medium.step(20 * medium.step_size)
    interface = medium.interface
    for name in ("displacement", "velocity"):
        hung = (interface.weights[:, :, None] * medium.get(f"grid_{name}")[interface.ends]).sum(axis=1)
        np.testing.assert_array_equal(hung, medium.get(f"automata_{name}")[interface.automata])


def test_periodic_sides_are_one() -> None:
    """A strip that is closed on itself moves as a longer piece of the same pattern does."""
    medium = coupled(
        {"mesh": mesh(6, 4), "boundaries": {"bottom": "periodic", "top": "periodic"}},
        {"shape": rectangle(5.0, 4.0), "boundaries": {"bottom": "periodic", "top": "periodic"}},
        origin=[6.0, 0.0],
    )
    energy = start_periodic_noise(medium)
    medium.step(300 * medium.step_size)
    assert abs(medium.get("energy_residual")) <= 1e-12 * energy
    assert np.abs(medium.get("momentum_residual")).max() <= 1e-15 * medium.get("mass") * SMALL
    low, high = medium.grid.mesh.edge_nodes("bottom"), medium.grid.mesh.edge_nodes("top")
    np.testing.assert_array_equal(medium.get("grid_velocity")[low], medium.get("grid_velocity")[high])
    assert medium.get("mass") == pytest.approx(44.0, rel=1e-14)


def start_periodic_noise(medium: Coupled) -> float:
    random = np.random.default_rng(4)
    velocity = SMALL * random.standard_normal(medium.get("grid_velocity").shape)
    velocity[medium.grid.mesh.edge_nodes("top")] = velocity[medium.grid.mesh.edge_nodes("bottom")]
    medium.reset(grid_velocity=velocity, automata_velocity=SMALL * random.standard_normal((medium.automata.count, 2)))
    return medium.get("grid_kinetic_energy") + medium.get("automata_kinetic_energy")


# -- refusals ------------------------------------------------------------------------------------------------------------


# Automata beside four by four cells, which they touch along a side and once more in a corner.
HOOK = {"name": "polygon", "corners": [[4, 0], [6, 0], [6, 6], [4, 6], [4, 4], [5, 4], [5, 2], [4, 2]]}
SQUARE = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
CLOCKWISE = {"name": "quadrilaterals", "nodes": SQUARE, "cells": [[0, 3, 2, 1]]}
FLAT = {"name": "quadrilaterals", "nodes": [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]], "cells": [[0, 1, 2, 3]]}
SIDEWAYS = {"automata.packing": "hexagonal", "automata.shape": rectangle(8.0, 4 * ROW), "origin": [8.0, 0.0]}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"origin": [0.0, 9.0]},
            r"nearest are node 36 at \(0, 4\) m and automaton 0 at \(0, 9\) m: off by \(0, -5\) m",
        ),
        (
            {"origin": [0.0, 3.0]},
            r"reach up to 0\.5 m into cells of the grid: .* into cell 24, about \(0\.5, 3\.5\) m, .*move `origin` to \[0, 4\]",
        ),
        ({"origin": [0.5, 4.0]}, "an automaton is expected at"),
        ({"automata.diameter": 0.8}, "1.25 diameters of 0.8 m long, expected a whole number"),
        (SIDEWAYS, r"is 0.577350269 times sqrt\(3\) diameters \(1.73205081 m"),
        ({"automata.boundaries": {"left": "fixed"}}, "is held along x by its edge"),
        ({"step_size": 0.32}, "step_size: got 0.32 s with micro_steps = 1, expected at most 0.308"),
        ({"step_size": 0.4, "micro_steps": 2}, "step_size: got 0.4 s with micro_steps = 2, expected at most 0.252"),
        ({"scheme": "literal"}, "micro_steps: got 1 with scheme = literal.*give how many sub-steps"),
        ({"scheme": "literal", "micro_steps": 1}, "micro_steps: got 1 with scheme = literal"),
        ({"grid.boundaries": {"left": "periodic", "right": "periodic"}}, "automata 0 and 8 both move with node 36 of the grid"),
        ({"scheme": "penalty"}, "scheme"),
        ({"automata.thickness": 0.5}, "automata.thickness: got 0.5 m"),
        ({"automata.step_size": 0.1}, "automata.step_size: the parts have one step_size"),
        ({"grid.mesh": mesh(4, 4), "automata.shape": HOOK, "origin": [0.0, 0.0]}, "the two parts touch in a point"),
        ({"automata.shape": rectangle(8.3, 4.0)}, "component 'coupled': automata.shape.width: 8.3 m"),
        ({"grid.mesh": CLOCKWISE}, r"component 'coupled': grid.*cells\[0\].*inverted"),
        ({"grid.mesh": FLAT}, r"component 'coupled': grid.*cells\[0\].*flat"),
        ({"grid.material": {"density": 1.0, "young": 1.0, "poisson": 0.5}}, r"grid.material.poisson.*0\.5"),
        ({"automata.material": {"density": 1.0, "young": 1.0, "poisson": 0.5}}, "poisson"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(changes: dict[str, Any], words: str) -> None:
    grid: dict[str, Any] = {"mesh": mesh(8, 4), "material": MEDIUM}
    automata = {"shape": rectangle(8.0, 4.0), "diameter": 1.0, "packing": "square", "material": MEDIUM}
    parameters = {"grid": grid, "automata": automata, "origin": [0.0, 4.0]}
    for path, value in changes.items():
        part, _, name = path.rpartition(".")
        (parameters[part] if part else parameters)[name] = value
    with pytest.raises(ParameterError, match=words):
        Coupled(**parameters)


def test_theory_of_reflection() -> None:
    stiff, soft = Material(density=2.0, young=5.0, poisson=0.25), Material(density=1.0, young=2.5, poisson=0.25)
    for shear in (False, True):
        back, on = theory.reflection(stiff, soft, shear=shear), theory.transmission(stiff, soft, shear=shear)
        # Same speeds, half the density: Z1 = 2 Z2; the power that comes is that which goes.
        assert back == pytest.approx(1.0 / 3.0) and back**2 + 0.5 * on**2 == pytest.approx(1.0)
        for packing, axis in (("square", "x"), ("hexagonal", "x"), ("hexagonal", "y")):
            long, short = (
                abs(theory.lattice_reflection(soft, length, 1.0, 1.0, packing, axis=axis, shear=shear))
                for length in (40.0, 20.0)
            )
            assert 3.9 <= short / long <= 4.1 and 1e-3 < short < 2.5e-3


def test_strays_are_found() -> None:
    nodes = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.2], [0.0, 1.0], [1.0, 1.1], [2.0, 1.0]])
    cells = np.array([[0, 1, 4, 3], [1, 2, 5, 4]])
    points = np.array([[0.5, 0.5], [1.5, 0.05], [1.5, 0.2], [0.5, 1.2], [np.nan, 0.0], [1.0 - 1e-9, 0.5], [1e300, 0.0]])
    assert find_strays(nodes, cells, points).tolist() == [0, 2, 5]


def test_an_inverted_cell_and_a_fast_automaton_are_named() -> None:
    medium = layers()
    before = medium.save().to_bytes()
    medium.reset(grid_velocity={0: (50.0, 0.0)})
    start = medium.save().to_bytes()
    with pytest.raises(StepError, match="grid_displacement: cell") as inverted:
        medium.step(10 * medium.step_size)
    assert inverted.value.variable == "grid_displacement" and medium.save().to_bytes() == start
    medium.reset(automata_velocity={30: (30.0, 0.0)})
    with pytest.raises(StepError, match="automata_velocity") as fast:
        medium.step()
    assert fast.value.variable == "automata_velocity" and fast.value.value > fast.value.limit
    medium.reset()
    assert medium.save().to_bytes() == before


@pytest.mark.parametrize("condition", ["absorbing", "fixed", "symmetry"])
def test_the_interface_is_no_edge_that_can_be_held_or_damped(condition: str) -> None:
    """It would take energy from what passes: half of a pulse, where it absorbs."""
    parts = {
        "grid": {
            "mesh": {"name": "rectangle", "columns": 4, "rows": 4, "cell_size": 0.01},
            "material": MEDIUM,
        },
        "automata": {
            "shape": {"name": "rectangle", "width": 0.04, "height": 0.04},
            "diameter": 0.01,
            "packing": "square",
            "material": MEDIUM,
        },
    }
    parts["automata"]["forced_automata"] = [[0.01, 0.02]]
    Coupled(origin=(0.04, 0.0), **parts)
    parts["grid"]["boundaries"] = {"right": condition, "left": "absorbing"}
    with pytest.raises(ParameterError, match=r"grid\.boundaries\.right: got .* where the interface is"):
        Coupled(origin=(0.04, 0.0), **parts)
