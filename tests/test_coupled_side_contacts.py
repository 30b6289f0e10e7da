"""Loose automata in contact with free sides of the grid: forces, conserved quantities, bits, refusals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.coupled_tools import cell_mesh, make_coupled

from granular_env.components.coupled import Coupled

STRONG = {"name": "strain", "tensile": 0.1, "shear": 0.1}


def body(n: int = 1, *, side_contacts: bool = True, grid: dict[str, Any] | None = None, **more: Any) -> Coupled:
    """Return four by four cells with automata to the right, and a piece of automata 2 m above the cells."""
    corners = [[4, 0], [8, 0], [8, 8], [0, 8], [0, 6], [4, 6]]
    gap = {"name": "box", "x": [2.4, 4.6], "y": [5.4, 8.6]}
    automata = {"shape": {"name": "polygon", "corners": corners, "holes": [gap]}, "criterion": STRONG}
    return make_coupled({"mesh": cell_mesh(4, 4), **(grid or {})}, automata, n, side_contacts=side_contacts, **more)


def piece_of(medium: Coupled) -> Any:
    return np.flatnonzero((medium.reference[:, 0] < 3.0) & (medium.reference[:, 1] > 5.0))


def throw(medium: Coupled, velocity: tuple[float, float]) -> float:
    """Start the piece with a velocity; return its kinetic energy."""
    velocities = np.zeros((medium.automata.count, 2))
    velocities[piece_of(medium)] = velocity
    medium.reset(automata_velocity=velocities)
    return medium.get("kinetic_energy")


def place(medium: Coupled, way: tuple[float, float]) -> None:
    """Start the piece at another position, at rest."""
    displacements = np.zeros((medium.automata.count, 2))
    displacements[piece_of(medium)] = way
    medium.reset(automata_displacement=displacements)


@pytest.mark.parametrize("n", [1, 2])
def test_a_side_pushes_what_lies_on_it_and_its_nodes_get_that_by_the_lever(n: int) -> None:
    """The lowest row of the piece has an overlap of 0.4 radii, 0.3 diameters to the right of the nodes."""
    medium = body(n, step_size=0.2 / n)
    radius = 0.5 / n
    place(medium, (0.3 / n, -2.0 + 0.6 * radius))
    specimen = medium._cracking  # noqa: SLF001
    assert specimen is not None
    forces, low = medium.forces_on_automata()[0], np.flatnonzero(np.abs(medium.reference[:, 1] - 6.0) < 1e-9)
    low = np.intersect1d(low, piece_of(medium))
    expected = specimen.contact_stiffness()[low] * 0.4 * radius
    np.testing.assert_allclose(forces[low], np.stack([0.0 * expected, expected], axis=1), atol=1e-12)
    assert expected.min() > 0.0 and len(low) == 2 * n + 1
    nodes = medium.forces_on_nodes()
    np.testing.assert_allclose(nodes.sum(axis=0), [0.0, -expected.sum()], atol=1e-12)
    places = (medium.reference + medium.get("automata_displacement"))[low]
    assert nodes[:, 1] @ medium.grid.mesh.nodes[:, 0] == pytest.approx(-(expected @ places[:, 0]), rel=1e-12)
    energy = 0.5 * (specimen.contact_stiffness()[low] * (0.4 * radius) ** 2).sum()
    assert medium.balances()[0].stored["contact_energy"] == pytest.approx(energy, rel=1e-12)


@pytest.mark.parametrize(
    "parameters",
    [{}, {"scheme": "momentum"}, {"n": 2, "micro_steps": 2}, {"grid": {"boundaries": {"top": "fixed", "left": "absorbing"}}}],
    ids=["lockstep", "momentum", "micro-steps", "fixed"],
)
def test_a_piece_that_is_thrown_at_the_grid_bounces_and_nothing_is_lost(parameters: dict[str, Any]) -> None:
    medium = body(**parameters, step_size=0.1)
    energy, piece = throw(medium, (0.0, -0.05)), piece_of(medium)
    pressed = 0.0
    for _ in range(60):
        medium.step(1.0)
        pressed = max(pressed, medium.balances()[0].stored["contact_energy"])
        assert (medium.reference + medium.get("automata_displacement"))[piece, 1].min() > 4.0
    assert pressed > 0.01 * energy
    # The piece pushes the grid down and rebounds.
    assert medium.get("automata_velocity")[piece, 1].mean() > 0.002
    assert abs(medium.get("energy_residual")) <= 0.01 * energy
    size = medium.get("mass") * 0.05
    assert np.abs(medium.get("momentum_residual")).max() <= 1e-15 * size
    assert abs(medium.get("angular_momentum_residual")) <= 1e-14 * size
    assert abs(medium.get("interface_work_difference")) <= 1e-14 * energy
    assert not medium.cautions() and medium.report()["automata: pieces inside cells of the grid"] == 0.0


def test_the_energy_of_a_bounce_closes_at_second_order() -> None:
    """A quarter of the step leaves about 1/16 of the error."""
    residuals = []
    for step in (0.2, 0.05):
        medium = body(step_size=step)
        throw(medium, (0.01, -0.05))
        medium.step(40.0)
        residuals.append(abs(medium.get("energy_residual")))
    assert 6.0 <= residuals[0] / residuals[1] <= 40.0
