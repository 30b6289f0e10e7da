"""Rerun scenes: what arrives in the file, live viewers that change nothing, servers on 127.0.0.1 only."""

import ctypes.util
import socket
import sys

import numpy as np
import pytest

from granular_env.components.catalogue import make
from granular_env.components.errors import GranularError, GranularWarning, MissingExtraError, ParameterError
from granular_env.recording import open_log, record
from granular_env.viewing import LiveViewer, save_rrd, screenshot, view, viewer
from granular_env.viewing.footage import from_log
from granular_env.viewing.live import _grown
from granular_env.viewing.scene import scales_of

pytest.importorskip("rerun", reason="the extra `view` is not installed")


@pytest.fixture(scope="module")
def chain_log(tmp_path_factory):
    path = tmp_path_factory.mktemp("logs") / "chain.mcap"
    chain = make("chain", grains=60, left="piston", radius=[3e-3] * 59 + [2e-3])
    names = ["displacement", "velocity", "contact_force", "kinetic_energy", "potential_energy", "input_work", "energy_residual"]
    with record(chain, path, every=2e-6, variables=names, experiment={"name": "piston *bold*", "duration": 1e-4}):
        chain.step(1e-4, left_velocity=5.0)
    return open_log(path)


def columns(path):
    """Entity -> component -> values of each row, and entity -> timelines, of an .rrd file."""
    from rerun.chunk import RrdReader

    found, timelines = {}, {}
    for chunk in RrdReader(path).stream().to_chunks():
        batch = chunk.to_record_batch()
        entity = found.setdefault(str(chunk.entity_path).strip("/"), {})
        timelines.setdefault(str(chunk.entity_path).strip("/"), set()).update(chunk.timeline_names)
        for name in batch.schema.names:
            entity.setdefault(name.rpartition(":")[2], []).extend(batch.column(name).to_pylist())
    return found, timelines


def test_a_saved_scene_holds_grains_of_true_size_stretched_by_the_stated_factor(chain_log, tmp_path):
    from rerun.chunk import RrdReader

    path = save_rrd(chain_log, tmp_path / "scene.rrd")
    motion = from_log(chain_log).motion
    factor = scales_of(motion).exaggeration
    found, timelines = columns(path)
    grains = found[f"scene/grains_displacement_x{factor:g}"]
    radii = next(row for row in grains["radii"] if row is not None)
    np.testing.assert_array_equal(np.float32(radii), np.float32(motion.radius))
    drawn = np.array([row for row in grains["positions"] if row is not None])
    assert drawn.shape == (len(motion.times), 60, 3)
    # Single precision of positions up to .4 m.
    np.testing.assert_allclose(drawn, motion.reference + factor * motion.displacement, atol=1e-7)
    assert {"time", "tick"} <= timelines[f"scene/grains_displacement_x{factor:g}"]
    assert len(RrdReader(path).blueprints()) == 1


def test_a_saved_scene_has_all_its_parts_and_says_what_they_are(chain_log, tmp_path):
    found, _ = columns(save_rrd(chain_log, tmp_path / "scene.rrd"))
    assert {
        "caption", "scene/profile", "scene/contacts", "closeup/grains", "closeup/grain_numbers", "eyes/whole", "eyes/closeup",
        "space_time/picture", "space_time/now", "energy/kinetic_energy", "energy_residual/energy_residual",
        "inputs/left_velocity",
    } <= set(found)  # fmt: skip
    words = next(row for row in found["caption"]["text"] if row is not None)[0]
    factor = scales_of(from_log(chain_log).motion).exaggeration
    assert f"drawn {factor:g} x larger" in words and "m/s" in words and "radius 2 to 3 mm" in words
    assert r"piston \*bold\*" in words


def test_every_frame_of_the_force_bars_has_one_for_each_contact(chain_log, tmp_path):
    found, _ = columns(save_rrd(chain_log, tmp_path / "scene.rrd"))
    strips = [row for row in found["scene/contacts"]["strips"] if row is not None]
    assert [len(row) for row in strips] == [59] * len(chain_log.times("velocity"))


def test_a_given_exaggeration_is_taken_and_a_wrong_one_refused(chain_log, tmp_path):
    found, _ = columns(save_rrd(chain_log, tmp_path / "scene.rrd", exaggerate=7.0))
    assert "scene/grains_displacement_x7" in found
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


def test_without_a_screen_the_other_ways_are_named(chain_log, monkeypatch):
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(GranularError, match="web=True.*save_rrd.*screenshot"):
        view(chain_log)


def test_an_instant_outside_the_log_is_refused(chain_log, tmp_path):
    with pytest.raises(ParameterError, match="at: got 1 s"):
        screenshot(chain_log, tmp_path / "picture.png", at=1.0)


# -- live -----------------------------------------------------------------------------------------------------------------


def test_a_live_viewer_changes_no_bit_and_sends_frames(tmp_path):
    plain, seen = (make("chain", grains=60, left="piston") for _ in range(2))
    with LiveViewer(seen, save=tmp_path / "live.rrd") as live:
        for chain in (plain, seen):
            chain.step(1e-4, left_velocity=5.0)
    assert plain.save().to_bytes() == seen.save().to_bytes()
    found, _ = columns(tmp_path / "live.rrd")
    drawn = [row for row in found["scene/grains"]["positions"] if row is not None]
    assert live.frames == len(drawn) >= 2 and {len(row) for row in drawn} == {60}
    assert "caption" in found and "inputs/left_velocity" in found


def test_live_histories_are_laid_end_to_end(tmp_path):
    oscillator = make("oscillator")
    with LiveViewer(oscillator, save=tmp_path / "live.rrd"):
        oscillator.step(1.0)
        oscillator.reset(position=1.0)
        oscillator.step(0.5)
    found, _ = columns(tmp_path / "live.rrd")
    assert max(found["outputs/position"]["tick"]) == 150


def test_live_scales_only_grow_to_hold_what_comes(chain_log):
    motion = from_log(chain_log).motion
    scales = _grown(scales_of(motion), motion, None)
    assert scales == scales_of(motion)
    louder = type(motion)(
        **{name: getattr(motion, name) for name in motion.__dataclass_fields__} | {"colour": 3.0 * motion.colour}
    )
    assert _grown(scales, louder, None).colour_limit > 2.5 * scales.colour_limit


def test_a_viewer_that_fails_does_not_stop_the_run(tmp_path, monkeypatch):
    from granular_env.viewing import live

    oscillator = make("oscillator")
    watching = LiveViewer(oscillator, save=tmp_path / "live.rrd")

    def broken(*_):
        raise RuntimeError("gone")

    monkeypatch.setattr(live, "send_curves", broken)
    with pytest.warns(GranularWarning, match="gone"):
        watching.close()
    oscillator.step(1.0)
    assert oscillator.tick == 100


# -- processes ------------------------------------------------------------------------------------------------------------


def test_the_web_viewer_listens_on_this_machine_only(chain_log, tmp_path, capfd):
    file = save_rrd(chain_log, tmp_path / "scene.rrd")
    with viewer._web_viewer(file) as process:
        assert process.poll() is None
        printed = capfd.readouterr().out
        port = int(printed.partition("http://127.0.0.1:")[2].partition("/")[0])
        with socket.create_connection(("127.0.0.1", port), timeout=5.0) as page:
            page.sendall(b"GET / HTTP/1.0\r\nHost: 127.0.0.1\r\n\r\n")
            assert b"200" in page.recv(64)
        # Every 127.x address is this machine; a server on all interfaces would answer here, one on 127.0.0.1 does not.
        with pytest.raises(OSError), socket.create_connection(("127.0.0.2", port), timeout=5.0):
            pass
    assert process.poll() is not None


@pytest.mark.skipif(
    not all(ctypes.util.find_library(name) for name in ("vulkan", "EGL", "xkbcommon-x11")),
    reason=f"headless rerun needs the system packages {' '.join(viewer.HEADLESS_PACKAGES)}",
)
def test_a_screenshot_is_taken_without_a_screen(chain_log, tmp_path):
    from matplotlib.image import imread

    picture = imread(screenshot(chain_log, tmp_path / "scene.png", size=(800, 600)))
    assert picture.shape[:2] == (600, 800) and len(np.unique(picture.reshape(-1, picture.shape[2]), axis=0)) > 100


def test_a_viewer_that_does_not_start_names_the_packages_it_needs(chain_log, tmp_path, monkeypatch):
    monkeypatch.setattr(viewer, "rerun_program", lambda: "/bin/false")
    with pytest.raises(GranularError, match="mesa-vulkan-drivers.*apt-get"):
        screenshot(chain_log, tmp_path / "picture.png")
