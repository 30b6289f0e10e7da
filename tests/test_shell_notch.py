"""The solid with a notch: its lattice, and the load on the ligament below the notch."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from support.solid_tools import RADIUS, WALL

import granular_env as ge
from granular_env.components.materials.thermoviscoplastic import Thermoviscoplastic
from granular_env.components.shell.geometry.bodies import BODIES
from granular_env.components.shell.quadrature import integration_points
from granular_env.components.shell.stencils import make_stencils
from granular_env.components.shell.zero_modes import RIGID_MOTIONS, stiffness_matrix

SLOT = {"length": 0.006, "depth": 0.0006, "width": 0.0005, "columns": 1}
TUBE = {"name": "tube", "length": 0.02, "along": 15, "around": 40, "notch": SLOT}
PLATE = {"name": "plate", "length": 0.012, "width": 0.006, "along": 15, "across": 9, "notch": {**SLOT, "around": 0.003}}


def lattice_of(body: dict[str, Any]) -> Any:
    return BODIES[body["name"]](**{key: value for key, value in body.items() if key != "name"}).lattice()


@pytest.mark.parametrize("direction", ["axial", "hoop"])
def test_a_notch_takes_its_volume_from_nodes_and_points(direction: str) -> None:
    slot = {**SLOT, "length": 0.0045, "direction": direction, "spacing": 0.0015}
    outer, bottom = RADIUS + WALL, RADIUS + WALL - 0.0006
    tube = {**TUBE, "notch": slot}
    whole = math.pi * (outer**2 - RADIUS**2) * 0.02
    cut = 0.0045 * (0.0005 / outer) * 0.5 * (outer**2 - bottom**2)
    plate = {**PLATE, "across": 15, "notch": {**slot, "around": 0.003}}
    for body, volume in ((tube, whole - cut), (plate, 0.012 * 0.006 * WALL - 0.0045 * 0.0005 * 0.0006)):
        lattice = lattice_of(body)
        assert lattice.volumes.sum() == pytest.approx(volume, rel=1e-12)
        for rule in ("column", "cell"):
            points = integration_points(lattice, rule, 2, 1.7)
            # With cells, each point is entirely below the notch or not, so the volume is accurate to the width of the slot.
            assert points.volume.sum() == pytest.approx(volume, rel=1e-12 if rule == "column" else 0.01)


def test_planes_lie_closer_at_the_notch_and_one_at_its_bottom() -> None:
    lattice = lattice_of({**TUBE, "along": 27, "notch": {**SLOT, "spacing": 0.0006}})
    along, around, through = (axis.positions for axis in lattice.axes)
    assert (RADIUS + WALL - 0.0006) == pytest.approx(through[1], rel=1e-12)
    distance = np.diff(along)
    inside = distance[np.abs(along[:-1] + 0.5 * distance - 0.01) < 0.003]
    np.testing.assert_allclose(inside, inside[0], rtol=1e-9)
    assert inside[0] < 0.0006 < distance[0]
    assert (distance[1:] / distance[:-1]).max() < 1.6
    np.testing.assert_allclose(along + along[::-1], 0.02, rtol=1e-12)
    arcs = np.diff(np.append(around, 2.0 * math.pi)) * (RADIUS + WALL)
    assert arcs[0] == pytest.approx(0.0005, rel=1e-9)
    assert arcs[0] == pytest.approx(arcs.min(), rel=1e-9)
    np.testing.assert_allclose(arcs, arcs[::-1], rtol=1e-9)
    # The middle of the slot lies on a plane of symmetry, which leaves one half of it.
    half = lattice_of({**TUBE, "half": True, "around": 21})
    assert half.hollow.columns[:, 0].any()
    assert not half.hollow.columns[:, 1:].any()
    assert half.axes[1].widths[0] * (RADIUS + WALL) == pytest.approx(0.00025, rel=1e-9)


@pytest.mark.parametrize("layers", [3, 4, 6])
def test_a_patch_with_a_notch_has_the_rigid_motions_as_its_only_modes_without_energy(layers: int) -> None:
    notch = {"length": 0.003, "depth": 0.0006, "width": 0.0008, "around": 0.003, "columns": 1}
    body = {"name": "plate", "length": 0.006, "width": 0.006, "along": 7, "across": 7, "layers": layers, "notch": notch}
    lattice = lattice_of(body)
    points = integration_points(lattice, "column", layers - 1, 1.7)
    stencils = make_stencils(lattice, points.lines, 1.7, "linear", points.all_indices())
    values = np.linalg.eigvalsh(stiffness_matrix(lattice.node_count, points, stencils, 1.0, 0.3))
    assert (values < 1e-10 * values[-1]).sum() == RIGID_MOTIONS


def test_a_notched_body_deforms_evenly_and_keeps_its_momentum() -> None:
    solid: Any = ge.make("shell", body=TUBE)
    slope = np.array([[1e-3, 2e-4, 0.0], [0.0, -1e-3, 1e-4], [3e-4, 0.0, 5e-4]])
    solid.reset(nodal_displacement=solid.nodes @ slope)
    _, state, _, _ = solid.tables()
    np.testing.assert_allclose(state.gradient.reshape(-1, 3, 3), np.tile(slope.T, (solid.point_count, 1, 1)), atol=1e-14)
    np.testing.assert_allclose(solid.get("displacement"), solid.nodes @ slope, rtol=0.0, atol=1e-17)
    assert solid.get("hourglass_energy") < 1e-20 * solid.get("elastic_energy")
    solid.step(40 * solid.step_size)
    energy, momentum, mass = solid.balances()
    assert abs(energy.residual) < 1e-4 * energy.initial
    assert np.abs(momentum.residual).max() < 1e-12 * np.abs(solid.mass[:, None] * solid.get("nodal_velocity")).sum()
    assert mass.entries["mass"] == pytest.approx(2719.0 * solid.assembly.points.volume.sum(), rel=1e-12)


@pytest.mark.parametrize("columns", [1, 3, 9])
def test_the_ligament_bears_the_load_of_the_whole_section(columns: int) -> None:
    """Slow tension of a strip with a transverse groove: stress times section is equal in all columns.

    Point stresses alternate between columns; mean stresses, which fracture and output use, do not. A ligament of one column
    has no neighbours with the same section.
    """
    along, width = (41, 0.0025) if columns == 9 else (23, 0.0005)
    groove = {
        "length": 0.002, "depth": 0.0006, "width": width, "around": 0.001, "direction": "hoop", "columns": min(columns, 3),
    }  # fmt: skip
    body = {"name": "plate", "length": 0.012, "width": 0.002, "along": along, "across": 4, "notch": groove}
    edges = {"start": "symmetry", "end": "platen", "bottom": "symmetry"}
    solid: Any = ge.make("shell", body=body, boundaries=edges, material={"name": "elastic", "poisson": 0.0})
    lattice = solid.lattice
    assert lattice.hollow.columns[:, 0].sum() == columns
    # Sound needs 2.4 us along the strip, so a load over 10 us is nearly static.
    pulled = ge.Profile.table([0.0, 2e-5, 4e-5, 1.0], [0.0, 0.3, 0.3, 0.3])
    solid.step(round(2e-5 / solid.step_size) * solid.step_size, end_velocity=pulled)
    forces, points = [], []
    for _ in range(10):
        solid.step(round(2e-6 / solid.step_size) * solid.step_size, end_velocity=pulled)
        volume = solid.assembly.points.volume.reshape(along, -1) / lattice.axes[0].widths[:, None]
        for name, found in (("mean_stress", forces), ("stress", points)):
            found.append((solid.get(name)[:, 0].reshape(along, -1) * volume).sum(axis=1))
    force, point = np.mean(forces, axis=0), np.mean(points, axis=0)
    held = ~lattice.hollow.columns[:, 0] if columns == 1 else np.ones(along, dtype=bool)
    np.testing.assert_allclose(force[held], force[:5].mean(), rtol=0.03)
    assert np.abs(point[held] / point[:5].mean() - 1.0).max() > 0.1


@pytest.mark.parametrize(("along", "width", "columns"), [(23, 0.0005, 3), (41, 0.0025, 9)])
def test_a_ligament_that_flows_bears_no_more_than_its_flow_stress(along: int, width: float, columns: int) -> None:
    """In plane strain, a section between free surfaces carries 2/sqrt(3) of the flow stress, and almost none across."""
    groove = {"length": 0.002, "depth": 0.0006, "width": width, "around": 0.001, "direction": "hoop"}
    body = {"name": "plate", "length": 0.012, "width": 0.002, "along": along, "across": 4, "notch": groove}
    edges = {"start": "symmetry", "end": "platen", "left": "symmetry", "right": "symmetry"}
    solid: Any = ge.make("shell", body=body, boundaries=edges, material="thermoviscoplastic")
    below = np.flatnonzero(solid.lattice.hollow.columns[:, 0])
    assert len(below) == columns
    solid.step(4e-5, end_velocity=ge.Profile.table([0.0, 1e-5, 1.0], [0.0, 3.0, 3.0]))
    stress = solid.get("stress").reshape(along, 4, 2, 6)[below, 1] / 275e6
    strain = solid.get("plastic_strain").reshape(along, 4, 2)[below, 1]
    assert strain.min() > 0.005
    assert np.abs(stress[..., 2]).max() < 0.3
    law = Thermoviscoplastic()
    most = 2.0 / math.sqrt(3.0) * (1.0 + 1.0 / law.reference_strain) ** law.hardening_exponent
    assert 1.0 < stress[..., 0].mean() < most
    # Force at the end divided by the section of the ligament.
    force = solid.get("stress").reshape(along, 4, 2, 6)[:4, 1, :, 0].mean() * WALL / (WALL - 0.0006) / 275e6
    assert force < 1.1 * most


# A slot of three columns, deep and shallow.
