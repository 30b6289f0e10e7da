"""Fracture of the solid: location, number of pieces, energies, and independence of the stepping."""

from __future__ import annotations

import re
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from support.solid_tools import ALUMINIUM, nodes_at_cracks

import granular_env as ge
from granular_env.components.shell import ticks
from granular_env.components.shell.fracture import force_recalculation
from granular_env.components.shell.fracture.laws.fracture_law import Point, decisive_value, may_exceed
from granular_env.components.shell.fracture.outcome import (
    OUTCOMES,
    CutSides,
    axial_crack_extent,
    circumferential_crack_part,
    connects_ends,
    outcome,
)
from granular_env.components.shell.kernels import write_areas

ALONG, ACROSS = 25, 13
NOTCH = {"length": 0.002, "depth": 0.0006, "width": 0.0005, "around": 0.003, "direction": "hoop"}
BODY = {"name": "plate", "length": 0.012, "width": 0.006, "along": ALONG, "across": ACROSS, "notch": NOTCH}
PULLED = {
    "body": BODY, "material": "thermoviscoplastic", "boundaries": {"start": "symmetry", "end": "platen"},
    "fracture": {"name": "principal_stress", "factor": 1.2}, "step_size": 2e-8,
}  # fmt: skip
SPEED = 12.0


TICKS = 400


def pulled_plate(**changes: Any) -> Any:
    """Return a notched plate that starts with a uniform strain rate."""
    plate: Any = ge.make("shell", **{**PULLED, **changes})
    plate.reset(nodal_velocity=plate.nodes * [SPEED / 0.012, 0.0, 0.0])
    return plate


def cracked_columns(plate: Any) -> np.ndarray:
    return plate.get("cracks").reshape(ALONG, ACROSS, 2).max(axis=2)


@cache
def broken_plate() -> Any:
    """Return the broken plate, and snapshots with few cracks and at the end."""
    plate = pulled_plate()
    while plate.event_count < 5:
        plate.step(plate.step_size, end_velocity=SPEED)
    early = plate.save().to_bytes()
    plate.step(TICKS * plate.step_size)
    return plate, early, plate.save().to_bytes()


def test_a_plate_breaks_in_two_at_its_notch() -> None:
    plate, *_ = broken_plate()
    assert plate.get("pieces") == 2.0
    along = plate.lattice.axes[0].positions
    parted = cracked_columns(plate)
    assert parted[np.abs(along - 0.006) < 0.0016].any(axis=0).all()
    assert parted[np.abs(along - 0.006) < 0.0016].sum() == parted.sum()
    first = plate.events("point_parted")[0]
    assert along[first.index // (2 * ACROSS)] == pytest.approx(0.006)
    assert first.limit == pytest.approx(1.2 * 275e6)
    assert first.limit < first.value < 1.1 * first.limit
    assert plate.get("crack_length") > 0.006
    moved = plate.nodes + plate.get("displacement")
    x = moved[plate.surface_nodes].reshape(ALONG, ACROSS, 3)[..., 0]
    # Both halves move apart as rigid bodies.
    opened = x[-1].mean() - x[0].mean() - 0.012
    area = plate.get("crack_area").sum()
    assert opened > 5e-5
    assert area == pytest.approx(opened * 0.006, rel=0.3)
    # A surface cell is broken if a crack lies between two of its corners.
    surface, _, _, links = plate.drawables()
    cut = links.pairs[plate.get("surface_links") == 0.0]
    column = {int(node): number for number, node in enumerate(plate.surface_nodes)}
    edges = {frozenset((column[a], column[b])) for a, b in cut.tolist()}
    crossed = [any({a, b} in edges for a, b in zip(cell, np.roll(cell, -1), strict=True)) for cell in surface.connectivity]
    assert 0 < sum(crossed) < len(crossed)
    assert np.array_equal(plate.get("surface_cells") == 0.0, crossed)
    report = plate.report()
    assert report["pieces"] == 2.0
    assert report["along the body, m"] == pytest.approx(0.006, abs=0.0025)
    assert report["largest fracture ratio so far, above 0.5"] > 1.0
    assert plate.get("fracture_ratio")[plate.get("cracks") == 0.0].max() <= 1.0


def test_what_has_become_of_a_body_is_told_with_the_reason() -> None:
    plate, _, late = broken_plate()
    plate.restore(ge.Snapshot.from_bytes(late))
    assert OUTCOMES[int(plate.get("outcome"))] == "severed"
    said, first = plate.conclusions()
    assert said.startswith("outcome: severed: cracks reach") and "; 2 pieces, and 7 fully detached columns" in said
    assert "parted points parted at 1.96 us, at x, y, z = 0.006, " in first
    whole = pulled_plate()
    assert whole.conclusions() == [
        "outcome: whole", "the largest principal stress stayed below half of its limit everywhere",
    ]  # fmt: skip
    whole.step(55 * whole.step_size, end_velocity=SPEED)
    outcome, reason = whole.conclusions()
    ratio = float(re.findall(r"reached at most ([0-9.]+) of its limit, at", reason)[0])
    assert outcome == "outcome: whole" and 0.5 < ratio < 1.0 and ratio >= whole.get("fracture_ratio").max() * 0.999


def test_outcomes_have_the_words_of_what_is_cut() -> None:
    tube: Any = ge.make("shell", body={"name": "tube", "length": 0.02, "along": 9, "around": 24})
    lattice, none = tube.lattice, np.zeros((9, 24), dtype=bool)
    straight, half, ring = none.copy(), none.copy(), none.copy()
    straight[3:6, 0] = True
    half[4, :12] = ring[4] = True
    quiet, flowed = np.zeros(9), np.full(9, 0.01)

    def word(along: Any, across: Any, is_severed: bool = False, strain: Any = quiet) -> str:
        return OUTCOMES[outcome(lattice, CutSides(along, across), is_severed, strain)]

    assert word(none, none) == "whole" and word(none, none, strain=flowed) == "bulged"
    assert word(none, straight) == "axial crack" and word(half, straight) == "hoop crack"
    assert word(ring, none, is_severed=True) == "severed"
    assert axial_crack_extent(lattice, CutSides(none, straight)) == pytest.approx(2 * 0.0025)
    assert circumferential_crack_part(lattice, CutSides(half, none)) == pytest.approx(0.5)
    # Twelve axial cracks that each step aside by one column are not a hoop crack; one continuous crack is.
    along, across = none.copy(), none.copy()
    along[4, ::2], across[:5, 1::2], across[5:, ::2] = True, True, True
    assert circumferential_crack_part(lattice, CutSides(along, none)) == pytest.approx(1 / 24)
    assert word(along, across) == "axial crack"
    # Two columns of a coarse tube count as a step aside, for any fraction of the circumference.
    aside = none.copy()
    aside[4, :2] = True
    assert circumferential_crack_part(lattice, CutSides(aside, none)) == pytest.approx(2 / 24)
    assert word(aside, straight) == "axial crack"
    # There is no axial crack here.
    assert word(aside, none) == "hoop crack"
    split = half.copy()
    split[4, 5] = False
    assert circumferential_crack_part(lattice, CutSides(split, none)) == pytest.approx(6 / 24)
    split[4, [0, 1, 23, 22]] = True
    assert circumferential_crack_part(lattice, CutSides(split, none)) == pytest.approx(7 / 24)
    pieces = np.repeat(np.arange(9) > 4, 24).astype(np.int64)
    borne = np.ones(9 * 24, dtype=bool)
    assert not connects_ends(pieces, borne, (9, 24)) and connects_ends(0 * pieces, borne, (9, 24))


@pytest.mark.slow
@pytest.mark.parametrize("factor", [1.2, 1.3, 1.5])
def test_the_outcome_does_not_hang_on_the_hourglass_control(factor: float) -> None:
    """The crack starts at the same time, within the 0.2 us that sound needs across the notch, and crosses the plate."""
    first = []
    for hourglass in (0.02, 0.05, 0.1):
        plate = pulled_plate(hourglass=hourglass, fracture={"name": "principal_stress", "factor": factor})
        while plate.get("pieces") < 2.0 and plate.time < 4e-5:
            plate.step(20 * plate.step_size, end_velocity=SPEED)
        # Pieces count as connected while any point has a node beyond the crack in its support, so check the crack instead.
        along = plate.lattice.axes[0].positions
        parted = cracked_columns(plate)
        assert parted[np.abs(along - 0.006) < 0.0016].any(axis=0).all()
        assert parted[np.abs(along - 0.006) < 0.0016].sum() == parted.sum()
        first.append(plate.events("point_parted")[0].tick * plate.step_size)
    assert max(first) - min(first) < 2e-7


def test_the_energy_of_a_breaking_body_closes() -> None:
    plate, *_ = broken_plate()
    energy, momentum, mass = plate.balances()
    work = energy.initial + energy.supplied["boundary_work"]
    assert abs(energy.residual) < 3e-4 * work
    assert energy.lost["fracture_energy"] > 0.0
    assert energy.lost["fracture_energy"] + energy.lost["eroded_energy"] < 0.2 * work
    assert np.abs(momentum.residual).max() < 1e-12 * (plate.mass.sum() * SPEED)
    assert mass.residual == 0.0


def test_a_breaking_run_goes_on_bit_for_bit_from_any_snapshot() -> None:
    _, early, end = broken_plate()
    other = pulled_plate()
    other.restore(ge.Snapshot.from_bytes(early))
    for count in (1, 1, 2, 96, TICKS - 100):
        other.step(count * other.step_size)
    assert other.save().to_bytes() == end
    # Go back before most cracks, and continue: everything derived from the cracks is recomputed.
    other.restore(ge.Snapshot.from_bytes(early))
    assert cracked_columns(other).sum() < 10.0
    assert other.get("pieces") == 1.0
    other.step(TICKS * other.step_size)
    assert other.save().to_bytes() == end


def test_a_step_that_fails_takes_its_cracks_back() -> None:
    _, early, end = broken_plate()
    other = pulled_plate()
    other.restore(ge.Snapshot.from_bytes(early))
    cracks, displacement = other.get("cracks"), other.get("displacement")
    with pytest.raises(ge.GranularError, match=r"a strain of .* the largest stable step .* is [0-9.e-]+ s"):
        other.step(100 * other.step_size, end_velocity=1e6)
    np.testing.assert_array_equal(other.get("cracks"), cracks)
    np.testing.assert_array_equal(other.get("displacement"), displacement)
    other.step(TICKS * other.step_size)
    assert other.save().to_bytes() == end
    other.reset()
    assert other.get("cracks").sum() == other.event_count == 0
    assert other.get("surface_links").min() == 1.0


def test_points_beside_cracks_still_see_even_deformations() -> None:
    plate, _, end = broken_plate()
    solid, state, _, _ = plate.tables()
    slope = np.array([[1e-3, 2e-4, 0.0], [0.0, -1e-3, 1e-4], [3e-4, 0.0, 5e-4]])
    state.displacement[:] = plate.nodes @ slope
    state.gradient[:] = force_recalculation.displacement_gradients(
        solid.points, state.displacement, np.arange(plate.point_count)
    )
    bears = np.ones(plate.point_count, dtype=bool)
    for kind in ("point_eroded", "point_spent", "point_torn"):
        bears[[event.index for event in plate.events(kind)]] = False
    gradient = state.gradient.reshape(-1, 3, 3)
    np.testing.assert_allclose(gradient[bears], np.tile(slope.T, (bears.sum(), 1, 1)), rtol=0.0, atol=1e-15)
    assert np.abs(gradient[~bears]).max(initial=0.0) == 0.0
    plate.restore(ge.Snapshot.from_bytes(end))


def test_cracks_of_a_mirrored_body_are_mirrored() -> None:
    plate = pulled_plate()
    while plate.event_count < 30:
        plate.step(plate.step_size, end_velocity=SPEED)
    cracks = plate.get("cracks").reshape(ALONG, ACROSS, 2)
    np.testing.assert_array_equal(cracks, cracks[:, ::-1])


def test_a_bar_breaks_where_it_is_weakest() -> None:
    """A brittle bar under uniform tension: the first crack is at the weakest column, and the bar breaks there."""
    body = {"name": "plate", "length": 0.012, "width": 0.002, "along": 25, "across": 5}
    law = {"name": "principal_stress", "stress": 1e8, "scatter": 0.1, "seed": 5}
    edges = {"start": "symmetry", "end": "platen"}
    material = {"name": "elastic", **ALUMINIUM, "poisson": 0.0}
    bar: Any = ge.make("shell", body=body, material=material, boundaries=edges, fracture=law, step_size=4e-8)
    # Start just below the strength of the weakest column.
    bar.reset(nodal_displacement=bar.nodes * [0.88e8 / 69e9, 0.0, 0.0], nodal_velocity=bar.nodes * [0.1 / 0.012, 0.0, 0.0])
    while bar.get("pieces") < 2.0 and bar.time < 2e-5:
        bar.step(10 * bar.step_size, end_velocity=0.1)
    first = bar.events("point_parted")[0]
    limits = bar.get("fracture_limit")
    assert limits[first.index] == first.limit == limits.min()
    cut = (bar.get("surface_links") == 0.0).reshape(-1)[: 24 * 5].reshape(24, 5).sum(axis=1)
    row = first.index // 10
    # The crack may step aside by a column.
    assert cut[row - 1 : row + 2].sum() >= 5
    assert bar.get("pieces") == 2.0


def test_nothing_parts_in_a_grip() -> None:
    """A brittle bar with the largest stress at its moved end breaks there or, if gripped, next to the grip."""
    body = {"name": "plate", "length": 0.012, "width": 0.002, "along": 25, "across": 5}
    material, edges = {"name": "elastic", **ALUMINIUM, "poisson": 0.0}, {"start": "symmetry", "end": "moved"}
    parted = []
    for grip in (0.0, 0.003):
        law = {"name": "principal_stress", "stress": 1e8, "grip_length": grip}
        bar: Any = ge.make("shell", body=body, material=material, boundaries=edges, fracture=law, step_size=4e-8)
        while bar.event_count == 0 and bar.time < 1e-5:
            bar.step(5 * bar.step_size, end_velocity=(12.0, 0.0, 0.0))
        event = bar.events("point_parted")[0]
        place = bar.lattice.axes[0].positions[event.index // 10]
        assert event.limit == 1e8 == bar.get("fracture_limit").min()
        parted.append(0.012 - place)
    gripped = (bar.get("fracture_limit") > 1e8).reshape(25, 10)
    assert gripped.all(axis=1).tolist() == [one > 0.009 + 1e-9 for one in bar.lattice.axes[0].positions]
    assert parted[0] < 0.003 <= parted[1] < 0.006


def test_plastic_strain_parts_what_has_flowed() -> None:
    plate = pulled_plate(fracture={"name": "plastic_strain", "strain": 0.03})
    while not plate.event_count and plate.time < 2e-5:
        plate.step(plate.step_size, end_velocity=SPEED)
    first = plate.events("point_parted")[0]
    assert 0.03 < first.value < 0.06
    assert plate.peek("plastic_strain")[first.index] == first.value
    with pytest.raises(ge.GranularError, match=r"fracture: got the law 'plastic_strain' with an elastic material"):
        ge.make("shell", fracture="plastic_strain")
    with pytest.raises(ge.GranularError, match=r"fracture: got the law 'principal_stress' with an elastic .* stress ="):
        ge.make("shell", material="elastic", fracture={"name": "principal_stress", "factor": 2.0})
    with pytest.raises(ge.GranularError, match=r"fracture.factor: got 2 in addition to stress = 3e\+08 Pa, .* one of the two"):
        ge.make("shell", fracture={"name": "principal_stress", "factor": 2.0, "stress": 3e8})
    with pytest.raises(ge.GranularError, match=r"fracture: got 'rankine', expected a known name"):
        ge.make("shell", fracture="rankine")


def test_a_body_that_nothing_parts_has_the_bits_of_one_without_a_law() -> None:
    plates = [pulled_plate(fracture=law) for law in ("none", {"name": "principal_stress", "factor": 3.0})]
    for plate in plates:
        plate.step(60 * plate.step_size, end_velocity=SPEED)
    for name in ("nodal_displacement", "nodal_velocity", "stress", "plastic_strain"):
        np.testing.assert_array_equal(plates[0].get(name), plates[1].get(name))
    assert plates[1].event_count == 0
    assert plates[0].get("fracture_ratio").max() == pytest.approx(plates[1].get("fracture_ratio").max(), rel=0.01)


def test_pressure_ends_on_lips_and_pieces() -> None:
    """A ring with glass-like scatter bursts; its pieces fly without internal pressure."""
    body = {"name": "tube", "length": 0.002, "along": 3, "around": 64}
    law = {"name": "principal_stress", "stress": 2e8, "scatter": 0.3, "seed": 2}
    ring: Any = ge.make(
        "shell", body=body, boundaries={"start": "symmetry", "end": "symmetry"}, fracture=law,
        material={"name": "elastic", **ALUMINIUM},
    )  # fmt: skip
    ring.step(round(1.5e-5 / ring.step_size) * ring.step_size, pressure=8e6)
    assert ring.get("pieces") > 2.0
    _, state, _, _ = ring.tables()
    surface = ring.tables()[0].surface
    loaded = np.abs(state.area).max(axis=1).reshape(3, 64)
    # All pieces except the largest carry no pressure.
    assert 0 < (loaded[1] > 0.0).sum() < 40
    # These nodes have zero area, because they have no neighbours along or around the tube.
    own = surface.around == np.arange(3 * 64)[:, None]
    assert (own[:, :2].all(axis=1) | own[:, 2:].all(axis=1))[loaded.ravel() == 0.0].all()
    assert ring.get("mean_inner_radius").min() > 0.01975
    assert (ring.get("crack_area") > 0.0).all()
    energy = ring.balances()[0]
    assert abs(energy.residual) < 1e-3 * energy.supplied["pressure_work"]


def test_a_node_that_flies_on_by_itself_bears_no_pressure_and_gives_its_neighbours_none() -> None:
    """Otherwise its area and the force on it would grow with its distance."""
    plate: Any = ge.make("shell", fracture={"name": "principal_stress", "stress": 1e9}, body={"name": "plate"}, step_size=1e-8)
    node = 10 * plate.lattice.shape[1] * 3 + 5 * 3
    plate._block.append("loosened", float(node))
    solid, state, _, _ = plate.tables()
    rest = np.abs(state.area).max(axis=0)
    state.displacement[node] = -1.0
    write_areas(solid.surface, state.displacement, state.area)
    own = int(np.flatnonzero(solid.surface.nodes == node)[0])
    assert (state.area[own] == 0.0).all()
    np.testing.assert_allclose(np.abs(state.area).max(axis=0), rest, atol=1e-20)


@pytest.mark.parametrize("fractures", [False, True])
def test_the_bits_do_not_depend_on_the_number_of_parts(fractures: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ticks, "LEAST_POINTS", 1)
    ends = []
    for threads in ("1", "2", "4"):
        monkeypatch.setenv("GRANULAR_ENV_THREADS", threads)
        plate = pulled_plate(**({} if fractures else {"fracture": "none"}))
        plate.step(220 * plate.step_size, end_velocity=SPEED)
        ends.append(plate.save().to_bytes())
        assert (plate.event_count > 20) == fractures
    assert ends[0] == ends[1] == ends[2]


class MeanStress(NamedTuple):
    """A law for this test."""


@decisive_value.register(MeanStress)
def mean_stress_of(law, point):
    return 0.5 * point.principal


def test_a_law_is_a_named_tuple_and_one_that_lacks_a_function_is_refused_by_name() -> None:
    assert decisive_value(MeanStress(), Point(3.0, 1.0, 0.0)) == 1.5
    with pytest.raises(TypeError, match="may_exceed: got a law MeanStress, expected one of PlasticStrainConstants"):
        may_exceed(MeanStress(), 1.0, None, 0.0)


def test_points_that_fail_beside_cracks_are_torn_alike_in_any_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nodes next to a crack are accelerated through the wall: points there carry no stress, and the energy closes."""
    monkeypatch.setattr(ticks, "LEAST_POINTS", 1)
    plate, _, end = broken_plate()
    ends = []
    for threads in ("1", "2"):
        monkeypatch.setenv("GRANULAR_ENV_THREADS", threads)
        plate.restore(ge.Snapshot.from_bytes(end))
        solid, state, _, _ = plate.tables()
        for node in nodes_at_cracks(plate):
            state.velocity[node] = (0.0, 0.0, -2.0e4)
        before, known = plate.balances()[0], {event.index for event in plate.events("point_torn")}
        plate.step(plate.step_size, end_velocity=SPEED)
        torn = [event.index for event in plate.events("point_torn") if event.index not in known]
        assert len(torn) > 4 and min(torn) < plate.point_count // 2 < max(torn), torn
        assert (state.stress[torn] == 0.0).all()
        after = plate.balances()[0]
        assert abs(after.residual - before.residual) < 1e-3 * sum(after.stored.values())
        ends.append(plate.save().to_bytes())
    assert ends[0] == ends[1]
    plate.restore(ge.Snapshot.from_bytes(end))
