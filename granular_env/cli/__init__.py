"""The command line: parses, calls, prints. One module holds a few related commands; `program` names them all."""

from __future__ import annotations

import sys
from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """See `program.main`; Ctrl-C while that is being imported, which takes a tenth of a second, ends as it does later."""
    try:
        from .program import main as run
    except KeyboardInterrupt:
        print("granular-env: interrupted", file=sys.stderr)
        return 130  # `Status.INTERRUPTED`, which may not be there
    return run(arguments)


__all__ = ["main"]
