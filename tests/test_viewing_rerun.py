"""Rerun scenes: contents of the file, live viewers without side effects, servers only on 127.0.0.1."""

import dataclasses
import subprocess
import sys

import numpy as np
import pytest
from support.rerun_tools import read_columns

from granular_env.components.catalogue import make
from granular_env.components.errors import GranularError, ParameterError
from granular_env.recording import open_log, record
from granular_env.viewing import save_rrd, screenshot, view
from granular_env.viewing.rerun.blueprint import make_blueprint
from granular_env.viewing.scene_builder import load_scene
from granular_env.viewing.scene_scales import make_scales

pytest.importorskip("rerun", reason="the extra `view` is not installed")


@pytest.fixture(scope="module")
def chain_log(tmp_path_factory):
    path = tmp_path_factory.mktemp("logs") / "chain.mcap"
    chain = make("chain", grains=60, left="piston", radius=[3e-3] * 59 + [2e-3])
    names = ["displacement", "velocity", "contact_force", "kinetic_energy", "potential_energy", "input_work", "energy_residual"]
    with record(chain, path, every=2e-6, variables=names, experiment={"name": "piston *bold*", "duration": 1e-4}):
        chain.step(1e-4, left_velocity=5.0)
    return open_log(path)


def test_a_saved_scene_holds_grains_of_true_size_stretched_by_the_stated_factor(chain_log, tmp_path):
    from rerun.chunk import RrdReader

    path = save_rrd(chain_log, tmp_path / "scene.rrd")
    scene_data = load_scene(chain_log)
    motion, factor = scene_data.motion, make_scales(scene_data).exaggeration
    found, timelines = read_columns(path)
    grains = found["scene/particles_grains"]
    radii = next(row for row in grains["radii"] if row is not None)
    np.testing.assert_array_equal(np.float32(radii), np.float32(motion.radius))
    drawn = np.array([row for row in grains["positions"] if row is not None])
    assert drawn.shape == (len(motion.times), 60, 3)
    # Single precision for positions up to 0.4 m.
    np.testing.assert_allclose(drawn, motion.reference + factor * motion.displacement, atol=1e-7)
    assert {"time", "tick"} <= timelines["scene/particles_grains"]
    assert len(RrdReader(path).blueprints()) == 1


def test_a_saved_scene_has_all_its_parts_and_says_what_they_are(chain_log, tmp_path):
    found, _ = read_columns(save_rrd(chain_log, tmp_path / "scene.rrd"))
    assert {
        "caption", "scene/profile", "scene/contacts", "closeup/grains", "closeup/grain_numbers",
        "cameras/whole", "cameras/closeup",
        "space_time/picture", "space_time/now", "energy/kinetic_energy", "energy_residual/energy_residual",
        "inputs/left_velocity",
    } <= set(found)  # fmt: skip
    words = next(row for row in found["caption"]["text"] if row is not None)[0]
    factor = make_scales(load_scene(chain_log)).exaggeration
    assert f"drawn {factor:g} x larger" in words and "m/s" in words and "radius 2 to 3 mm" in words
    assert r"piston \*bold\*" in words


def test_fields_along_a_line_are_curves_in_panes_of_their_own(tmp_path):
    tube = make("detonation", length=0.4, cells=40, regions=[{"x": [0.0, 0.05], "pressure": 3e6}])
    with record(tube, tmp_path / "x.mcap", every=1e-5):
        tube.step(round(1e-4 / tube.step_size) * tube.step_size)
    with open_log(tmp_path / "x.mcap") as log:
        scene_data = load_scene(log)
        pressure = scene_data.profiles[0]
        found, _ = read_columns(save_rrd(log, tmp_path / "scene.rrd"))
    curves = np.array([row[0] for row in found["profiles/pressure/curve"]["strips"] if row is not None])
    assert curves.shape == (len(pressure.times), 40, 2)
    # Evenly spaced horizontally; pixel rows count downwards; the values are those of the log on one scale from 0.
    np.testing.assert_allclose(np.ptp(np.diff(curves[0, :, 0])), 0.0, atol=1e-3)
    top = pressure.values.max() * 1.05
    np.testing.assert_allclose(curves[..., 1], 120.0 * (1.0 - pressure.values / top), atol=1e-3)
    words = next(row for row in found["caption"]["text"] if row is not None)[0]
    assert "Curves along x:** pressure, velocity, temperature, progress" in words
    # Several panes share a grid; a single pane gets the full width, which a grid would not give.
    for count, kind in ((4, "Grid"), (1, "Spatial2DView")):
        layout = make_blueprint(dataclasses.replace(scene_data, profiles=scene_data.profiles[:count]), None, None, 1e-4)
        assert type(layout.root_container.contents[0]).__name__ == kind


def test_a_given_exaggeration_is_taken_and_a_wrong_one_refused(chain_log, tmp_path):
    found, _ = read_columns(save_rrd(chain_log, tmp_path / "scene.rrd", exaggerate=7.0))
    assert "drawn 7 x larger" in next(row for row in found["caption"]["text"] if row is not None)[0]
    with pytest.raises(ParameterError, match="exaggerate"):
        save_rrd(chain_log, tmp_path / "other.rrd", exaggerate=-1.0)
    assert not list(tmp_path.glob("*other*"))


def test_a_jump_of_an_input_is_drawn_as_a_jump(tmp_path):
    oscillator = make("oscillator")
    with record(oscillator, tmp_path / "log.mcap"):
        oscillator.step(0.1, force=0.0)
        oscillator.step(0.1, force=1.0)
    found, _ = read_columns(save_rrd(open_log(tmp_path / "log.mcap"), tmp_path / "scene.rrd"))
    times = [time.value for time in found["inputs/force"]["time"]]  # ns
    course = dict(zip(times, found["inputs/force"]["scalars"], strict=True))
    assert course == {0: [0.0], 99_999_999: [0.0], 100_000_000: [1.0], 200_000_000: [1.0]}
    assert found["inputs/force"]["tick"] == [0, 9, 10, 20]


def test_no_peak_of_an_input_of_many_steps_is_lost(tmp_path):
    """Fifty single steps of different heights among ten thousand oscillating values keep their heights."""
    oscillator = make("oscillator")
    peaks = {200 * number + 57: 2.0 + 0.01 * number for number in range(50)}
    with record(oscillator, tmp_path / "log.mcap", every=10.0):
        for number in range(10_000):
            oscillator.step(0.01, force=peaks.get(number, float(number % 2)))
    with open_log(tmp_path / "log.mcap") as log:
        curve = load_scene(log).inputs["force"]
    assert len(curve.values) <= 4000
    assert set(peaks.values()) <= set(curve.values)
    # Between the peaks the band from 0 to 1 N is filled: each hundredth of the run contains both values.
    for part in np.array_split(curve.values, 100):
        assert {0.0, 1.0} <= set(part)


WITHOUT_RERUN = """
import sys
sys.modules["rerun"] = None
import granular_env as ge
try:
    getattr(ge.viewing, sys.argv[1])
except ge.GranularError as error:
    print(type(error).__name__, error)
"""


@pytest.mark.parametrize("function", ["save_rrd", "view", "screenshot", "LiveViewer"])
def test_missing_rerun_says_what_to_install(function):
    command = [sys.executable, "-c", WITHOUT_RERUN, function]
    told = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert told.startswith("MissingExtraError") and "rerun-sdk" in told and "pip install" in told


def test_without_a_screen_the_other_ways_are_named(chain_log, monkeypatch):
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(GranularError, match="web=True.*save_rrd.*screenshot"):
        view(chain_log)


def test_an_instant_outside_the_log_is_refused(chain_log, tmp_path):
    with pytest.raises(ParameterError, match="at: got 1 s"):
        screenshot(chain_log, tmp_path / "picture.png", at=1.0)
