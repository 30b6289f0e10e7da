"""The folder of an atlas: one process computes there at a time, and logs that nobody names any more are removed."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from granular_env.components.errors import GranularError
from granular_env.output_files import lock

PAGE, DATA, LOGS = "index.html", "atlas.json", "logs"
# Ends the name of a log that is still being written.
PART = ".part"
# The name of the file that a process holds while it computes here; ends those of runs, which are beside their logs.
LOCK = ".lock"


@contextmanager
def open_folder(folder: str | os.PathLike[str]) -> Iterator[Path]:
    """Make an atlas's folder if need be, and keep other processes from computing there; returns the folder for its logs.

    What a process that was ended had begun to write is removed, before and after.

    Raises:
        GranularError: it cannot be written, another process computes there, or it holds an `atlas.json` of somebody else.
    """
    place = Path(folder)
    logs = place / LOGS
    with ExitStack() as stack:
        try:
            logs.mkdir(parents=True, exist_ok=True)
            held = stack.enter_context((place / LOCK).open("ab"))
            hint = "wait for it, or choose another folder"
            lock(held, GranularError("another process computes an atlas there", hint=hint, source=f"{str(place)!r}"))
        except OSError as error:
            raise GranularError(
                f"cannot be written: {error}", hint="choose another folder", source=f"{str(place)!r}"
            ) from error
        logs_of_data(place / DATA)
        _remove_parts(logs)
        stack.callback(_remove_parts, logs)
        yield logs


def remove_logs(folder: Path, names: Iterable[str]) -> None:
    """Remove logs that nobody names any more; none while another process computes there, which may want them."""
    with suppress(GranularError), open_folder(folder) as logs:
        for name in names:
            (logs / name).unlink(missing_ok=True)


def _remove_parts(logs: Path) -> None:
    for ending in (PART, LOCK):
        for path in logs.glob(f".*{ending}"):
            path.unlink(missing_ok=True)


def logs_of_data(path: Path) -> set[str]:
    """Return the logs that an earlier atlas names in its data; empty where there is none.

    Only what an atlas may have written counts: logs, by their bare names.

    Raises:
        GranularError: the file is not an atlas's data.
    """
    try:
        data = json.loads(path.read_text("utf-8"))
    except FileNotFoundError:
        return set()
    except (OSError, ValueError, RecursionError) as error:
        raise _foreign(path, str(getattr(error, "strerror", None) or error)) from None
    named = data.get("logs") if isinstance(data, dict) else None
    if not isinstance(named, list):
        raise _foreign(path, "expected an object with a list of logs")
    names = [name for name in named if isinstance(name, str)]
    return {name for name in names if name.endswith(".mcap") and Path(name).name == name}


def _foreign(path: Path, why: str) -> GranularError:
    return GranularError(
        f"{str(path)!r} is not the data of an atlas ({why})",
        hint="an atlas would replace it: remove it, or choose another folder",
    )
