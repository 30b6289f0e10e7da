"""Inputs in viewers, reports and plots: numbers, and arrays with few and with many elements."""

from pathlib import Path

import numpy as np
import pytest

import granular_env as ge
from granular_env.components.inputs import input_value
from granular_env.recording import Log, open_log, record
from granular_env.viewing import report
from granular_env.viewing.curves import MOST_CURVES, load_input_curves
from granular_env.viewing.rerun.caption import make_caption
from granular_env.viewing.scene_builder import load_scene, make_scene
from granular_env.viewing.scene_data import SceneData

COLUMNS = 12


@pytest.fixture(scope="module")
def broken_row(tmp_path_factory: pytest.TempPathFactory) -> Log:
    """Return the log of the shipped row with half-sine forces at both ends."""
    path = tmp_path_factory.mktemp("inputs") / "row.mcap"
    ge.run("discs/broken-row", log=path)
    return open_log(path)


def _pushed(path: Path, *forces: object) -> Log:
    """Return the log of a row of discs with successive inputs held for ten ticks each."""
    discs = ge.make("discs", rows=1, columns=COLUMNS)
    with record(discs, path, every=discs.step_size):
        for force in forces:
            discs.step(10 * discs.step_size, force=force)
    return open_log(path)


def _words(scene_data: SceneData) -> str:
    return make_caption(scene_data, None, None)


def test_elements_that_act_have_curves_and_the_others_none(broken_row: Log) -> None:
    curves = load_scene(broken_row).inputs
    assert list(curves) == ["force[0,0]", "force[9,0]"]
    assert curves["force[9,0]"].unit == "N"
    assert curves["force[9,0]"].values.max() == pytest.approx(1.5) == -curves["force[0,0]"].values.min()
    assert "No input acts" not in _words(load_scene(broken_row))


def test_a_report_shows_an_array_that_acts(broken_row: Log, tmp_path: Path) -> None:
    page = Path(report(broken_row, tmp_path)).read_text(encoding="utf-8")
    assert ">Inputs<" in page and "2 of 20 elements act; elements that stay 0 are omitted" in page


def test_many_elements_are_drawn_by_their_extremes(tmp_path: Path) -> None:
    force = np.random.default_rng(1).uniform(-1.0, 1.0, (COLUMNS, 2))
    assert force.size > MOST_CURVES
    log = _pushed(tmp_path / "a.mcap", force, -force, ge.Profile.half_sine(1.0, 1e-4) * force)
    found = load_input_curves(log, "force")
    assert found is not None and found.is_summary and found.acting == force.size
    for curve in found.curves:
        part = force[:, 0 if "force_x" in curve.name else 1]
        bound = max(part.max(), -part.min()) if "largest" in curve.name else min(part.min(), -part.max())
        extreme = curve.values.max() if "largest" in curve.name else curve.values.min()
        assert extreme == bound, curve.name
    values = np.array([input_value(one.value, tick) for one in log.input_intervals("force") for tick in one.sample_ticks()])
    largest = next(curve for curve in found.curves if curve.name == "force_x, largest")
    np.testing.assert_array_equal(largest.values, values[-len(largest.values) :, :, 0].max(axis=1))


@pytest.mark.parametrize("kind", ["space-time", "profiles", "histories"])
def test_an_array_input_can_be_plotted(broken_row: Log, kind: str) -> None:
    figure = ge.viewing.plot(broken_row, "force", kind)
    assert figure.get_axes()
    with pytest.raises(ge.ParameterError, match="'forse' was not recorded.*force"):
        ge.viewing.plot(broken_row, "forse")


def test_a_running_component_has_its_inputs_too() -> None:
    discs = ge.make("discs", rows=1, columns=2)
    discs.step(discs.step_size, force=[[0.0, 0.0], [0.5, 0.0]])
    inputs = make_scene(discs).inputs
    assert list(inputs) == ["force[0,0]", "force[0,1]", "force[1,0]", "force[1,1]"]
    assert inputs["force[1,0]"].values.tolist() == [0.5]
