"""Rerun's executable as a process: a viewer or a server that listens only on 127.0.0.1.

Rerun's `spawn`, `serve_grpc` and `serve_web_viewer` listen on all interfaces without an option to change that; the executable
has this option. On Linux the process also ends when the parent process is killed.
"""

from __future__ import annotations

import contextlib
import os
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import IO, Self
from urllib.parse import quote

import rerun_cli

from granular_env.components.errors import GranularError

LOCALHOST = "127.0.0.1"
NEEDED = (
    "a picture without a screen requires software Vulkan, which is incomplete on this machine; run `make system-packages` "
    "as root (Debian, Ubuntu), or: apt-get install mesa-vulkan-drivers libvulkan1 libegl1 libgl1-mesa-dri libxkbcommon-x11-0 "
    "libx11-xcb1 libxcursor1 libxi6"
)
START_SECONDS = 60.0
_END_SECONDS = 5.0
_POLL_SECONDS = 0.05
_LONGEST_MESSAGE = 400

# Environment of rerun: print only errors, without colours; with CI set, rerun sends no usage data.
_ENVIRONMENT = {"RUST_LOG": "error", "NO_COLOR": "1", "CI": "true"}
# Linux sends SIGKILL to a process with PR_SET_PDEATHSIG (1) when its parent ends.
_ENDS_WITH_PARENT = (
    "import ctypes, os, sys; ctypes.CDLL(None).prctl(1, 9); "
    "os.getppid() == int(sys.argv[1]) and os.execv(sys.argv[2], sys.argv[2:])"
)


class RerunProcess:
    """A rerun viewer or server, ended by `stop` or at the end of a `with` block.

    Attributes:
        process: the process.
        port: port for data and commands.
        web_port: port of the served page, if any.
    """

    def __init__(
        self, *arguments: str, data: bytes | None = None, web: bool = False, outlives: bool = False, advice: str = ""
    ) -> None:
        """Start rerun.

        Args:
            arguments: further command-line arguments.
            data: content of an .rrd file to show.
            web: serve the web viewer instead of opening a window.
            outlives: keep the window open when this process ends.
            advice: advice to the user if it does not start.
        """
        self.port, self.web_port, self._is_web, self._advice = _free_port(), _free_port(), web, advice
        self._messages: IO[bytes] = tempfile.TemporaryFile()
        command = [_find_rerun_program(), *arguments, "--port", str(self.port), "--bind", LOCALHOST]
        command += ["--serve-web", "--web-viewer-port", str(self.web_port)] if web else []
        command += ["-"] if data is not None else []
        if not outlives and sys.platform == "linux":
            command = [sys.executable, "-I", "-S", "-c", _ENDS_WITH_PARENT, str(os.getpid()), *command]
        with tempfile.TemporaryFile() as file:
            file.write(data or b"")
            file.seek(0)
            # In a separate session, a window that outlives this process does not receive Ctrl-C from the terminal.
            self.process = subprocess.Popen(
                command, stdin=file, stdout=self._messages, stderr=self._messages,
                env={**os.environ, **_ENVIRONMENT}, start_new_session=True,
            )  # fmt: skip

    @property
    def url(self) -> str:
        """The address for data and commands."""
        return f"rerun+http://{LOCALHOST}:{self.port}/proxy"

    @property
    def page_url(self) -> str:
        """The address of the web viewer, with the dark theme to match the dark pictures."""
        return f"http://{LOCALHOST}:{self.web_port}/?url={quote(self.url, safe='')}&theme=dark"

    def wait_for_ports(self) -> None:
        """Wait until the ports are open; raise `GranularError` if the process ends first or takes too long."""
        deadline = time.monotonic() + START_SECONDS
        for port in (self.port, self.web_port) if self._is_web else (self.port,):
            while not _is_listening(port):
                self.require_alive()
                if time.monotonic() > deadline:
                    raise self.viewer_error(f"did not start in {START_SECONDS:g} s")
                time.sleep(_POLL_SECONDS)

    def require_alive(self) -> None:
        """Raise `GranularError` with rerun's message if the process has ended."""
        if (status := self.process.poll()) is not None:
            raise self.viewer_error(f"ended with status {status}")

    def viewer_error(self, what: str) -> GranularError:
        """Return the error of a failed viewer, with the beginning of rerun's output, without the stack trace."""
        self._messages.seek(0)
        printed = self._messages.read(1 << 16).decode(errors="replace").partition("stack backtrace:")[0]
        said = f"it said: {' '.join(printed.split())[:_LONGEST_MESSAGE] or 'nothing'}"
        return GranularError(f"rerun's viewer {what}", hint=f"{self._advice}; {said}" if self._advice else said)

    def wait(self) -> None:
        """Wait until the process ends; raise `GranularError` if it ends with an error."""
        if self.process.wait():
            self.require_alive()

    def stop(self) -> None:
        """End the process."""
        self.process.terminate()
        try:
            self.process.wait(_END_SECONDS)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self._messages.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.stop()


def require_screen(advice: str) -> None:
    """Raise `GranularError` with this advice if there is no screen on which a window can open."""
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        missing = "no screen: neither DISPLAY nor WAYLAND_DISPLAY is set, so the desktop viewer cannot open"
        raise GranularError(missing, hint=advice)


def _find_rerun_program() -> str:
    """Return the path of the executable in the package rerun-sdk."""
    folder = Path(rerun_cli.__file__).parent
    names = ("Rerun.app/Contents/MacOS/Rerun", "rerun", "rerun.exe")
    return next((str(folder / name) for name in names if (folder / name).is_file()), "rerun")


def _free_port() -> int:
    """Return a free TCP port of 127.0.0.1."""
    with socket.socket() as probe:
        probe.bind((LOCALHOST, 0))
        return probe.getsockname()[1]


def _is_listening(port: int) -> bool:
    with contextlib.suppress(OSError), socket.create_connection((LOCALHOST, port), timeout=1.0):
        return True
    return False
