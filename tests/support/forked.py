"""Running Python code in a process of its own, forked from one that has numba loaded and has compiled nothing."""

from __future__ import annotations

import os
import subprocess
import sys
import traceback
from pathlib import Path

from support.forkserver import forkserver


def run_forked(code: str, folder: Path, environment: dict[str, str], files: Path) -> subprocess.CompletedProcess[str]:
    """Run code in a folder, from which it may import, as `python -c` does.

    Args:
        code: what to run.
        folder: it becomes the current one.
        environment: all of the process's environment.
        files: a folder for what the process writes.
    """
    out, errors = files / "stdout", files / "stderr"
    process = forkserver.Process(target=_run, args=(code, folder, environment, out, errors))
    process.start()
    process.join()
    return subprocess.CompletedProcess(code, process.exitcode or 0, out.read_text(), errors.read_text())


def _run(code: str, folder: Path, environment: dict[str, str], out: Path, errors: Path) -> None:
    for number, path in ((1, out), (2, errors)):
        with path.open("w") as file:
            os.dup2(file.fileno(), number)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    sys.path.insert(0, str(folder))
    sys.dont_write_bytecode = True
    try:
        exec(compile(code, "<string>", "exec"), {"__name__": "__main__"})
        status = 0
    except BaseException:
        traceback.print_exc()
        status = 1
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)
