"""Rerun files and viewers for logs.

`save_rrd` writes a file with its layout, `view` opens the desktop or the web viewer, and `screenshot` takes a picture without
a screen. All servers listen only on 127.0.0.1.
"""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import rerun as rr
from rerun.experimental import ViewerClient

from granular_env.components.errors import ParameterError
from granular_env.components.support.validation import finite_number, positive_number
from granular_env.output_files import require_writable, write_files
from granular_env.progress import Progress, progress_bar

from ..domain_views import make_views
from ..recorded_fields import located_events
from ..scene_builder import load_scene, require_log
from ..scene_scales import make_scales
from .blueprint import make_blueprint
from .process import NEEDED, START_SECONDS, RerunProcess, require_screen
from .scene import APPLICATION, TIMELINE, send_scene

_SETTLE_SECONDS = 5.0


def save_rrd(
    log: Any,
    path: str | os.PathLike[str],
    exaggerate: float | None = None,
    progress: Progress = False,
    colour: str | None = None,
) -> Path:
    """Write a log's scene, with its layout, as a file for rerun.

    Args:
        log: an open log.
        path: path of the .rrd file; an existing file is replaced.
        exaggerate: factor of the displacements, which the scene states; by default the wave is visible and particles do not
            pass one another.
        progress: show a bar, or call this with the completed fraction.
        colour: a recorded output that colours the shapes, instead of the component's choice.

    Returns:
        The path.

    Raises:
        MissingExtraError: rerun or matplotlib is not installed.
        ParameterError: the factor is not a positive number, the output cannot colour any shape, or the path does not end in
            .rrd.
        GranularError: the file cannot be written.
    """
    target = output_path(path, ".rrd")
    with progress_bar(f"scene of {target.name}", show=progress) as bar:
        write_files({target: scene_bytes(log, exaggerate, colour)})
        bar.update(1.0)
    return target


def scene_bytes(log: Any, exaggerate: float | None = None, colour: str | None = None) -> bytes:
    """Return the content of the file that `save_rrd` writes; errors as for `save_rrd`."""
    require_log(log)
    if exaggerate is not None:
        positive_number("exaggerate", exaggerate)
    scene_data = load_scene(log, colour=colour)
    scales = make_scales(scene_data, exaggerate)
    views = make_views(str(log.metadata.get("component")), scene_data, scales)
    recording = rr.RecordingStream(APPLICATION, recording_id=f"{scene_data.title} ({log.metadata.get('created')})")
    # Let rerun write to memory, not to the file: on a full disk it drops the rest or hangs, without an error.
    kept = recording.memory_recording()
    try:
        # Make the layout active, because the web viewer does not show the default layout of a server.
        recording.send_blueprint(make_blueprint(scene_data, scales, views, log.duration), make_active=True)
        recording.send_recording_name(scene_data.title)
        send_scene(recording, scene_data, scales, views)
        return kept.drain_as_bytes()
    finally:
        recording.disconnect()


def view(log: Any, web: bool = False, exaggerate: float | None = None, colour: str | None = None) -> None:
    """Show a log in rerun's desktop viewer, or serve it for a browser; return when the viewer is closed (or at Ctrl-C).

    Args:
        log: an open log.
        web: serve the web viewer on 127.0.0.1 and print its address.
        exaggerate: factor of the displacements, as in `save_rrd`.
        colour: output that colours the shapes, as in `save_rrd`.

    Raises:
        MissingExtraError, GranularError: rerun is not installed, or cannot start (no screen).
    """
    if not web:
        file, picture = "save_rrd (--save FILE.rrd)", "screenshot (--screenshot FILE.png)"
        require_screen(f"use the web viewer, web=True (--web), a rerun file, {file}, or a picture, {picture}")
    data = scene_bytes(log, exaggerate, colour)
    with contextlib.suppress(KeyboardInterrupt), RerunProcess(data=data, web=web) as viewer:
        if web:
            viewer.wait_for_ports()
            print(f"rerun's web viewer: {viewer.page_url}  (Ctrl-C ends it)", flush=True)
        viewer.wait()


def screenshot(
    log: Any,
    png: str | os.PathLike[str],
    *,
    at: float | None = None,
    size: tuple[int, int] = (1600, 1000),
    exaggerate: float | None = None,
    colour: str | None = None,
) -> Path:
    """Take a picture of the whole viewer, without a screen.

    Args:
        log: an open log.
        png: path of the picture.
        at: time shown [s]; by default the end of a run in which a drawn body broke or yielded, two thirds of any other run.
        size: width and height of the viewer's window [points].
        exaggerate: factor of the displacements, as in `save_rrd`.
        colour: output that colours the shapes, as in `save_rrd`.

    Raises:
        MissingExtraError: rerun is not installed.
        GranularError: the viewer cannot start; the message names the system packages it needs.
    """
    target = output_path(png, ".png")
    require_log(log)
    instant = _shown_time(log, at)
    data = scene_bytes(log, exaggerate, colour)
    with RerunProcess("--headless", "--window-size", f"{size[0]}x{size[1]}", data=data, advice=NEEDED) as viewer:
        picture = _take_png(viewer, instant)
    write_files({target: picture})
    return target


def _take_png(viewer: RerunProcess, instant: float) -> bytes:
    """Return a picture (PNG) of what a viewer without a window shows at a time [s]."""
    viewer.wait_for_ports()
    client = _repeat_request(viewer, lambda: ViewerClient.connect(viewer.url))
    # Repeat the request to set the time: it fails until the recording is loaded.
    _repeat_request(viewer, lambda: client.set_time(TIMELINE, duration=instant, play_state="paused"))
    # Wait, since textures arrive some frames later and the viewer's notices vanish after seconds; rerun signals neither.
    time.sleep(_SETTLE_SECONDS)
    return _repeat_request(viewer, client.take_screenshot)


def _repeat_request(viewer: RerunProcess, request: Callable[[], Any]) -> Any:
    """Repeat a request until the viewer answers; `GranularError` if the viewer ends or never answers."""
    deadline = time.monotonic() + START_SECONDS
    while True:
        try:
            return request()
        except Exception as error:  # rerun raises several types
            viewer.require_alive()
            if time.monotonic() > deadline:
                raise viewer.viewer_error(f"returned no picture: {error}") from error
            time.sleep(0.2)


def output_path(path: str | os.PathLike[str], suffix: str) -> Path:
    """Return the path of a file to write; refuse an unwritable path, or a name without the suffix."""
    require_writable(path)
    if Path(path).suffix.lower() != suffix:
        raise ParameterError(f"got {os.fspath(path)!r}", expected=f"the name of a file that ends in {suffix}", at="path")
    return Path(path)


def _shown_time(log: Any, at: float | None) -> float:
    """Return the time to show [s]: `at`, the end of a run with events at drawn bodies, or two thirds of any other run."""
    start = log.start_tick * log.step_size
    shown = log.duration if located_events(log) else 2.0 / 3.0 * log.duration
    instant = start + shown if at is None else finite_number("at", at, "seconds")
    # Allow for rounding in a user's value of the end time.
    slack = 1e-9 * max(abs(start), log.duration)
    if not start - slack <= instant <= start + log.duration + slack:
        raise ParameterError(f"got {instant:g} s", expected=f"{start:g} to {start + log.duration:g} s", at="at")
    return instant
