"""The shipped experiments with a grid and automata: figures 6 to 8 of Psakhie et al. (2003), quantitatively."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import granular_env as ge

PLANE_WAVES = {"plane-wave-coupled": 0, "plane-wave-hexagonal": 1}


@pytest.mark.parametrize("name", PLANE_WAVES)
def test_a_plane_wave_comes_back_through_the_interface(name: str, tmp_path: Path) -> None:
    """After 144 microseconds the reflected pulse is back in the grid with its initial height."""
    axis, path = PLANE_WAVES[name], tmp_path / "wave.mcap"
    medium = ge.run(f"psakhie-2003/{name}", overrides={"duration": 1.44e-4}, log=path).component
    velocity = medium.get("grid_velocity")[:, axis]
    # A half sine of 83 cells and 0.1 m/s: its corners disperse, its maximum does not.
    assert velocity.min() == pytest.approx(-0.1, rel=0.01)
    # No motion remains behind the pulse or is reflected across.
    assert np.abs(velocity[medium.grid.mesh.nodes[:, axis] < 0.03]).max() < 0.003
    assert np.abs(medium.get("grid_velocity")[:, 1 - axis]).max() < 1e-4
    energy = medium.balances()[0]
    assert abs(energy.residual) < 1e-4 * energy.stored["kinetic_energy"]
    assert ge.verify(path).identical


def test_a_load_on_the_interface_makes_waves_alike_on_both_sides() -> None:
    """Figure 7: the velocities left and right of the load, in the grid and in the automata."""
    medium = ge.run("psakhie-2003/lamb-symmetric", overrides={"duration": 6e-5}).component
    left = medium.get("grid_speed").reshape(81, 81)
    right = medium.get("automata_speed").reshape(81, 81)[:, ::-1]
    difference = np.sqrt(((left - right) ** 2).sum() / (left**2).sum())
    # The load is short, 12 cells of an S wave, and has corners; grid and automata disperse it differently.
    assert 0.0 < difference < 0.2
    below = slice(0, 70)
    assert np.sqrt(((left - right)[below] ** 2).sum() / (left[below] ** 2).sum()) < 0.1


def test_a_load_beside_the_interface_makes_the_waves_of_the_grid_alone() -> None:
    """Figure 8: between the load and the interface, the motion of the grid is the same as without automata."""
    medium = ge.run("psakhie-2003/lamb-asymmetric", overrides={"duration": 6e-5}).component
    step = {"component.step_size": medium.step_size}
    alone = ge.run("psakhie-2003/lamb-grid", overrides={"duration": 6e-5, **step}).component
    ours = medium.get("grid_velocity").reshape(81, 101, 2)[:, :96]
    # Both loads are at column 80, the middle of the uncoupled grid.
    theirs = alone.get("velocity").reshape(81, 161, 2)[:, :96]
    assert np.abs(ours).max() > 0.05
    assert np.sqrt(((ours - theirs) ** 2).sum() / (theirs**2).sum()) < 0.02


def test_a_blow_cracks_the_core_along_its_axis_and_spalls_it_from_below() -> None:
    """The spall starts after the wave has reflected from the free lower side; the axis cracks earlier."""
    medium = ge.run("psakhie-2003/impact-on-a-cracking-core", overrides={"duration": 3e-5}).component
    height = medium.grid.mesh.nodes[:, 1].max()
    ends = medium.reference[medium.drawables()[-1].pairs].mean(axis=1)
    breaks = [(event, *ends[event.index]) for event in medium.events() if event.kind.startswith("automata")]
    above, below = ([one for one in breaks if (one[2] > 0.04) == up] for up in (True, False))
    assert len(above) > 50 and len(below) > 100 and {event.kind for event, _, _ in breaks} == {"automata_tension_break"}
    # A pulse of 10 us at 5164 m/s is 52 mm long; tension grows up to half of this from the lower side at y = 0.
    assert max(abs(x) for _, x, _ in above) < 0.015 and max(y for _, _, y in below) < 0.027
    assert max(abs(x) for _, x, _ in below) > 0.03
    # The middle of the pulse starts at 5 us, takes 23.2 us down, and then returns up to the breaking links.
    first = below[0][0].tick * medium.step_size
    arrival = (height + below[0][2]) / 5164.0
    assert arrival < first < arrival + 1e-5 and above[0][0].tick < below[0][0].tick
    energy = medium.balances()[0]
    # Relative to fracture, friction and plastic work: most work is elastic or has left through the absorbing sides.
    spent = sum(energy.lost.values()) - energy.lost["absorbed_energy"]
    assert abs(energy.residual) < 2e-3 * spent and not medium.cautions()
    assert energy.lost["plastic_work"] > 0.0 and energy.lost["fracture_energy"] > 0.02 * energy.supplied["input_work"]
    assert np.abs(medium.get("momentum_residual")).max() < 1e-12 * np.abs(medium.get("impulse")).max()
