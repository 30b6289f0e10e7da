"""Rerun's program as a process of ours: started on 127.0.0.1 only, silent, and ended with the process that started it."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any

from granular_env.components.errors import Fault, GranularError, Phrase

LOCALHOST = "127.0.0.1"
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
NEEDED = (
    "a picture without a screen needs Vulkan in software, which is not complete on this machine; run `make system-packages` "
    f"as root (Debian, Ubuntu), or: apt-get install {' '.join(HEADLESS_PACKAGES)}"
)
START_SECONDS = 60.0
_END_SECONDS = 5.0
_POLL_SECONDS = 0.05
_SAID = 400

# Only errors are said, without colours. CI: rerun then collects and sends no usage data (its analytics).
_ENVIRONMENT = {"RUST_LOG": "error", "NO_COLOR": "1", "CI": "true"}
# Ask Linux for SIGKILL when the parent dies, whatever ends it, then become the program. PR_SET_PDEATHSIG is 1.
_BOUND = (
    "import ctypes, os, signal, sys\n"
    "ctypes.CDLL(None).prctl(1, int(signal.SIGKILL))\n"
    "if os.getppid() != int(sys.argv[1]): sys.exit(1)\n"
    "os.execv(sys.argv[2], sys.argv[2:])\n"
)


class RerunProcess:
    """A viewer or a server of rerun.

    Attributes:
        process: the process.
        port: where it takes data and commands.
    """

    def __init__(self, *arguments: str, data: bytes | None = None, bound: bool = True) -> None:
        """Start rerun.

        Args:
            arguments: of its command, besides the port and the address.
            data: content of an .rrd file to show; it stands in no folder, so that nothing can be left behind.
            bound: whether it ends with this process, even if this process is killed (on Linux).

        Raises:
            GranularError: there is no program `rerun`.
        """
        self.port = free_port()
        self._messages: IO[bytes] = tempfile.TemporaryFile()
        command = [
            rerun_program(),
            *arguments,
            *(["-"] if data is not None else []),
            "--port",
            str(self.port),
            "--bind",
            LOCALHOST,
        ]
        if bound and sys.platform == "linux" and sys.executable:
            command = [sys.executable, "-I", "-S", "-c", _BOUND, str(os.getpid()), *command]
        with tempfile.TemporaryFile() as file:
            file.write(data or b"")
            file.seek(0)
            # A session of its own: Ctrl-C at the terminal is ours to answer.
            self.process: subprocess.Popen[bytes] = subprocess.Popen(
                command, stdin=file, stdout=self._messages, stderr=self._messages,
                env={**os.environ, **_ENVIRONMENT}, start_new_session=os.name == "posix",
            )  # fmt: skip

    @property
    def url(self) -> str:
        """Return where its data and its commands go."""
        return f"rerun+http://{LOCALHOST}:{self.port}/proxy"

    def messages(self) -> str:
        """Return the first lines that it has written so far, without a stack of calls."""
        self._messages.seek(0)
        said = self._messages.read(1 << 16).decode(errors="replace").partition("stack backtrace:")[0]
        return " ".join(said.split())[:_SAID] or "nothing"

    def wait_until_it_listens(self, port: int | None = None, advice: str = "") -> None:
        """Wait for a port (default: that of its data); `GranularError` with what rerun said where it ends before."""
        deadline = time.monotonic() + START_SECONDS
        while time.monotonic() < deadline:
            self.require_alive(advice)
            with contextlib.suppress(OSError), socket.create_connection((LOCALHOST, port or self.port), timeout=1.0):
                return
            time.sleep(_POLL_SECONDS)
        raise GranularError(
            f"rerun's viewer did not start in {START_SECONDS:g} s{_after(advice)}", hint=f"it said: {self.messages()}"
        )

    def require_alive(self, advice: str = "") -> None:
        """Raise `GranularError` with what rerun said if it has ended."""
        if (status := self.process.poll()) is not None:
            raise GranularError(
                f"rerun's viewer ended with status {status}{_after(advice)}", hint=f"it said: {self.messages()}"
            )

    def wait(self) -> None:
        """Wait until it ends; `GranularError` where it ends by a fault."""
        if self.process.wait():
            self.require_alive()

    def stop(self) -> None:
        """End it, gently, then not."""
        for number in (signal.SIGTERM, getattr(signal, "SIGKILL", signal.SIGTERM)):
            with contextlib.suppress(ProcessLookupError, PermissionError):
                if os.name == "posix":
                    os.killpg(self.process.pid, number)
                else:
                    self.process.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.process.wait(_END_SECONDS)
                break
        self._messages.close()


@contextlib.contextmanager
def rerun_process(*arguments: str, data: bytes | None = None) -> Iterator[RerunProcess]:
    """Give a process that is stopped when the block ends, or when SIGTERM or SIGHUP ends this process in it."""
    with clean_end():
        process = RerunProcess(*arguments, data=data)
        try:
            yield process
        finally:
            process.stop()


@contextlib.contextmanager
def clean_end() -> Iterator[None]:
    """Let the block clean up when SIGTERM or SIGHUP arrives; then end this process as the signal would have.

    Nothing is changed outside the main thread, or where a program has handlers of its own.
    """

    class End(BaseException):
        """Carries the signal's number out of the block."""

    def on_signal(number: int, frame: Any) -> None:
        raise End(number)

    numbers = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    ours = threading.current_thread() is threading.main_thread()
    taken = [number for number in numbers if ours and signal.getsignal(number) is signal.SIG_DFL]
    for number in taken:
        signal.signal(number, on_signal)
    try:
        yield
    except End as end:
        signal.signal(end.args[0], signal.SIG_DFL)
        signal.raise_signal(end.args[0])
    finally:
        for number in taken:
            signal.signal(number, signal.SIG_DFL)


def rerun_program() -> str:
    """Return the path of rerun's program, the one that belongs to this Python before any other.

    Raises:
        GranularError: there is none.
    """
    package = find_spec("rerun_cli")
    if package is not None and package.origin is not None:
        folder = Path(package.origin).parent
        for name in ("Rerun.app/Contents/MacOS/Rerun", "rerun", "rerun.exe"):
            if (folder / name).is_file():
                return str(folder / name)
    if (found := shutil.which("rerun")) is None:
        raise GranularError(
            "the program `rerun` is not found beside this Python or on PATH",
            hint="run: pip install --force-reinstall rerun-sdk",
        )
    return found


def free_port() -> int:
    """Return a TCP port of 127.0.0.1 that nobody listens on now."""
    with socket.socket() as probe:
        probe.bind((LOCALHOST, 0))
        return probe.getsockname()[1]


def require_screen(advice: Phrase) -> None:
    """Raise `GranularError` with this advice where no window can open."""
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        missing = "no screen: neither DISPLAY nor WAYLAND_DISPLAY is set, so the desktop viewer cannot open"
        raise GranularError(Fault(received=missing, hint=advice))


def _after(advice: str) -> str:
    return f"; {advice}" if advice else ""
