"""The shipped experiments on the gas, against theory."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import granular_env as ge
from granular_env.components.detonation.theory import Flow, TaylorWave, riemann_problem


def test_the_shock_tube_is_that_of_sod() -> None:
    tube: Any = ge.run("gato-shie-2010/shock-tube").component
    gas, left = tube.gas, Flow(tube.ahead.density, 0.0, 1e6)
    right = Flow(left.density / 8.0, 0.0, 1e5)
    exact = riemann_problem(left, right, gas.gamma).state((tube.centres - 0.5) / tube.time)
    # In the textbook's units, with density and pressure 1 on the left.
    assert np.abs(tube.get("density") - exact[0]).mean() / left.density < 2e-3
    assert np.abs(tube.get("pressure") - exact[2]).mean() / left.pressure < 2e-3
    assert tube.get("gauge_pressure")[0] == pytest.approx(exact[2][280], rel=2e-3)


def test_the_detonation_tube_loads_the_specimen_as_the_paper_says(tmp_path: Path) -> None:
    """With cells twice as long: peak in the middle of the specimen, wave behind it, gas at rest, then the opening."""
    duration = 1.0e-3
    path = tmp_path / "tube.mcap"
    result = ge.run(
        "gato-shie-2010/detonation-tube", log=path,
        overrides={"component.cells": 532, "duration": duration, "record.every": 5e-6, "component.step_size": 5e-7},
    )  # fmt: skip
    tube: Any = result.component
    log = ge.open_log(path)
    kinds = [(event.kind, event.index) for event in tube.events()]
    assert kinds[:3] == [("ignited", 0), ("front_passed", 0), ("front_passed", 1)]
    assert {("diaphragm_opened", 1), ("end_reached", 1)} == set(kinds[3:])
    passed = [event.tick * tube.step_size for event in tube.events()[1:3]]
    assert (1.825 - 0.76) / (passed[1] - passed[0]) == pytest.approx(tube.front.speed, rel=5e-3)
    time, pressure = log.series("gauge_pressure")
    wave = TaylorWave(tube.front, tube.ahead, tube.gas.gamma)
    history = pressure[:, 1]
    assert 0.9 < history.max() / tube.front.burnt.pressure < 1.2
    # The spark acts like a slightly earlier start of the front; evaluate 30 us after the front has passed.
    later = time > passed[1] + 3e-5
    exact = wave.state(np.full(int(later.sum()), 1.825), time[later])[2]
    outgoing = time[later] < 1e-3
    np.testing.assert_allclose(history[later][outgoing], exact[outgoing], rtol=0.05)


def test_the_piston_does_the_work_of_its_pressure(tmp_path: Path) -> None:
    path = tmp_path / "piston.mcap"
    tube: Any = ge.run("gato-shie-2010/piston", log=path, overrides={"component.cells": 200}).component
    assert [(event.kind, event.index) for event in tube.events()] == [("ignited", 0), ("end_reached", 1)]
    log = ge.open_log(path)
    position, pressure = (log.series(name)[1] for name in ("right_position", "right_piston_pressure"))
    assert position[-1] == pytest.approx(0.8 - 300.0 * 3e-4 * 2.0 / np.pi, rel=1e-3)
    work = -float(np.sum(0.5 * (pressure[1:] + pressure[:-1]) * np.diff(position))) * tube.areas[0]
    assert tube.balances()[0].supplied["right_energy"] == pytest.approx(work, rel=0.02)
