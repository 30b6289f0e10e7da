"""What an atlas tells its progress bar."""

from __future__ import annotations

from collections.abc import Sequence


def assert_shares(told: Sequence[tuple[str, float]], entry: str, runs: int) -> None:
    """The shares told of an entry are those of its whole runs, in order; a long run may add some of its parts,
    the last of which may be its end."""
    own, steps = [share for name, share in told if name == entry], runs + 1
    ends = sorted({round(share * steps) for share in own if abs(share * steps - round(share * steps)) < 1e-9})
    assert ends == list(range(steps + 1)) and own == sorted(own), entry
