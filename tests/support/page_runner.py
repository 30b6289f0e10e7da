"""Run the snippets of a documentation page in a process forked from the fork server, which has imported the large packages."""

import contextlib
import io
import os
import shlex
import subprocess
import sys
import traceback
from pathlib import Path

from support.forkserver import forkserver

Snippet = tuple[str, str, str, list[str]]


def run_page(snippets: list[Snippet], folder: Path) -> str:
    """Run a page's snippets (kind or file, place, content, expected lines) in a folder; return the errors, or ""."""
    errors = folder.with_suffix(".errors")
    process = forkserver.Process(target=_run_snippets, args=(snippets, folder, errors))
    process.start()
    process.join()
    return "" if process.exitcode == 0 else errors.read_text()


def _run_snippets(snippets: list[Snippet], folder: Path, errors: Path) -> None:
    with errors.open("w") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    os.chdir(folder)
    sys.path.insert(0, str(folder))
    names = {"__name__": "__main__"}
    try:
        for kind, where, code, promised in snippets:
            if kind == "bash":
                _run_commands(code)
            elif kind == "python":
                _run_python(where, code, promised, names)
            else:
                Path(kind).write_text(code)
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
        os._exit(1)


def _run_python(where: str, code: str, promised: list[str], names: dict[str, object]) -> None:
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(code, where, "exec"), names)
    lines = printed.getvalue().splitlines()
    # A line in a loop prints several lines, which the page shows on one line.
    if promised and " ".join(lines) != " ".join(promised):
        raise AssertionError(f"{where}: the page promises {promised}, the code printed {lines}")


def _run_commands(code: str) -> None:
    """Run shell lines: plain granular-env commands in this process, all others with bash."""
    from granular_env.cli import main

    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    for line in code.replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        if words[:1] != ["granular-env"] or set(line) & set("|><&;$`*"):
            subprocess.run(["bash", "-eu", "-o", "pipefail", "-c", line], check=True, env={**os.environ, "PATH": path})
        elif status := main(words[1:]):
            raise AssertionError(f"{line}: exit status {status}")
