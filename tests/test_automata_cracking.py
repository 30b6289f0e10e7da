"""Automata with yielding, fracture, contact and friction: laws against closed forms, energies, bits, shipped experiments."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from support.automata_tools import BOTH, block

import granular_env as ge
from granular_env.components.automata import Automata, theory
from granular_env.components.automata.laws import CRITERIA
from granular_env.components.automata.laws.criterion import LinkStress, failure_measure


def confined(**laws: object) -> Automata:
    """Return a square block, stretched along y and held along x, with homogeneous strain and stress."""
    return block(
        columns=2,
        rows=2,
        boundaries={
            "left": "symmetry",
            "right": "symmetry",
            "bottom": "symmetry",
            "top": {"name": "velocity", "components": "y"},
        },
        **laws,
    )


def stretch(automata: Automata, strain: float, rate: float = 2e-6) -> None:
    """Stretch the block slowly to a given strain."""
    now = automata.get("displacement")[-1, 1] / 2.0
    ticks = max(1, round(abs(strain - now) / rate / automata.step_size))
    automata.step(ticks * automata.step_size, top_velocity=[0.0, 2.0 * (strain - now) / (ticks * automata.step_size)])


# -- responses: figure 3 ------------------------------------------------------------------------------------------------

ONSET, HARDENING = 2e-3, 0.5
# In uniaxial strain eps, the equivalent stress is 2 eps (G = 1) and the equivalent strain is 2/3 eps. Beyond the onset of
# yielding, the stress grows at the rate 3 G H / (3 G + H) per equivalent strain.
TANGENT = 2.0 / 3.0 * 3.0 * HARDENING / (3.0 + HARDENING)


def equivalent_in_the_middle(automata: Automata) -> float:
    xx, yy, _ = automata.get("stress")[4]
    return float(yy - xx)


def stiffness_left(part: float) -> float:
    """Integrate the degradation dg = -beta g (3 g G - H_t) de / s up to the strain 3e-3."""
    stiffness, steps, slope = 1.0, 100_000, 1.5 * TANGENT
    change = 2.0 / 3.0 * 2e-3 / steps  # increment of the equivalent strain, 2/3 eps, beyond eps = 1e-3
    for number in range(steps):
        stress = ONSET + slope * change * (number + 0.5)
        stiffness -= part * stiffness * (3.0 * stiffness - slope) * change / stress
    return stiffness


@pytest.mark.parametrize(
    ("response", "slope", "left"),
    [
        ({"name": "linear"}, 2.0, 0.0),
        ({"name": "degrading", "onset": ONSET, "hardening": HARDENING}, "secant", 0.0),
        ({"name": "plastic", "yield_stress": ONSET, "hardening": HARDENING}, 2.0, "flow"),
        ({"name": "plastic_degrading", "yield_stress": ONSET, "hardening": HARDENING, "degradation": 0.5}, "between", "some"),
    ],
    ids=["a", "b", "c", "d"],
)
def test_the_four_response_functions(response: dict[str, object], slope: object, left: object) -> None:
    automata = confined(response=response)
    stretch(automata, 0.5e-3)
    assert equivalent_in_the_middle(automata) == pytest.approx(1e-3, rel=0.01)
    stretch(automata, 3e-3)
    linear = response["name"] == "linear"
    envelope = 6e-3 if linear else ONSET + TANGENT * 2e-3
    assert equivalent_in_the_middle(automata) == pytest.approx(envelope, rel=0.01)
    # Flow does not change the pressure; degradation reduces the bulk modulus by 2 g G / 3.
    top = equivalent_in_the_middle(automata)
    stretch(automata, 2.5e-3)
    unloading = (top - equivalent_in_the_middle(automata)) / 0.5e-3
    part = {2.0: 0.0, "secant": 1.0, "between": 0.5}[slope]
    assert unloading == pytest.approx(2.0 * stiffness_left(part), rel=0.02)
    assert slope != "secant" or unloading == pytest.approx(top / 3e-3, rel=0.02)
    zero = 2.5e-3 - equivalent_in_the_middle(automata) / unloading
    flow = 3e-3 - envelope / 2.0
    low, high = {0.0: (-1e-4, 1e-4), "flow": (0.97 * flow, 1.03 * flow), "some": (0.1 * flow, 0.9 * flow)}[left]
    assert low <= zero <= high
    lost = automata.get("inelastic_energy") if not linear else 0.0
    assert (lost > 0.0) == (not linear)
    assert abs(automata.get("energy_residual")) <= 0.01 * automata.get("input_work")


# -- criteria -----------------------------------------------------------------------------------------------------------

# Uniaxial strain e: sigma_n = 3 e, sigma_eq = 2 e, sigma_m = 5/3 e.
CASES = {
    "von_mises": ({"strength": 4e-3}, "von_mises_break", 2e-3, 4e-3),
    "drucker_prager": (
        {"compressive": 12e-3, "tensile": 4e-3},
        "drucker_prager_break",
        12e-3 / (2.0 * 2.0 + 3.0 * 5.0 / 3.0),
        12e-3,
    ),
    "mohr_coulomb": ({"cohesion": 1.0, "internal_friction": 0.5, "tensile": 6e-3}, "tension_break", 2e-3, 6e-3),
    "strain": ({"tensile": 2e-3}, "stretch_break", 2e-3, 2e-3),
}


@pytest.mark.parametrize("name", CASES)
def test_a_criterion_breaks_at_its_closed_form(name: str) -> None:
    strengths, kind, strain, limit = CASES[name]
    automata = confined(criterion={"name": name, **strengths})
    stretch(automata, 0.98 * strain)
    assert automata.events() == [] and automata.get("broken_links") == 0.0
    stretch(automata, 1.02 * strain)
    first = automata.events()[0]
    assert first.kind == kind and first.limit == pytest.approx(limit, rel=1e-12)
    assert first.limit <= first.value <= 1.01 * first.limit
    assert automata.get("linked")[first.index] < 1.0


def test_every_criterion_agrees_with_its_formula() -> None:
    generator = np.random.default_rng(0)
    tables = {name: CRITERIA[name](**strengths) for name, (strengths, *_) in CASES.items()}
    for _ in range(200):
        eps, gamma, normal, tangential, side, depth = 1e-2 * generator.standard_normal(6)
        mean = (normal + side + depth) / 3.0
        squares = (normal - side) ** 2 + (side - depth) ** 2 + (depth - normal) ** 2
        equivalent = math.sqrt(0.5 * squares + 3.0 * tangential**2)
        found = {
            name: failure_measure(one.constants(), LinkStress(eps, gamma, normal, tangential, equivalent, mean, 1.0, 0))
            for name, one in tables.items()
        }
        assert found["von_mises"] == (equivalent, 4e-3, 0)
        # The compressive strength is three times the tensile strength.
        assert found["drucker_prager"][0] == pytest.approx(2.0 * equivalent + 3.0 * mean, rel=1e-12)
        value, limit, cause = found["mohr_coulomb"]
        shear = abs(tangential) + 0.5 * normal
        assert value / limit == pytest.approx(max(shear / 1.0, normal / 6e-3), rel=1e-12)
        assert cause == int(normal / 6e-3 >= shear)
        assert found["strain"][:2] == (pytest.approx(eps), 2e-3) or eps / 2e-3 < abs(gamma) / 1e300


STRENGTHS_OF_ALL = {
    "von_mises": {"strength": 1e-9},
    "drucker_prager": {"compressive": 4e-9, "tensile": 1e-9},
    "mohr_coulomb": {"cohesion": 2e-9, "internal_friction": 0.4, "tensile": 1e-9},
    "strain": {"tensile": 1e-9, "shear": 3e-9},
}


@BOTH
@pytest.mark.parametrize("compression", [False, True], ids=["tension", "compression"])
@pytest.mark.parametrize("angle", [0.0, 0.3, 0.5 * math.pi])
@pytest.mark.parametrize("name", STRENGTHS_OF_ALL)
def test_uniaxial_strengths_are_where_links_break(packing: str, name: str, angle: float, compression: bool) -> None:
    criterion = CRITERIA[name](**STRENGTHS_OF_ALL[name])
    solid = ge.Material(density=1.0, young=2.5, poisson=0.25)
    strength = theory.uniaxial_strength(packing, criterion, solid, angle=angle, compression=compression)
    automata = block(packing, criterion=criterion)
    # A stress s along the angle gives strains (1 - nu^2) s / E and -nu (1 + nu) s / E, whose squares are negligible.
    stress = 1e-12 if not compression else -1e-12
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    strain = turn @ np.diag([0.9375, -0.3125]) @ turn.T * stress / 2.5
    automata.reset(displacement=automata.packing.reference @ strain)
    x, y = automata.packing.reference.T
    inside = np.flatnonzero((x > 2.0) & (x < 6.0) & (y > 2.0) & (y < y.max() - 2.0))
    ends = automata.packing.pairs()[:, :2]
    ratio = automata.get("criterion_ratio")[np.isin(ends, inside).all(axis=1)].max()
    assert ratio == pytest.approx(1e-12 / strength, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize(("packing", "part"), [("square", 1.06), ("hexagonal", 0.96)])
def test_a_crack_starts_at_the_toughness(packing: str, part: float) -> None:
    """A long crack in a clamped strip in equilibrium; the energy ahead of it gives the stress intensity."""
    tractions = {"name": "mohr_coulomb", "cohesion": 1e30, "internal_friction": 0.0, "tensile": 1.0}
    automata = block(packing, 80, 20, criterion=tractions)
    automata.reset()
    (ends, slots), places = (automata.packing.pairs()[:, :2], automata.packing.pairs()[:, 2]), automata.packing.reference
    height, middle = places[:, 1].max(), places[ends].mean(axis=1)
    row = 9.5 / 20.0 * height
    cut = (np.abs(middle[:, 1] - row) < 0.1) & (middle[:, 0] < 40.0)
    assert cut.sum() >= 40
    automata._block["weight"][slots[cut], automata.body.layout.place[ends[cut, 0]]] = 0.0
    held = (places[:, 1] < 0.1) | (places[:, 1] > height - 0.1)
    size = 1e-9
    start = np.column_stack([0.0 * places[:, 0], size * (places[:, 1] / height - 0.5), 0.0 * places[:, 0]])

    def forces(motion: np.ndarray) -> np.ndarray:
        motion = motion.reshape(-1, 3)
        automata._block["displacement"][:], automata._block["rotation"][:] = motion[:, :2], motion[:, 2]
        force, torque = automata.specimen.forces(), automata.specimen.torques()
        return np.where(held[:, None], 0.0, np.column_stack([force, torque])).reshape(-1)

    way = np.zeros_like(start).reshape(-1)
    residual = forces(start)
    direction, left = residual.copy(), float(residual @ residual)
    first = left
    while left > 1e-16 * first:  # conjugate gradients; forces are linear in these small motions
        answer = -forces(direction)
        step = left / float(direction @ answer)
        way, residual = way + step * direction, residual - step * answer
        left, before = float(residual @ residual), left
        direction = residual + left / before * direction
    forces(start.reshape(-1) + way)
    stress = 3.0 * size / height  # lambda + 2 G = 3, E / (1 - nu^2) = 8 / 3
    intensity = math.sqrt(8.0 / 3.0 * 0.5 * stress * size)
    largest = automata.get("criterion_ratio").max()  # from the traction along a link
    assert intensity == pytest.approx(part * theory.fracture_toughness(largest, 1.0), rel=0.02)


def test_a_weaker_and_a_stronger_pair_break_at_their_own_strengths() -> None:
    automata = confined(criterion={"name": "strain", "tensile": 2e-3}, strength_scatter=0.4, strength_seed=3)
    stretch(automata, 4e-3)
    limits = [event.limit for event in automata.events()]
    assert len(limits) > 1 and len(set(limits)) == len(limits)
    assert all(0.6 * 2e-3 <= limit <= 1.4 * 2e-3 for limit in limits)


# -- contacts -----------------------------------------------------------------------------------------------------------


def loose_pair(friction: float) -> tuple[Automata, int, int]:
    """Return two unlinked whole automata far from the others, the second to the right of the first."""
    automata = block(columns=6, rows=6, criterion={"name": "strain", "tensile": 10.0}, friction=friction, step_size=0.02)
    first, second = (
        int(np.flatnonzero((automata.packing.reference == place).all(axis=1))[0]) for place in ((2.0, 3.0), (4.0, 3.0))
    )
    automata.reset(displacement={first: (0.0, 20.0), second: (-0.9, 20.0)})
    automata._block["weight"][:] = 0.0  # remove all links
    return automata, first, second


def collide(automata: Automata, first: int, second: int, velocity: tuple[float, float], spin: float = 0.0) -> None:
    automata._block["velocity"][first] = velocity
    automata._block["spin"][first] = spin
    automata._block["start"][:] = (
        automata.specimen.momenta_and_energies()[3] + automata.specimen.momenta_and_energies()[4],
        *automata.specimen.momenta_and_energies()[:3],
    )
    automata.step(120.0)


def test_a_head_on_collision_is_elastic() -> None:
    automata, first, second = loose_pair(0.5)
    collide(automata, first, second, (0.01, 0.0))
    velocity = automata.get("velocity")
    # The error of leapfrog is at most (omega h)^2 / 4 = 5e-4, with omega^2 = 2 k / m = 5.
    np.testing.assert_allclose(velocity[[first, second]], [[0.0, 0.0], [0.01, 0.0]], atol=1e-5)
    assert automata.get("touching") == 0.0 and automata.get("friction_energy") == 0.0


def test_an_oblique_collision_slides_as_coulomb_says() -> None:
    automata, first, second = loose_pair(0.1)
    collide(automata, first, second, (0.01, 0.0), spin=0.2)
    velocity, spin = automata.get("velocity"), automata.get("angular_velocity")
    normal, across = velocity[second]
    # Sliding lasts throughout: the tangential impulse is 0.1 of the normal impulse, and opposes the rotation.
    assert abs(across) == pytest.approx(0.1 * normal, rel=0.02)
    assert spin[first] + spin[second] < 0.2
    assert automata.get("friction_energy") > 0.0
    assert abs(automata.get("energy_residual")) <= 0.01 * automata.get("friction_energy")
    assert np.abs(automata.get("momentum_residual")).max() <= 1e-14
    assert abs(automata.get("angular_momentum_residual")) <= 1e-13


# -- breaking -----------------------------------------------------------------------------------------------------------


def test_the_energy_of_a_broken_pair_is_released_and_counted() -> None:
    strain = {"name": "strain", "tensile": 1e-2}
    automata = block(columns=4, rows=2, boundaries={"left": "fixed", "right": "velocity"}, criterion=strain, step_size=0.05)
    automata.step(4.0, right_velocity=[0.004, 0.0])
    while automata.get("broken_links") == 0.0:
        automata.step()
    before = automata.get("fracture_energy")
    assert set(np.unique(automata.get("linked"))) - {0.0, 1.0}, "it is being released"
    automata.step(1.0, right_velocity=0.0)
    assert automata.get("fracture_energy") > before
    automata.step(20.0)
    assert not set(np.unique(automata.get("linked"))) - {0.0, 1.0}, "released within 20 internal steps"
    assert abs(automata.get("energy_residual")) <= 0.01 * automata.get("input_work")


@BOTH
def test_what_never_breaks_moves_as_what_cannot(packing: str) -> None:
    velocity = 1e-4 * np.random.default_rng(2).standard_normal((block(packing).count, 2))
    found = []
    for criterion in ("none", {"name": "strain", "tensile": 1.0}):
        automata = block(packing, criterion=criterion)
        automata.reset(velocity=velocity)
        automata.step(20.0)
        found.append(automata.get("displacement"))
    np.testing.assert_allclose(found[0], found[1], atol=1e-12 * np.abs(found[0]).max())


@BOTH
def test_mirrored_loads_give_mirrored_cracks(packing: str) -> None:
    """Bitwise identical without contacts: contact forces are summed in the order of the automata, which mirroring changes."""
    criterion = {"name": "mohr_coulomb", "cohesion": 0.02, "internal_friction": 0.3, "tensile": 0.01}
    automata = block(packing, 10, 8, boundaries={"left": "velocity", "right": "velocity"}, criterion=criterion)
    x, y = automata.packing.reference.T
    mirror = np.array([int(np.argmin((x - (10.0 - a)) ** 2 + (y - b) ** 2)) for a, b in zip(x, y, strict=True)])
    automata.step(5.0, left_velocity=[-0.01, 0.0], right_velocity=[0.01, 0.0])
    while automata.get("broken_links") < 4:
        automata.step(1.0)
    broken = automata.get("linked") < 1.0
    pairs = automata._pairs[:, :2]
    cracked = {tuple(sorted(pair)) for pair in pairs[broken].tolist()}
    assert cracked == {tuple(sorted(pair)) for pair in mirror[pairs[broken]].tolist()}
    assert automata.get("touching") == 0.0
    u = automata.get("displacement")
    np.testing.assert_array_equal(u[mirror], [-1.0, 1.0] * u)


# -- logs ---------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def compression(tmp_path_factory: pytest.TempPathFactory) -> ge.Log:
    path = tmp_path_factory.mktemp("logs") / "compression.mcap"
    ge.run("psakhie-2003/uniaxial-compression", log=path, overrides={"duration": 2.8e-4})
    return ge.open_log(path)


def test_a_sample_fails_in_shear_bands_and_its_energy_is_accounted_for(compression: ge.Log) -> None:
    end = compression.duration
    energy = {name: float(compression.get(name, end)) for name in ("fracture_energy", "friction_energy", "input_work")}
    assert min(energy.values()) > 0.0
    # Relative to the dissipated energy, because the rest of the work is elastic.
    lost = energy["fracture_energy"] + energy["friction_energy"]
    assert abs(compression.get("energy_residual", end)) <= 0.01 * lost
    kinds = {event.kind for event in compression.events()}
    assert kinds == {"shear_break", "tension_break"} and compression.events("shear_break")
    # The first pairs break at the corners; the bands are inclined by about 60 degrees, the direction of the packing's rows.
    points, links = compression.branch(0.0).component.drawables()
    place = points.reference[links.pairs[compression.events()[0].index, 0]]
    assert min(abs(place[0]), abs(place[0] - 0.05)) < 0.006 and min(abs(place[1]), abs(place[1] - 0.1)) < 0.006
    damage = compression.get("damage", end)
    assert 0.05 < (damage > 0.0).mean() < 0.6, "bands, not everything"


def test_a_cracking_run_replays_and_branches_bit_for_bit(compression: ge.Log, tmp_path: Path) -> None:
    assert ge.verify(compression.path).identical
    branch = compression.branch(2.6e-4)
    assert branch.component.event_count > 0
    branch.run(tmp_path / "branch.mcap")
    assert branch.component.get("displacement").tobytes() == compression.get("displacement", compression.duration).tobytes()
    assert ge.verify(tmp_path / "branch.mcap").identical


@pytest.fixture(scope="module")
def splitting(tmp_path_factory: pytest.TempPathFactory) -> ge.Log:
    path = tmp_path_factory.mktemp("logs") / "disc.mcap"
    return ge.open_log(ge.run("psakhie-2003/brazilian-disc", log=path, overrides={"duration": 1.2e-4}).log)


def test_a_disc_splits_from_its_centre(splitting: ge.Log) -> None:
    log = splitting
    disc = log.branch(log.duration).component
    points, links = disc.drawables()
    places = points.reference[links.pairs[[event.index for event in log.events()], 0]]
    assert log.events()[0].kind == "tension_break" and np.hypot(*places[0]) < 0.0249 / 4
    broken = points.reference[links.pairs[disc.get("linked") < 1.0, 0]]
    assert np.ptp(broken[:, 1]) > 2.0 * np.ptp(broken[:, 0])  # along the line of loading
    # Nearly all of the work is elastic.
    assert abs(disc.get("energy_residual")) <= 0.01 * disc.get("fracture_energy")
    # The measured strength 2 P / (pi D t) equals the strength of the pairs.
    load = np.abs(log.series("top_reaction")[1][:, 1]).max()
    assert 2.0 * load / (math.pi * 0.0498) == pytest.approx(5e6, rel=0.1)


def test_the_recorded_link_forces_and_stresses_of_a_disc_are_those_of_its_load(splitting: ge.Log) -> None:
    """A horizontal section carries the force of the nearest plate; the centre has the stresses of a disc under two forces."""
    time = 1.1e-4  # just before the first pair breaks
    get = {name: splitting.get(name, time) for name in ("displacement", "link_force", "stress")}
    (points, links), rows = splitting.drawables, np.unique(splitting.drawables[0].reference[:, 1].round(6))
    assert links.force == "link_force"
    centres, heights = points.reference + get["displacement"], points.reference[:, 1]
    ways = np.diff(centres[links.pairs], axis=1)[:, 0]
    upward = get["link_force"] * ways[:, 1] / np.linalg.norm(ways, axis=1)

    def section(row: int) -> float:
        below, above = heights[links.pairs].T < rows[row] + 1e-4
        return float(upward[below & ~above].sum())

    loads = -splitting.get("top_reaction", time)[1], splitting.get("bottom_reaction", time)[1]
    # Only the shear forces of turned pairs are missing.
    assert section(-2) == pytest.approx(loads[0], rel=1e-4) and section(0) == pytest.approx(loads[1], rel=1e-4)
    middle = section(len(rows) // 2)
    assert middle == pytest.approx(0.5 * sum(loads), rel=0.02)  # the disc is still accelerated
    # Tension 2 P / (pi D t) across the load, three times as much pressure along it; flats of 28 degrees reduce both.
    nearest = np.argsort(np.hypot(*points.reference.T))[:4]
    across, along, shear = get["stress"][nearest].mean(axis=0) * math.pi * 0.0498 / (2.0 * middle)
    assert 0.8 < across < 1.0 and -3.0 < along < -2.7 and abs(shear) < 1e-9


# -- refusals -----------------------------------------------------------------------------------------------------------


# -- why it did not break -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("criterion", "per_strain"),
    [
        # Uniaxial strain with lambda = G = 1: s_yy = 3 eps, s_xx = s_zz = eps, so s_eq = 2 eps and s_m = 5/3 eps.
        ({"name": "strain", "tensile": 0.02}, 50.0),
        ({"name": "von_mises", "strength": 0.04}, 50.0),
        ({"name": "drucker_prager", "compressive": 0.2, "tensile": 0.1}, 27.5),
        ({"name": "mohr_coulomb", "cohesion": 10.0, "internal_friction": 0.0, "tensile": 0.06}, 50.0),
    ],
)
def test_each_pair_tells_how_near_to_breaking_it_is(criterion: dict[str, object], per_strain: float) -> None:
    automata = confined(criterion=criterion)
    stretch(automata, 1e-3, rate=1e-5)
    ratio = automata.get("criterion_ratio")
    across = automata.specimen._pairs[:, 2] == 1
    assert automata.events() == [] and ratio.shape == (len(across),)
    assert ratio[across] == pytest.approx(np.full(across.sum(), per_strain * 1e-3), rel=0.02)


# -- energies of crushed and torn rock ------------------------------------------------------------------------------------
