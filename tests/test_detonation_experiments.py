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
    exact = riemann_problem(left, right, gas.gamma).at((tube.centres - 0.5) / tube.time)
    # In the units of the textbook, density and pressure 1 on the left.
    assert np.abs(tube.get("density") - exact[0]).mean() / left.density < 2e-3
    assert np.abs(tube.get("pressure") - exact[2]).mean() / left.pressure < 2e-3
    assert tube.get("gauge_pressure")[0] == pytest.approx(exact[2][280], rel=2e-3)


def test_the_detonation_tube_loads_the_specimen_as_the_paper_says(tmp_path: Path) -> None:
    """On cells twice as long. The peak in the middle of the specimen, then the wave behind, then rest, then the opening."""
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
    # The spark is as if the front had started a little earlier; 30 us after it has passed.
    later = time > passed[1] + 3e-5
    exact = wave.at(np.full(int(later.sum()), 1.825), time[later])[2]
    outgoing = time[later] < 1e-3
    np.testing.assert_allclose(history[later][outgoing], exact[outgoing], rtol=0.05)
