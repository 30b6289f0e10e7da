"""Rerun scenes: what arrives in the file, live viewers that change nothing, servers on 127.0.0.1 only."""

import dataclasses
import sys

import numpy as np
import pytest
from support.rerun_tools import columns

from granular_env.components.catalogue import make
from granular_env.components.errors import GranularError, MissingExtraError, ParameterError
from granular_env.recording import open_log, record
from granular_env.viewing import LiveViewer, report, save_rrd, screenshot, view
from granular_env.viewing.rerun import viewer
from granular_env.viewing.rerun.blueprint import blueprint
from granular_env.viewing.rerun.entity_paths import entity
from granular_env.viewing.scene_builder import from_log
from granular_env.viewing.scene_scales import scales_of

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
    scene_data = from_log(chain_log)
    motion, factor = scene_data.motion, scales_of(scene_data).exaggeration
    found, timelines = columns(path)
    grains = found[f"scene/particles_displacement_x{factor:g}"]
    radii = next(row for row in grains["radii"] if row is not None)
    np.testing.assert_array_equal(np.float32(radii), np.float32(motion.radius))
    drawn = np.array([row for row in grains["positions"] if row is not None])
    assert drawn.shape == (len(motion.times), 60, 3)
    # Single precision of positions up to 0.4 m.
    np.testing.assert_allclose(drawn, motion.reference + factor * motion.displacement, atol=1e-7)
    assert {"time", "tick"} <= timelines[f"scene/particles_displacement_x{factor:g}"]
    assert len(RrdReader(path).blueprints()) == 1


def test_a_saved_scene_has_all_its_parts_and_says_what_they_are(chain_log, tmp_path):
    found, _ = columns(save_rrd(chain_log, tmp_path / "scene.rrd"))
    assert {
        "caption", "scene/profile", "scene/contacts", "closeup/grains", "closeup/grain_numbers",
        "cameras/whole", "cameras/closeup",
        "space_time/picture", "space_time/now", "energy/kinetic_energy", "energy_residual/energy_residual",
        "inputs/left_velocity",
    } <= set(found)  # fmt: skip
    words = next(row for row in found["caption"]["text"] if row is not None)[0]
    factor = scales_of(from_log(chain_log)).exaggeration
    assert f"drawn {factor:g} x larger" in words and "m/s" in words and "radius 2 to 3 mm" in words
    assert r"piston \*bold\*" in words


def test_fields_along_a_line_are_curves_in_panes_of_their_own(tmp_path):
    tube = make("detonation", length=0.4, cells=40, regions=[{"x": [0.0, 0.05], "pressure": 3e6}])
    with record(tube, tmp_path / "x.mcap", every=1e-5):
        tube.step(round(1e-4 / tube.step_size) * tube.step_size)
    with open_log(tmp_path / "x.mcap") as log:
        scene_data = from_log(log)
        pressure = scene_data.profiles[0]
        found, _ = columns(save_rrd(log, tmp_path / "scene.rrd"))
    curves = np.array([row[0] for row in found["profiles/pressure/curve"]["strips"] if row is not None])
    assert curves.shape == (len(pressure.times), 40, 2)
    # Evenly spaced across; up is less, and the values are those of the log, on one scale that begins at 0.
    np.testing.assert_allclose(np.ptp(np.diff(curves[0, :, 0])), 0.0, atol=1e-3)
    top = pressure.values.max() * 1.05
    np.testing.assert_allclose(curves[..., 1], 120.0 * (1.0 - pressure.values / top), atol=1e-3)
    words = next(row for row in found["caption"]["text"] if row is not None)[0]
    assert "Curves along x:** pressure, velocity, temperature, progress" in words
    # Several share a grid; a single one has the whole width, which a grid of one pane would not give it.
    for count, kind in ((4, "Grid"), (1, "Spatial2DView")):
        layout = blueprint(dataclasses.replace(scene_data, profiles=scene_data.profiles[:count]), None, None, 1e-4)
        assert type(layout.root_container.contents[0]).__name__ == kind


def test_names_that_authors_choose_are_one_part_of_a_path():
    assert entity("scene/links_", "links of a/b") == r"scene/links_links\ of\ a\/b"


def test_every_frame_of_the_force_bars_has_one_for_each_contact(chain_log, tmp_path):
    found, _ = columns(save_rrd(chain_log, tmp_path / "scene.rrd"))
    strips = [row for row in found["scene/contacts"]["strips"] if row is not None]
    assert [len(row) for row in strips] == [59] * len(chain_log.times("velocity"))


def test_a_given_exaggeration_is_taken_and_a_wrong_one_refused(chain_log, tmp_path):
    found, _ = columns(save_rrd(chain_log, tmp_path / "scene.rrd", exaggerate=7.0))
    assert "scene/particles_displacement_x7" in found
    with pytest.raises(ParameterError, match="exaggerate"):
        save_rrd(chain_log, tmp_path / "other.rrd", exaggerate=-1.0)
    assert not list(tmp_path.glob("*other*"))


def test_a_jump_of_an_input_is_drawn_as_a_jump(tmp_path):
    oscillator = make("oscillator")
    with record(oscillator, tmp_path / "log.mcap"):
        oscillator.step(0.1, force=0.0)
        oscillator.step(0.1, force=1.0)
    found, _ = columns(save_rrd(open_log(tmp_path / "log.mcap"), tmp_path / "scene.rrd"))
    times = [time.value for time in found["inputs/force"]["time"]]  # ns
    course = dict(zip(times, found["inputs/force"]["scalars"], strict=True))
    assert course == {0: [0.0], 99_999_999: [0.0], 100_000_000: [1.0], 200_000_000: [1.0]}
    assert found["inputs/force"]["tick"] == [0, 9, 10, 20]


def test_no_peak_of_an_input_of_many_steps_is_lost(tmp_path):
    """Fifty single steps of different heights, among ten thousand that go up and down, arrive with their heights."""
    oscillator = make("oscillator")
    peaks = {200 * number + 57: 2.0 + 0.01 * number for number in range(50)}
    with record(oscillator, tmp_path / "log.mcap", every=10.0):
        for number in range(10_000):
            oscillator.step(0.01, force=peaks.get(number, float(number % 2)))
    with open_log(tmp_path / "log.mcap") as log:
        curve = from_log(log).inputs["force"]
    assert len(curve.values) <= 4000
    assert set(peaks.values()) <= set(curve.values)
    # Between the peaks the band from 0 to 1 N is filled: both are touched in each hundredth of the run.
    for part in np.array_split(curve.values, 100):
        assert {0.0, 1.0} <= set(part)


def test_series_are_drawn_point_by_point(chain_log, tmp_path):
    """Rerun would draw the mean of the points that fall on one pixel: stairs as ramps, peaks too low."""
    import rerun as rr

    found, _ = columns(save_rrd(chain_log, tmp_path / "scene.rrd"))
    for path in ("inputs/left_velocity", "energy/kinetic_energy"):
        policies = [row for row in found[path]["aggregation_policy"] if row is not None]
        assert policies == [[rr.components.AggregationPolicy.Off.value]]


def test_a_live_run_is_not_written_over_a_folder(tmp_path):
    with pytest.raises(ParameterError, match="is a folder"):
        LiveViewer(make("oscillator"), save=tmp_path)


def test_a_log_whose_name_is_no_text_is_saved_too(chain_log, tmp_path):
    odd = tmp_path / "chain\udcff.mcap"
    odd.write_bytes(chain_log.path.read_bytes())
    with open_log(odd) as log:
        assert save_rrd(log, tmp_path / "scene.rrd").stat().st_size > 1000


def test_a_path_that_cannot_be_written_is_named(chain_log, tmp_path):
    (tmp_path / "taken").write_text("a file, no folder")
    with pytest.raises(GranularError, match=r"taken/scene\.rrd' cannot be written"):
        save_rrd(chain_log, tmp_path / "taken" / "scene.rrd")


@pytest.mark.parametrize(
    "call", [lambda log, path: save_rrd(log, path), lambda log, path: view(log), lambda log, path: screenshot(log, path)]
)
def test_missing_rerun_says_what_to_install(chain_log, tmp_path, monkeypatch, call):
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(MissingExtraError, match=r"rerun-sdk.*pip install"):
        call(chain_log, tmp_path / "file")


WRONG_PATHS = {
    "a name too long": "x" * 300,
    "a file for a folder": "taken/scene",
    "a long name in a new folder": f"new/{'x' * 300}",
}


@pytest.mark.parametrize("name", WRONG_PATHS.values(), ids=WRONG_PATHS)
@pytest.mark.parametrize("suffix", [".rrd", ".png", ""], ids=["save", "screenshot", "report"])
def test_a_path_that_cannot_be_written_is_told_before_any_work(chain_log, tmp_path, monkeypatch, name, suffix):
    from granular_env.viewing.reports import figures as report_figures

    def work(*_, **__):
        raise AssertionError("the path was not looked at first")

    for module in (viewer, report_figures):
        monkeypatch.setattr(module, "from_log", work)
    monkeypatch.setattr(viewer, "RerunProcess", work)
    (tmp_path / "taken").write_text("a file, no folder")
    call = {".rrd": save_rrd, ".png": screenshot, "": report}[suffix]
    with pytest.raises(GranularError, match="cannot be written: (File name too long|Not a directory)|is a file, expected"):
        call(chain_log, tmp_path / f"{name}{suffix}")
    assert [entry.name for entry in tmp_path.iterdir()] == ["taken"]


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"path": None}, "path: got None"),
        ({"path": 3}, "path: got 3"),
        ({"log": "a.mcap"}, "log: got str, expected an open log"),
        ({"exaggerate": "2"}, "exaggerate: got '2'"),
        ({"at": "1"}, "at: got '1'"),
        ({"at": [1.0]}, "at: got"),
        ({"size": 800}, "size: got 800"),
        ({"size": (0, 600)}, "size: got"),
    ],
    ids=str,
)
def test_values_of_a_wrong_type_are_told(chain_log, tmp_path, arguments, word):
    given = {"log": chain_log, "path": tmp_path / "picture", **arguments}
    log, path = given.pop("log"), given.pop("path")
    for call, suffix in ((save_rrd, ".rrd"), (screenshot, ".png")):
        if call is save_rrd and {"at", "size"} & set(given):
            continue
        named = path.with_suffix(suffix) if hasattr(path, "with_suffix") else path
        with pytest.raises(ParameterError, match=word):
            call(log, named, **given)


def test_without_a_screen_the_other_ways_are_named(chain_log, monkeypatch):
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(GranularError, match="web=True.*save_rrd.*screenshot"):
        view(chain_log)


def test_an_instant_outside_the_log_is_refused(chain_log, tmp_path):
    with pytest.raises(ParameterError, match="at: got 1 s"):
        screenshot(chain_log, tmp_path / "picture.png", at=1.0)


def test_the_end_as_people_write_it_is_in_the_log(chain_log):
    assert viewer._instant(chain_log, 1e-4 * (1.0 + 1e-12)) == pytest.approx(chain_log.duration)
    assert viewer._instant(chain_log, None) == pytest.approx(2e-4 / 3.0)
