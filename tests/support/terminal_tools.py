"""Programs in a real terminal of a given width, and the text visible there."""

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
_CONTROLS = r"\x1b\[[0-9;?]*[A-Za-z]|\x07"  # colours, cursor movements, bell


def run_in_terminal(arguments: list[str], width: int = 80, cwd: Path = ROOT, timeout: float = 300.0) -> tuple[int, str]:
    """Run Python with arguments in a terminal; return its status and output."""
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


def visible_lines(written: str) -> list[str]:
    """Return the lines, including overwritten states of lines, without colours and cursor movements."""
    return [line for line in re.split(r"[\r\n]+", re.sub(_CONTROLS, "", written)) if line.strip()]
