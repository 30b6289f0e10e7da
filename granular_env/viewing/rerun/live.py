"""A viewer of a running component: an observer that never changes the component."""

from __future__ import annotations

import contextlib
import dataclasses
import math
import os
import warnings
from collections.abc import Mapping
from time import perf_counter, sleep
from typing import Self

import rerun as rr

from granular_env.components.component import Component
from granular_env.components.errors import GranularWarning, ParameterError
from granular_env.components.inputs import Held
from granular_env.components.support.validation import positive_number

from ..domain_views import make_views
from ..scene_builder import make_scene
from ..scene_data import Motion, SceneData
from ..scene_scales import Scales, enlarge_scales, make_scales
from .blueprint import make_blueprint
from .process import RerunProcess, require_screen
from .scene import APPLICATION, send_curves, send_frames, send_static
from .viewer import output_path

FRAME_SECONDS = 0.05
# Largest factor by which the number of ticks between frames may grow from one frame to the next.
_GROWTH = 4.0
# Wall time between two updates of the pictures that take long to draw [s].
_PICTURE_SECONDS = 0.25
_NEVER = 1 << 62
# Free space left and right of the particles at rest, as a fraction of their extent.
_ROOM = (0.1, 0.3)
# Memory of the viewers above which rerun drops old frames.
_MEMORY = ("--memory-limit", "2GB", "--server-memory-limit", "512MB")


class Pace:
    """Timing of a live run: a frame about every `FRAME_SECONDS` of wall time, and pauses if the run is faster than its pace.

    Args:
        ticks_per_second: largest number of ticks per second of wall time; infinity for no limit.
    """

    def __init__(self, ticks_per_second: float = math.inf) -> None:
        """Start at tick 0."""
        self._pace, self._stride, self._sending = ticks_per_second, 1.0, 0.0
        self.restart(0)

    def restart(self, tick: int) -> None:
        """Restart the count at this tick and the present wall time."""
        self._first_tick, self._first = tick, perf_counter()
        self._left_tick, self._left = tick, self._first
        self._arrived, self._rate = self._first, math.inf

    def wait_for_pace(self, tick: int) -> None:
        """Measure the speed of the run up to this tick, and wait if it is faster than its pace."""
        self._arrived = perf_counter()
        if tick > self._left_tick:
            self._rate = (tick - self._left_tick) / max(self._arrived - self._left, 1e-9)
        ahead = self._first + (tick - self._first_tick) / self._pace - self._arrived
        if ahead > 0.0:
            sleep(ahead)
            self._arrived = perf_counter()
        else:
            # If the run is behind its pace, do not catch up later: frames would be missing then.
            self._first -= ahead

    def next_frame_tick(self, tick: int) -> int:
        """Return the tick of the next frame, after a frame was sent."""
        self._left_tick, self._left = tick, perf_counter()
        # Choose the interval so that sending frames takes at most half of the time; a single slow frame does not count.
        last, self._sending = self._sending, self._left - self._arrived
        sending = min(last, self._sending)
        interval = max(FRAME_SECONDS, 2.0 * sending)
        # Limit the growth, because the rate of the first ticks is unreliable.
        most = _GROWTH * self._stride if math.isinf(self._pace) else self._pace * interval
        self._stride = max(1.0, min(self._rate * (interval - sending), most))
        return tick + int(self._stride)


class LiveViewer:
    """A viewer that shows a component in rerun while it steps.

        with LiveViewer(chain):
            chain.step(5e-4, left_velocity=5.0)

    The viewer sends twenty frames per second of wall time at any speed of the run. Most runs take less time than one frame;
    `duration` and `pace` slow the run down so that it can be watched. After a reset or a restore the viewer's time
    continues, and histories are concatenated as in a log.

    Attributes:
        next_tick: tick of the next frame.
        frames: number of frames sent.
    """

    def __init__(
        self,
        component: Component,
        *,
        title: str | None = None,
        web: bool = False,
        save: str | os.PathLike[str] | None = None,
        exaggerate: float | None = None,
        duration: float | None = None,
        pace: float | None = None,
    ) -> None:
        """Open the viewer and start to observe.

        Args:
            component: the component to show.
            title: title of the scene; default: the component's name.
            web: serve the web viewer on 127.0.0.1 and print its address, instead of opening a window.
            save: write the frames to this .rrd file, instead of opening a viewer.
            exaggerate: factor of the drawn displacements; by default automatic, and reduced as the wave grows.
            duration: simulated time to be shown [s], if known.
            pace: least wall time for `duration` [s]; by default the run is not slowed down.

        Raises:
            MissingExtraError: rerun is not installed.
            ParameterError: `save` does not end in .rrd, `duration` or `pace` is not a positive number, or `pace` has no
                `duration`.
            GranularError: there is no screen, or the viewer cannot start.
        """
        self.next_tick, self.frames = 0, 0
        self._component, self._title, self._exaggerate = component, title, exaggerate
        self._pacing = Pace()
        if pace is not None:
            if duration is None:
                raise ParameterError("missing", expected="the simulated time [s] shown during `pace`", at="duration")
            self._pacing = Pace(positive_number("duration", duration) / component.step_size / positive_number("pace", pace))
        self._elapsed, self._last_tick, self._sent_tick, self._working = 0, 0, -1, True
        self._drawn_at = -math.inf
        self._process: RerunProcess | None = None
        self._is_served = web and save is None
        self._recording = rr.RecordingStream(APPLICATION)
        scene_data = make_scene(component, title)
        self._scales = _initial_scales(scene_data, exaggerate)
        end = None if duration is None else component.time + duration
        self._views = make_views(component.name, scene_data, self._scales, component.time, end)
        layout = make_blueprint(scene_data, self._scales, self._views, None)
        if save is None:
            self._recording.connect_grpc(self._start_viewer(web), default_blueprint=layout)
        else:
            self._recording.save(output_path(save, ".rrd"), default_blueprint=layout)
        component.observe(self)

    def _start_viewer(self, web: bool) -> str:
        """Start a viewer and return the address at which it receives data."""
        if not web:
            require_screen("use the web viewer, web=True (--web), or write a rerun file, save='FILE.rrd' (--save FILE.rrd)")
        # The user closes the window, possibly after this program has ended.
        process = RerunProcess(*(() if web else ("--expect-data-soon",)), *_MEMORY, web=web, outlives=not web)
        try:
            process.wait_for_ports()
        except BaseException:
            process.stop()
            raise
        if web:
            print(f"rerun's web viewer: {process.page_url}", flush=True)
        self._process = process
        return process.url

    def on_reset(self, component: Component) -> None:
        """Start a new history; the viewer's time continues."""
        self._elapsed += self._last_tick - component.tick
        self._last_tick = component.tick
        self._pacing.restart(self._elapsed + component.tick)
        self._try_to_send_frame(component, is_reset=True)
        self.next_tick = component.tick + 1

    def on_sample(self, component: Component) -> None:
        """Send a frame if one is due, after waiting if the run is ahead of its pace."""
        self._last_tick = component.tick
        if not self._working:
            self.next_tick = _NEVER
            return
        shown = self._elapsed + component.tick
        self._pacing.wait_for_pace(shown)
        self._try_to_send_frame(component, is_reset=False)
        self.next_tick = self._pacing.next_frame_tick(shown) - self._elapsed

    def on_step(self, component: Component, ticks: int, inputs: Mapping[str, Held]) -> None:
        """Do nothing: `on_sample` handles the frames."""
        self._last_tick = component.tick

    def on_failure(self, component: Component, error: BaseException) -> None:
        """Set the viewer back to the start of the failed step, to which the component has returned."""
        self._last_tick = component.tick
        self._pacing.restart(self._elapsed + component.tick)
        self.next_tick = component.tick + 1

    def close(self) -> None:
        """Send the last state and stop observing. A window stays open; a served page ends (call `wait` before to keep it)."""
        self._component.ignore(self)
        if self._elapsed + self._component.tick != self._sent_tick:
            self._try_to_send_frame(self._component, is_reset=False)
        with contextlib.suppress(Exception):
            if self._working:
                self._draw_pictures()
            self._recording.flush()
            self._recording.disconnect()
        if self._is_served and self._process is not None:
            self._process.stop()

    def wait(self) -> None:
        """Wait until the viewer is closed, or until Ctrl-C."""
        if self._process is not None:
            with contextlib.suppress(KeyboardInterrupt):
                self._process.process.wait()
            self._process.stop()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _try_to_send_frame(self, component: Component, is_reset: bool) -> None:
        """Send a frame. The failure of a viewer must not stop a run: it is reported once, then nothing more is sent."""
        if not self._working:
            return
        try:
            self._send_frame(component, is_reset)
        except Exception as error:
            self._working = False
            warnings.warn(f"the live viewer stopped: {error}; the run continues", GranularWarning, stacklevel=2)

    def _send_frame(self, component: Component, has_new_layout: bool) -> None:
        scene_data = make_scene(component, self._title, self._elapsed)
        if self._scales is not None:
            scales = enlarge_scales(self._scales, scene_data, self._exaggerate)
            has_new_layout = has_new_layout or scales != self._scales
            if scene_data.motion is not None and self._views is not None:
                has_new_layout = self._views.add_frame(scene_data.motion) or has_new_layout
            self._scales = scales
        if has_new_layout:
            send_static(self._recording, scene_data, self._scales, self._views)
        if self._scales is not None:
            send_frames(self._recording, scene_data, self._scales, self._views)
            if perf_counter() >= self._drawn_at + _PICTURE_SECONDS:
                self._draw_pictures(scene_data.motion)
        send_curves(self._recording, scene_data)
        self._sent_tick = self._elapsed + component.tick
        self.frames += 1

    def _draw_pictures(self, motion: Motion | None = None) -> None:
        """Send the pictures that take long to draw, for the run so far."""
        motion = motion or make_scene(self._component).motion
        if motion is not None and self._scales is not None and self._views is not None:
            self._views.send_pictures(self._recording, motion, self._scales)
            self._drawn_at = perf_counter()


def _initial_scales(scene_data: SceneData, exaggerate: float | None) -> Scales | None:
    """Return the scales for the first frame of a live run, with space for motion around the shapes at rest."""
    first = make_scales(scene_data, exaggerate)
    if first is None:
        return None
    extent = first.high[0] - first.low[0]
    low, high = (first.low[0] - _ROOM[0] * extent, *first.low[1:]), (first.high[0] + _ROOM[1] * extent, *first.high[1:])
    return dataclasses.replace(first, low=low, high=high, settled=False)
