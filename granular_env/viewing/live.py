"""A viewer that looks at a run while it goes on: an observer, which never changes what it observes."""

from __future__ import annotations

import contextlib
import dataclasses
import os
import subprocess
import warnings
from collections.abc import Mapping
from time import perf_counter
from typing import Any, Self

import numpy as np

from granular_env.components.contract import Component, Held
from granular_env.components.errors import GranularError, GranularWarning

from .blueprint import blueprint
from .extras import needed
from .footage import Footage, Motion, from_component
from .rerun_file import rerun_target
from .scene import APPLICATION, Scales, scales_of, send_curves, send_motion, send_space_time_picture, send_static
from .viewer import LOCALHOST, free_port, started, stopped, wait_for_port, web_address

# Wall time between two frames [s]; what happens in between is not shown.
_FRAME_SECONDS = 0.05
_LONGEST_STRIDE = 1 << 40
# Rows of the x-t diagram that are kept; when there are more, each second one is dropped.
_ROWS = 400
# The x-t diagram is drawn anew when it has grown by this part.
_GROWTH = 1.25
# Room beside the chain at rest, left and right, in its lengths.
_ROOM = (0.1, 0.3)
# Older frames are dropped by the viewer beyond this.
_MEMORY = ("--memory-limit", "2GB", "--server-memory-limit", "512MB")


class LiveViewer:
    """Shows a component in rerun while it steps.

        with LiveViewer(chain):
            chain.step(5e-4, left_velocity=5.0)

    About 20 frames per second of wall time are sent, however fast the run is. Where the component is reset or restored, time
    goes on: the histories are laid end to end, as in a log.

    Attributes:
        next_tick: the tick at which it wants to look next.
        frames: how many frames were sent.
    """

    def __init__(
        self,
        component: Component,
        *,
        title: str | None = None,
        web: bool = False,
        save: str | os.PathLike[str] | None = None,
        exaggerate: float | None = None,
    ) -> None:
        """Open the viewer and begin to look.

        Args:
            component: what to look at.
            title: of the scene; default: the component's name.
            web: serve the web viewer on 127.0.0.1 and print its address, instead of opening a window.
            save: write the frames to this .rrd file, instead of opening a viewer.
            exaggerate: draw displacements so many times larger; by default chosen, and lowered as the wave grows.

        Raises:
            MissingExtraError: rerun is not installed.
            ParameterError: `save` does not end in .rrd, or something other than a rerun file stands there.
            GranularError: the viewer cannot be started.
        """
        self.next_tick, self.frames = 0, 0
        self._component, self._title, self._exaggerate = component, title, exaggerate
        self._stride, self._sent_at, self._elapsed, self._last_tick, self._working = 1, -np.inf, 0, 0, True
        self._rows: list[tuple[int, float, np.ndarray]] = []
        self._kept_every, self._drawn_rows = 1, 4.0
        self._scales: Scales | None = None
        self._web = web and save is None
        self._process: subprocess.Popen[bytes] | None = None
        rr = needed("rerun", "the live viewer")
        self._recording = rr.RecordingStream(APPLICATION)
        footage = from_component(component, title)
        if footage.motion is not None:
            self._scales = _first_scales(footage.motion, exaggerate)
        self._connect(blueprint(footage, self._scales, None), web, save)
        component.observe(self)

    def _connect(self, layout: Any, web: bool, save: str | os.PathLike[str] | None) -> None:
        if save is not None:
            try:
                self._recording.save(rerun_target(save), default_blueprint=layout)
            except (OSError, RuntimeError) as error:
                raise GranularError(f"cannot write the rerun file {str(save)!r}: {error}") from error
            return
        port, web_port = free_port(), free_port()
        served = ("--serve-web", "--web-viewer-port", str(web_port)) if web else ("--expect-data-soon",)
        self._process = started(*served, "--port", str(port), *_MEMORY)
        try:
            wait_for_port(self._process, port, None)
        except GranularError:
            stopped(self._process)
            raise
        self._recording.connect_grpc(f"rerun+http://{LOCALHOST}:{port}/proxy", default_blueprint=layout)
        if web:
            print(f"rerun's web viewer: {web_address(web_port, port)}", flush=True)

    # -- the observer -----------------------------------------------------------------------------------------------

    def began(self, component: Component) -> None:
        """A new history starts here; time goes on."""
        self._elapsed += self._last_tick - component.tick
        self._last_tick = component.tick
        self.next_tick = component.tick + self._stride
        self._send(component, anew=True)

    def look(self, component: Component) -> None:
        """Send a frame if the last one is old enough; look less often while frames come too fast."""
        self._last_tick = component.tick
        waited = perf_counter() - self._sent_at
        if waited >= _FRAME_SECONDS:
            self._send(component, anew=False)
        if waited < 0.5 * _FRAME_SECONDS:
            self._stride = min(2 * self._stride, _LONGEST_STRIDE)
        elif waited > 2.0 * _FRAME_SECONDS:
            self._stride = max(self._stride // 2, 1)
        self.next_tick = component.tick + self._stride

    def stepped(self, component: Component, ticks: int, inputs: Mapping[str, Held]) -> None:
        """Nothing to do: `look` has seen it."""
        self._last_tick = component.tick

    def failed(self, component: Component, error: BaseException) -> None:
        """The component went back to where its step began; so does the next look."""
        self._last_tick = component.tick
        self.next_tick = component.tick + self._stride

    # -- the end ----------------------------------------------------------------------------------------------------

    def close(self) -> None:
        """Send the last state and stop looking; a window stays open, a served page ends (call `wait` before, to keep it)."""
        self._component.ignore(self)
        self._send(self._component, anew=False)
        if self._working and self._scales is not None and len(self._rows) > 1:
            self._draw_space_time()
        with contextlib.suppress(Exception):
            self._recording.flush()
            self._recording.disconnect()
        if self._web and self._process is not None:
            stopped(self._process)

    def wait(self) -> None:
        """Until the viewer is closed, or Ctrl-C."""
        if self._process is not None:
            with contextlib.suppress(KeyboardInterrupt):
                self._process.wait()
            stopped(self._process)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    # -- details ----------------------------------------------------------------------------------------------------

    def _send(self, component: Component, anew: bool) -> None:
        """One frame. A viewer that is gone must not stop a run: it is reported once, then left alone."""
        if not self._working:
            return
        try:
            self._send_frame(component, anew)
        except Exception as error:
            self._working = False
            warnings.warn(f"the live viewer stopped: {error}; the run goes on", GranularWarning, stacklevel=2)
        self._sent_at = perf_counter()

    def _send_frame(self, component: Component, anew: bool) -> None:
        footage = self._shifted(from_component(component, self._title))
        if footage.motion is not None and self._scales is not None:
            scales = _grown(self._scales, footage.motion, self._exaggerate)
            anew, self._scales = anew or scales != self._scales, scales
            self._keep_row(footage.motion)
        if anew:
            send_static(self._recording, footage, self._scales)
        if footage.motion is not None and self._scales is not None:
            send_motion(self._recording, footage.motion, self._scales)
            if len(self._rows) * self._kept_every >= self._drawn_rows:
                self._draw_space_time()
        send_curves(self._recording, footage)
        self.frames += 1

    def _shifted(self, footage: Footage) -> Footage:
        """The footage in the viewer's time."""
        if not self._elapsed:
            return footage
        ticks, seconds = self._elapsed, self._elapsed * self._component.step_size

        def later(part: Any) -> Any:
            return dataclasses.replace(part, ticks=part.ticks + ticks, times=part.times + seconds)

        return dataclasses.replace(
            footage,
            motion=None if footage.motion is None else later(footage.motion),
            curves={name: later(curve) for name, curve in footage.curves.items()},
            inputs={name: later(curve) for name, curve in footage.inputs.items()},
        )

    def _keep_row(self, motion: Motion) -> None:
        if motion.colour is None or self.frames % self._kept_every:
            return
        self._rows.append((int(motion.ticks[0]), float(motion.times[0]), motion.colour[0]))
        if len(self._rows) > _ROWS:
            self._rows, self._kept_every = self._rows[::2], 2 * self._kept_every

    def _draw_space_time(self) -> None:
        assert self._scales is not None
        motion = from_component(self._component).motion
        ticks, times, rows = zip(*self._rows, strict=True)
        if motion is None or times[-1] <= times[0]:
            return
        whole = dataclasses.replace(motion, ticks=np.array(ticks), times=np.array(times), colour=np.stack(rows))
        send_space_time_picture(self._recording, whole, self._scales)
        self._drawn_rows = _GROWTH * len(self._rows) * self._kept_every


def _first_scales(motion: Motion, exaggerate: float | None) -> Scales:
    """Scales with room for what may come: the chain at rest, and beside it where it may go."""
    first = scales_of(motion, exaggerate)
    low, high = first.low - _ROOM[0] * first.length, first.high + _ROOM[1] * first.length
    height = 0.07 * (high - low)
    level = first.profile_level + height
    return dataclasses.replace(first, low=low, high=high, height=height, profile_level=level, settled=False)


def _grown(scales: Scales, motion: Motion, exaggerate: float | None) -> Scales:
    """The same scene, with limits that hold this frame too; unchanged while they hold."""
    now = scales_of(motion, exaggerate)
    moves = bool(np.any(motion.displacement))
    factor = scales.exaggeration
    if moves and (factor == 1.0 or now.exaggeration < factor):
        factor = now.exaggeration
    colour = motion.colour if motion.colour is not None else np.zeros(1)
    contact = motion.contact if motion.contact is not None else np.zeros(1)
    return dataclasses.replace(
        scales,
        exaggeration=factor,
        colour_limit=now.colour_limit if float(np.abs(colour).max()) > scales.colour_limit else scales.colour_limit,
        contact_limit=now.contact_limit if float(contact.max(initial=0.0)) > scales.contact_limit else scales.contact_limit,
    )
