"""Live views change no bit, send twenty frames per second of wall time, and mark times that were not sampled."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.rerun_tools import read_columns

from granular_env.cli import main
from granular_env.colours import parse_rgb
from granular_env.components.catalogue import make
from granular_env.components.errors import GranularWarning
from granular_env.domains.chain.viewing.space_time_diagram import GrowingPicture
from granular_env.viewing import LiveViewer
from granular_env.viewing.figures.drawing import NOT_SAMPLED
from granular_env.viewing.rerun import live
from granular_env.viewing.rerun.live import Pace
from granular_env.viewing.scene_builder import make_scene
from granular_env.viewing.scene_scales import enlarge_scales, make_scales

pytest.importorskip("rerun", reason="the extra `view` is not installed")


class Clock:
    """A wall clock that advances only on request."""

    def __init__(self, monkeypatch):
        self.now = 100.0
        monkeypatch.setattr(live, "perf_counter", lambda: self.now)
        monkeypatch.setattr(live, "sleep", self.sleep)

    def sleep(self, seconds):
        assert seconds > 0.0
        self.now += seconds


@pytest.fixture
def clock(monkeypatch):
    return Clock(monkeypatch)


def instants_of_frames(clock, pacing, ticks_per_second, frame_seconds, seconds, stalls=()):
    """Return wall times [s] and ticks of the frames of a run with a given tick rate; frames in `stalls` take 1 s."""
    frames, tick, begin = [], 0, clock.now
    pacing.restart(0)
    upcoming = 1
    while clock.now < begin + seconds:
        clock.now += (upcoming - tick) / ticks_per_second
        tick = upcoming
        pacing.wait_for_pace(tick)
        frames.append((clock.now - begin, tick))
        clock.now += 1.0 if len(frames) in stalls else frame_seconds
        upcoming = pacing.next_frame_tick(tick)
        assert upcoming > tick
    return np.array(frames)


@pytest.mark.parametrize("ticks_per_second", [200.0, 1e3, 2e4, 1e7])
@pytest.mark.parametrize("frame_seconds", [0.0, 0.01, 0.02])
def test_twenty_frames_a_second_are_sent_however_fast_the_run_is(clock, ticks_per_second, frame_seconds):
    frames = instants_of_frames(clock, Pace(), ticks_per_second, frame_seconds, 10.0)
    # Frames are sent up to a tenth early or up to a tick late.
    assert 190 <= len(frames) <= 224
    assert np.diff(frames[5:, 0]).max() < 0.06


def test_large_frames_take_at_most_half_of_the_time(clock):
    frames = instants_of_frames(clock, Pace(), 1e5, 0.2, 20.0)
    # One frame per 0.4 s; the first five come sooner, because the distance between frames grows by a factor of 4.
    assert 45 <= len(frames) <= 55


def test_a_pace_holds_a_run_back_and_spaces_its_frames_evenly(clock):
    frames = instants_of_frames(clock, Pace(1000.0), 1e6, 0.002, 4.0)
    assert len(frames) == pytest.approx(80, abs=1)
    # The first frame is at the first tick.
    assert frames[0, 1] == 1.0 and set(np.diff(frames[1:, 1])) == {50.0}
    np.testing.assert_allclose(frames[:, 0], frames[:, 1] / 1000.0, atol=2e-3)


def test_a_run_that_is_too_slow_for_its_pace_has_twenty_frames_a_second_all_the_same(clock):
    frames = instants_of_frames(clock, Pace(1e6), 1e4, 0.005, 5.0)
    assert 95 <= len(frames) <= 112


def test_a_live_viewer_changes_no_bit_and_sends_frames(tmp_path):
    plain, seen = (make("chain", grains=60, left="piston") for _ in range(2))
    with LiveViewer(seen, save=tmp_path / "live.rrd", duration=1e-4, pace=0.3) as live:
        for chain in (plain, seen):
            chain.step(1e-4, left_velocity=5.0)
    assert plain.save().to_bytes() == seen.save().to_bytes()
    found, _ = read_columns(tmp_path / "live.rrd")
    drawn = [row for row in found["scene/particles_grains"]["positions"] if row is not None]
    assert live.frames == len(drawn) >= 2 and {len(row) for row in drawn} == {60}
    assert "caption" in found and "inputs/left_velocity" in found


# -- the x-t diagram ------------------------------------------------------------------------------------------------------


def picture_of(times, end):
    """Return the x-t diagram of a chain with grain velocities of 1 m/s at each sampled time."""
    motion = make_scene(make("chain", grains=10)).motion
    growing = GrowingPicture(0.0, end)
    for time in times:
        growing.store_frame(type(motion)(**{**vars(motion), "times": np.array([time]), "colour": np.ones((1, 10))}))
    return growing.draw_picture(motion, 2.0)


def sampled_part(picture, low, high):
    """Return the fraction of a time interval that is drawn in a colour of the map."""
    rows = np.rint(picture.pixel_rows(np.linspace(low, high, 200)[1:-1])).astype(int)
    column = picture.pixels[rows, int(0.5 * (picture.left + picture.right))]
    return float((column != np.array(parse_rgb(NOT_SAMPLED))).any(axis=1).mean())


def test_instants_that_were_not_sampled_are_not_drawn_as_a_chain_at_rest():
    """Three frames, two of them at the end, as left by a very short run."""
    picture = picture_of([0.0, 4.9e-4, 5e-4], 5e-4)
    assert sampled_part(picture, 0.2e-4, 4.6e-4) == 0.0
    assert sampled_part(picture, 4.95e-4, 5e-4) == 1.0


def test_even_frames_fill_the_diagram_as_far_as_the_run_has_come():
    picture = picture_of(np.linspace(0.0, 2.5e-4, 101), 5e-4)
    assert sampled_part(picture, 0.0, 2.5e-4) == 1.0
    assert sampled_part(picture, 2.6e-4, 5e-4) == 0.0


# -- other histories ------------------------------------------------------------------------------------------------------


def test_live_histories_are_laid_end_to_end(tmp_path):
    oscillator = make("oscillator")
    with LiveViewer(oscillator, save=tmp_path / "live.rrd"):
        oscillator.step(1.0)
        oscillator.reset(position=1.0)
        oscillator.step(0.5)
    assert max(read_columns(tmp_path / "live.rrd")[0]["outputs/position"]["tick"]) == 150


def test_live_scales_only_grow_to_hold_what_comes():
    chain = make("chain", grains=20, left="piston")
    at_rest = make_scales(make_scene(chain))
    chain.step(5e-5, left_velocity=0.05)
    assert at_rest.colours[0].is_zero and 0.05 <= enlarge_scales(at_rest, make_scene(chain), None).colour_limit <= 0.2
    chain.step(5e-5, left_velocity=5.0)
    now = make_scene(chain)
    scales = enlarge_scales(make_scales(now), now, None)
    assert scales == make_scales(now)
    louder = replace(now.motion, colour=3.0 * now.motion.colour)
    assert enlarge_scales(scales, replace(now, motions=(louder,)), None).colour_limit >= float(np.abs(louder.colour).max())


def test_a_viewer_that_fails_does_not_stop_the_run(tmp_path, monkeypatch):
    oscillator = make("oscillator")
    watching = LiveViewer(oscillator, save=tmp_path / "live.rrd")

    def broken(*_):
        raise RuntimeError("gone")

    monkeypatch.setattr(live, "send_curves", broken)
    with pytest.warns(GranularWarning, match="gone"):
        oscillator.step(1.0)
    assert oscillator.tick == 100
    watching.close()


# -- refusals -------------------------------------------------------------------------------------------------------------


@pytest.fixture
def no_screen(monkeypatch):
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)


def test_a_live_run_without_a_screen_is_refused_before_it_begins(no_screen, tmp_path, capsys):
    log = tmp_path / "new" / "a.mcap"
    assert main(["run", "oscillator/pushed", "--live", "--log", str(log)]) == 2
    told = capsys.readouterr().err
    assert "no screen: neither DISPLAY nor WAYLAND_DISPLAY is set" in told and "run without live=True (--live)" in told
    assert "apt-get" not in told
    assert list(tmp_path.iterdir()) == []
