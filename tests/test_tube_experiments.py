"""The shipped experiments with gas and shell, with coarser node spacing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import granular_env as ge
from granular_env.components.shell.theory import critical_speed, front_amplification
from granular_env.viewing.figures.plane import load_plane
from granular_env.viewing.scene_builder import load_scene

COARSE = {"component.gas.cells": 355, "component.shell.body.along": 62, "component.shell.body.around": 13}
MEAN, WALL = 0.020195, 0.00089
# 8 cm with the notch in the middle, close to the closed end.
NOTCHED: dict[str, Any] = {
    "component.gas.length": 0.3, "component.gas.cells": 150, "component.gas.gauges": [0.1], "component.position": 0.06,
    "component.shell.body.length": 0.08, "component.shell.body.along": 27, "component.shell.body.around": 28,
}  # fmt: skip
LENGTHS = {1: 0.0254, 2: 0.0508, 3: 0.0762}


def test_the_whole_tube_loads_its_wall_and_its_log_replays(tmp_path: Path) -> None:
    """Run until the front is 10 cm into the section; the spark needs 8 us to ignite the gas."""
    path = tmp_path / "tube.mcap"
    ge.run("gato-shie-2010/whole-tube-coarse", log=path, overrides={**COARSE, "duration": 6.9e-4})
    log = ge.open_log(path)
    time, front = log.series("gas_right_front")
    arrival = float(np.interp(1.52, front[front > 0.5], time[front > 0.5]))
    assert arrival == pytest.approx(1.52 / 2374.0 + 8e-6, rel=0.01)
    _, radial = log.series("radial_displacement")
    assert not radial[time < arrival - 5e-6].any()
    _, pressure = log.series("shell_pressure")
    assert pressure.max() == pytest.approx(3.4e6, rel=0.1)
    static = (pressure.max() - 1e5) * 0.01975 * MEAN / (69e9 * WALL)
    # The front is three times as fast as the resonant waves.
    assert radial.max() / static == pytest.approx(front_amplification(2374.0 / 827.0), rel=0.1)
    assert ge.verify(path).identical


def test_a_notch_tears_and_a_branch_of_the_log_tears_on_in_the_same_way(tmp_path: Path) -> None:
    path = tmp_path / "notch.mcap"
    drawn = ["shell_surface_displacement", "shell_surface_stress", "shell_surface_cells"]
    recorded = {"record.variables": ["shell_crack_length", *drawn], "duration": 6.6e-5}
    tube = ge.run("gato-shie-2010/notch-1-inch", log=path, overrides={**NOTCHED, **recorded}).component
    first = tube.events("shell_point_parted")[0]
    assert first.tick * tube.step_size == pytest.approx(0.1 / 2374.0 + 8e-6, abs=3e-6)
    assert tube.report()["shell: along the body, m"] == pytest.approx(0.04, abs=0.5 * LENGTHS[1])
    assert 0.01 < tube.get("shell_crack_length") < 0.1
    assert tube.get("leaked_mass") > 0.0
    assert abs(tube.get("exchange_difference")) < 1e-12 * tube.balances()[0].supplied["pressure_work"]
    middle = 5.2e-5
    log = ge.open_log(path)
    time, crack = log.series("shell_crack_length")
    assert 0.0 < np.interp(middle, time, crack) < 0.7 * crack[-1]
    # The pictures of a report show the tearing, not the first event (ignition).
    shown = load_plane(log, load_scene(log))
    assert shown is not None and tube.events()[0].kind == "gas_ignited"
    assert np.abs(shown.times - first.tick * tube.step_size).min() <= 2.0 * np.diff(time).max()
    branch = log.branch(middle).component
    branch.step(tube.time - branch.time)
    assert branch.save().to_bytes() == tube.save().to_bytes()


@pytest.mark.slow
@pytest.mark.parametrize("inches", LENGTHS)
def test_the_papers_notches_tear_farther_the_higher_the_tube_was_filled(inches: int) -> None:
    cracks = []
    for pressure in (1e5, 1.4e5, 1.8e5):
        changes = {
            **NOTCHED, "component.shell.body.length": 0.12, "component.shell.body.along": 41,
            "component.shell.body.around": 28, "duration": 1e-4, "component.gas.initial_pressure": pressure,
        }  # fmt: skip
        tube: Any = ge.run(f"gato-shie-2010/notch-{inches}-inch", overrides=changes).component
        first, assembly = tube.events("shell_point_parted")[0], tube.shell.assembly
        along = float(assembly.lattice.axes[0].coordinates(assembly.points.indices(np.array([first.index]))[0, 0]))
        assert abs(along - 0.06) < 0.5 * LENGTHS[inches] + 0.005
        assert abs(tube.get("exchange_difference")) < 1e-12 * tube.balances()[0].supplied["pressure_work"]
        energy, _, mass = tube.balances()
        assert abs(energy.residual) < 1e-3 * energy.supplied["pressure_work"]
        assert abs(mass.residual) < 1e-14
        cracks.append(tube.get("shell_crack_length"))
    # Cracks through the whole piece have equal lengths to within a thousandth.
    assert LENGTHS[inches] < cracks[0] < 1.001 * cracks[1] < 1.001**2 * cracks[2] and cracks[0] < cracks[2]


@pytest.mark.slow
def test_flexural_waves_pile_up_at_a_front_of_their_speed() -> None:
    """The deflection of the wall is larger than at any other speed, and grows with the path of the front."""
    overrides = {"component.shell.body.around": 17, "duration": 1e-6}
    amplified = []
    for heat, duration in ((5.4e5, 5.4e-4), (1.084e6, 3.6e-4), (2.36e6, 2.6e-4)):
        changes = {**overrides, "component.gas.gas.heat_release": heat}
        tube: Any = ge.run("gato-shie-2010/travelling-load", overrides=changes).component
        peak = np.zeros(134)
        while tube.time < duration:
            tube.step(1e-6)
            peak = np.maximum(peak, tube.get("radial_displacement"))
        static = (tube.get("peak_pressure") - 1e5) * 0.01975 * MEAN / (69e9 * WALL)
        amplified.append((tube.gas.front.speed, peak / static))
    slow, critical, fast = (values for _, values in amplified)
    limits = [front_amplification(speed / critical_speed(69e9, 0.33, 2719.0, MEAN, WALL)) for speed, _ in amplified]
    assert slow[60:120].mean() == pytest.approx(limits[0], rel=0.06)
    assert fast[60:120].mean() == pytest.approx(limits[2], rel=0.06)
    assert critical[100:120].mean() > 1.2 * fast[60:120].max()
    assert critical[100:120].mean() > 1.15 * critical[20:30].mean()


def test_the_experiment_of_the_papers_size_records_the_outcome(tmp_path: Path) -> None:
    """A short piece with coarse nodes, close to the closed end."""
    path = tmp_path / "log.mcap"
    coarse = {**NOTCHED, "component.gas.gauges": [], "component.shell.gauges": [], "component.shell.body.around": 14}
    ge.run("gato-shie-2010/notch-1-inch-fine", log=path, overrides={**coarse, "duration": 7e-5})
    log = ge.open_log(path)
    ends = {one: log.series(f"shell_{one}")[1][-1] for one in ("outcome", "crack_along", "crack_around", "pieces")}
    assert ends["outcome"] >= 2.0 and ends["crack_along"] > 0.005 and ends["pieces"] >= 1.0
