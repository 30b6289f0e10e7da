"""Rerun files and rerun's viewers, for logs.

`save_rrd` writes a file with its layout, `view` opens the desktop or the web viewer, `screenshot` takes a picture without a
screen. Every server that is started listens on 127.0.0.1 only (rerun's default is all interfaces).
"""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import socket
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from granular_env.components.errors import GranularError, ParameterError
from granular_env.writing import refused_unless_file, write_files

from .blueprint import blueprint
from .extras import needed
from .footage import Footage, from_log
from .rerun_file import rerun_target
from .scene import APPLICATION, TIMELINE, Scales, scales_of, send

# What headless rerun needs of a Debian system, beyond Python packages.
HEADLESS_PACKAGES = (
    "mesa-vulkan-drivers",
    "libvulkan1",
    "libegl1",
    "libgl1-mesa-dri",
    "libxkbcommon-x11-0",
    "libx11-xcb1",
    "libxcursor1",
    "libxi6",
)
LOCALHOST = "127.0.0.1"
_START_SECONDS = 60.0
_SETTLE_SECONDS = 5.0


def save_rrd(log: Any, path: str | os.PathLike[str], exaggerate: float | None = None) -> Path:
    """Write a log's scene, with its layout, as a file for rerun.

    Args:
        log: an open log.
        path: of the .rrd file; a rerun file that stands there is replaced, any other file is not.
        exaggerate: draw displacements so many times larger; by default chosen so that the wave is seen and no grains
            pass one another. The factor is stated in the scene.

    Returns:
        The path.

    Raises:
        MissingExtraError: rerun or matplotlib is not installed.
        ParameterError: the factor is not a positive number, or the path does not end in .rrd or is that of another file.
        GranularError: the file cannot be written.
    """
    rr = needed("rerun", "saving a rerun file")
    target = rerun_target(path)
    footage = from_log(log)
    scales = _scales(footage, exaggerate)
    # A file's name may hold bytes that are no text; rerun takes text only.
    name = Path(str(log.path)).name.encode("utf-8", "replace").decode()
    recording = rr.RecordingStream(APPLICATION, recording_id=f"{footage.title} ({name})")
    # Through memory: where the disk becomes full, rerun's own writer drops the rest, or hangs, and raises nothing.
    kept = recording.memory_recording()
    try:
        recording.send_blueprint(blueprint(footage, scales, log.duration), make_active=False)
        recording.send_recording_name(footage.title)
        send(recording, footage, scales)
        write_files({target: kept.drain_as_bytes()})
    except RuntimeError as error:
        raise GranularError(f"cannot write the rerun file {str(target)!r}: {error}") from error
    finally:
        recording.disconnect()
    return target


def view(log: Any, web: bool = False, exaggerate: float | None = None) -> None:
    """Show a log in rerun's desktop viewer, or serve it for a browser; returns when the viewer is closed (or at Ctrl-C).

    Args:
        log: an open log.
        web: serve the web viewer on 127.0.0.1 and print its address.
        exaggerate: as in `save_rrd`.

    Raises:
        MissingExtraError, GranularError: rerun is not installed, or cannot start (no screen).
    """
    needed("rerun", "the viewer")
    if not web and sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise GranularError(
            "no screen: neither DISPLAY nor WAYLAND_DISPLAY is set, so the desktop viewer cannot open; "
            "use the web viewer (web=True), a rerun file (save_rrd) or a picture (screenshot)"
        )
    with tempfile.TemporaryDirectory(prefix="granular-env-") as folder:
        file = save_rrd(log, Path(folder) / "scene.rrd", exaggerate)
        with _web_viewer(file) if web else _desktop_viewer(file) as process, contextlib.suppress(KeyboardInterrupt):
            process.wait()
            if process.returncode:
                raise GranularError(f"rerun's viewer ended with status {process.returncode}; its messages are above")


def screenshot(
    log: Any,
    png: str | os.PathLike[str],
    *,
    at: float | None = None,
    size: tuple[int, int] = (1600, 1000),
    exaggerate: float | None = None,
) -> Path:
    """A picture of the whole viewer, taken without a screen.

    Args:
        log: an open log.
        png: path of the picture.
        at: instant shown [s]; by default two thirds of the run.
        size: width and height of the viewer's window [points].
        exaggerate: as in `save_rrd`.

    Raises:
        MissingExtraError: rerun is not installed.
        GranularError: the viewer cannot start; the message names the system packages it needs.
    """
    needed("rerun", "a screenshot")
    target = Path(png).absolute()
    refused_unless_file(target)
    if target.suffix.lower() != ".png":
        raise ParameterError(f"{str(target)!r}: a screenshot is a PNG picture; give a name that ends in .png")
    start = log.start_tick * log.step_size
    instant = start + 2.0 / 3.0 * log.duration if at is None else at
    if not start <= instant <= start + log.duration:
        raise ParameterError(f"at: got {instant:g} s, expected {start:g} to {start + log.duration:g} s")
    with tempfile.TemporaryDirectory(prefix="granular-env-") as folder:
        file = save_rrd(log, Path(folder) / "scene.rrd", exaggerate)
        picture = Path(folder) / "picture.png"
        with _headless_viewer(file, size) as port:
            data = _take(port, picture, instant)
    write_files({target: data})
    return target


def _scales(footage: Footage, exaggerate: float | None) -> Scales | None:
    if exaggerate is not None and not 0.0 < exaggerate < float("inf"):
        raise ParameterError(f"exaggerate: got {exaggerate!r}, expected a positive number")
    return None if footage.motion is None else scales_of(footage.motion, exaggerate)


# -- rerun's processes ----------------------------------------------------------------------------------------------------


def rerun_program() -> str:
    """Path of rerun's command, the one that belongs to this Python before any other.

    Raises:
        GranularError: there is none.
    """
    beside = Path(sysconfig.get_path("scripts")) / ("rerun.exe" if os.name == "nt" else "rerun")
    found = str(beside) if beside.exists() else shutil.which("rerun")
    if found is None:
        raise GranularError(
            "the program `rerun` is not found beside this Python or on PATH; run: pip install --force-reinstall rerun-sdk"
        )
    return found


def free_port() -> int:
    """A TCP port of 127.0.0.1 that nobody listens on now."""
    with socket.socket() as probe:
        probe.bind((LOCALHOST, 0))
        return probe.getsockname()[1]


def started(*arguments: str, log_to: Path | None = None) -> subprocess.Popen[bytes]:
    """Rerun with these arguments, listening on 127.0.0.1 only."""
    command = [rerun_program(), *arguments, "--bind", LOCALHOST]
    with log_to.open("wb") if log_to is not None else contextlib.nullcontext() as output:
        # A session of its own: rerun's command is a launcher, whose child has to end with it.
        return subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=output, stderr=output, start_new_session=os.name == "posix"
        )


def stopped(process: subprocess.Popen[bytes]) -> None:
    """End a viewer that `started` began, gently, then not."""
    for number in (signal.SIGTERM, getattr(signal, "SIGKILL", signal.SIGTERM)):
        with contextlib.suppress(ProcessLookupError, PermissionError):
            if os.name == "posix":
                os.killpg(process.pid, number)
            else:
                process.terminate()
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(5.0)
            return


@contextlib.contextmanager
def _running(*arguments: str, log_to: Path | None = None) -> Iterator[subprocess.Popen[bytes]]:
    process = started(*arguments, log_to=log_to)
    try:
        yield process
    finally:
        stopped(process)


@contextlib.contextmanager
def _desktop_viewer(file: Path) -> Iterator[subprocess.Popen[bytes]]:
    with _running(str(file), "--port", str(free_port())) as process:
        yield process


@contextlib.contextmanager
def _web_viewer(file: Path) -> Iterator[subprocess.Popen[bytes]]:
    web_port, port = free_port(), free_port()
    with _running(str(file), "--serve-web", "--port", str(port), "--web-viewer-port", str(web_port)) as process:
        wait_for_port(process, web_port, None)
        print(f"rerun's web viewer: {web_address(web_port, port)}  (Ctrl-C ends it)", flush=True)
        yield process


def web_address(web_port: int, port: int) -> str:
    """Address of a served web viewer that reads from the data server at `port`."""
    return f"http://{LOCALHOST}:{web_port}/?url=rerun%2Bhttp%3A%2F%2F{LOCALHOST}%3A{port}%2Fproxy"


@contextlib.contextmanager
def _headless_viewer(file: Path, size: tuple[int, int]) -> Iterator[int]:
    """The port of a viewer without a window that has started."""
    port, messages = free_port(), file.with_name("viewer.txt")
    window = f"{size[0]}x{size[1]}"
    with _running(str(file), "--headless", "--port", str(port), "--window-size", window, log_to=messages) as process:
        wait_for_port(process, port, messages)
        yield port


def wait_for_port(process: subprocess.Popen[bytes], port: int, messages: Path | None) -> None:
    """Until a viewer listens; `GranularError` with what it said where it does not come up."""
    deadline = time.monotonic() + _START_SECONDS
    while time.monotonic() < deadline and process.poll() is None:
        with contextlib.suppress(OSError), socket.create_connection((LOCALHOST, port), timeout=1.0):
            return
        time.sleep(0.1)
    said = messages.read_text(errors="replace")[-600:] if messages is not None else ""
    raise GranularError(
        "rerun's viewer did not start; without a screen it needs the system packages (Debian names) "
        f"{' '.join(HEADLESS_PACKAGES)}: apt-get install them. It said: {said.strip() or 'nothing'}"
    )


def _take(port: int, picture: Path, instant: float) -> bytes:
    client_class = needed("rerun.experimental", "a screenshot").ViewerClient
    try:
        client = client_class.connect(f"rerun+http://{LOCALHOST}:{port}/proxy")
        deadline = time.monotonic() + _START_SECONDS
        while True:
            try:
                client.set_time(TIMELINE, duration=instant, play_state="paused")
                break
            except Exception:  # The recording is still being loaded; rerun raises several kinds.
                if time.monotonic() > deadline:
                    raise
                time.sleep(0.3)
        # Textures arrive some frames later, the viewer's own notices leave after seconds, and rerun has no signal for either.
        time.sleep(_SETTLE_SECONDS)
        client.save_screenshot(str(picture))
        return picture.read_bytes()
    except Exception as error:
        raise GranularError(
            f"rerun's viewer gave no picture: {error}. It needs the system packages (Debian names) "
            f"{' '.join(HEADLESS_PACKAGES)}"
        ) from error
