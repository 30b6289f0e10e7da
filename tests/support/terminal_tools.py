"""Programs in a real terminal of a given width, and what a person would see there."""

import fcntl
import os
import pty
import re
import select
import struct
import subprocess
import sys
import termios
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
_CONTROLS = r"\x1b\[[0-9;?]*[A-Za-z]|\x07"  # colours, movements of the cursor, the bell


def run_in_terminal(arguments: list[str], width: int = 80, cwd: Path = ROOT, timeout: float = 300.0) -> tuple[int, str]:
    """Run Python with arguments in a terminal; return its status and all that it wrote."""
    try:
        parent, child = pty.openpty()
    except OSError as error:
        pytest.skip(f"no terminal can be made here: {error}")
    fcntl.ioctl(child, termios.TIOCSWINSZ, struct.pack("HHHH", 24, width, 0, 0))
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "TERM": "xterm-256color"}
    for name in ("COLUMNS", "LINES", "NO_COLOR", "FORCE_COLOR"):
        environment.pop(name, None)
    process = subprocess.Popen(
        [sys.executable, *arguments], stdin=child, stdout=child, stderr=child, cwd=cwd, env=environment, start_new_session=True
    )
    os.close(child)
    written, end = b"", time.monotonic() + timeout
    try:
        while time.monotonic() < end:
            if select.select([parent], [], [], 0.1)[0]:
                try:
                    piece = os.read(parent, 65536)
                except OSError:  # Linux: the other side is closed
                    break
                if not piece:
                    break
                written += piece
        return process.wait(timeout=60), written.decode(errors="replace")
    finally:
        process.kill()
        os.close(parent)


class Terminal:
    """An interactive program in a terminal, and a person at its keys."""

    def __init__(self, arguments: list[str], cwd: Path, environment: dict[str, str]) -> None:
        self._arguments, self._cwd = arguments, cwd
        self._environment = {**os.environ, "TERM": "xterm-256color", **environment}

    def __enter__(self) -> "Terminal":
        try:
            self._parent, child = pty.openpty()
        except OSError as error:
            pytest.skip(f"no terminal can be made here: {error}")
        fcntl.ioctl(child, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 120, 0, 0))
        self._process = subprocess.Popen(
            self._arguments,
            stdin=child,
            stdout=child,
            stderr=child,
            cwd=self._cwd,
            env=self._environment,
            start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
        )
        os.close(child)
        return self

    def type(self, text: str) -> None:
        """Press keys, once the program has been silent for a moment."""
        while self._read(0.3):
            pass
        os.write(self._parent, text.encode())

    def wait_for(self, text: str, timeout: float = 60.0) -> None:
        """Wait until the program has written a text since keys were last pressed."""
        written, end = "", time.monotonic() + timeout
        while text not in re.sub(_CONTROLS, "", written):
            assert time.monotonic() < end, f"{text!r} was not written, but {written!r}"
            written += self._read(0.1)

    def _read(self, timeout: float) -> str:
        ready, _, _ = select.select([self._parent], [], [], timeout)
        return os.read(self._parent, 65536).decode(errors="replace") if ready else ""

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()
        os.close(self._parent)


def seen_lines(written: str) -> list[str]:
    """Return the lines, and states of lines that were written over, without colours and cursor movements."""
    return [line for line in re.split(r"[\r\n]+", re.sub(_CONTROLS, "", written)) if line.strip()]
