"""The logs in logs/gallery replay bit for bit, and match their descriptions in docs/control.md."""

from pathlib import Path

import numpy as np
import pytest

import granular_env as ge

ROOT = Path(__file__).resolve().parent.parent
LOGS = sorted((ROOT / "logs" / "gallery").glob("*.mcap"))


@pytest.mark.parametrize("path", LOGS, ids=lambda path: path.stem)
def test_a_log_of_the_gallery_replays_bit_for_bit(path: Path) -> None:
    result = ge.verify(path)
    assert result.identical, result.message


def test_the_page_names_every_log() -> None:
    page = (ROOT / "docs" / "control.md").read_text()
    assert LOGS
    for path in LOGS:
        assert f"`{path.stem}`" in page or f"gallery/{path.stem}.mcap" in page


def outside(name: str, crest: int, half: int) -> float:
    """Return the fraction of kinetic energy farther than `half` grains from a crest in the last frame."""
    _, velocity = ge.open_log(ROOT / "logs" / "gallery" / f"{name}.mcap").series("velocity")
    squares = np.asarray(velocity[-1]) ** 2
    return 1.0 - squares[crest - half : crest + half + 1].sum() / squares.sum()


def test_the_shaped_wave_is_alone_and_the_triangles_is_not() -> None:
    assert outside("one-wave", 60, 6) < 1e-9
    triangle = ge.open_log(ROOT / "logs" / "gallery" / "triangle.mcap").series("velocity")[1]
    crest = int(np.argmax(np.asarray(triangle[-1])))
    assert outside("triangle", crest, 6) > 1e-5
