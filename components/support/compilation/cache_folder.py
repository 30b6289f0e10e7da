"""The folder that keeps compiled kernels: the user's own, since what lies in it is run."""

from __future__ import annotations

import os
import stat
from functools import cache
from pathlib import Path

from ..notice import tell


@cache
def cache_folder() -> Path | None:
    """Return where compiled kernels are kept, in ``GRANULAR_ENV_CACHE`` or the user's cache; None if they cannot be."""
    try:
        base = cache_base()
        folder = base / "kernels"
        for path in (base, folder):
            if not path.is_dir():
                path.mkdir(mode=0o700, parents=True, exist_ok=True)
                path.chmod(0o700)  # whatever the umask is
    except (OSError, RuntimeError) as error:  # a RuntimeError: there is no home
        reason = getattr(error, "strerror", None) or str(error)
        tell(f"compiled kernels cannot be kept ({reason}): they are compiled in every process; set GRANULAR_ENV_CACHE")
        return None
    stranger = next((path for path in (folder, base) if _others_may_write(path)), None)
    if stranger is not None:
        tell(
            f"compiled kernels are not kept in {folder}: others may write to {stranger}, and what lies there is run; "
            "set GRANULAR_ENV_CACHE to a folder of your own, or take the right from them (chmod go-w)"
        )
        return None
    return folder


def cache_base() -> Path:
    """Return ``GRANULAR_ENV_CACHE``, else the package's folder in the user's cache."""
    given = os.environ.get("GRANULAR_ENV_CACHE")
    if given:
        return Path(given)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "granular-env"


def _others_may_write(path: Path) -> bool:
    """Return whether somebody else than the user and root may put files there, or replace the user's."""
    if not hasattr(os, "geteuid"):
        return False
    status = path.stat()
    writable, sticky = status.st_mode & (stat.S_IWGRP | stat.S_IWOTH), status.st_mode & stat.S_ISVTX
    ours = status.st_uid in (os.geteuid(), 0)
    return not ours or bool(writable and not sticky)
