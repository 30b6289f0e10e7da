"""Crack openings: gaps between columns, across pieces and lips, in rows and rings."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from granular_env.components.shell.fracture.open_area import crack_openings


def row(moved: list[float], cut: set[int], severed: set[int]) -> Any:
    """Return the openings of a straight row of columns 1 mm apart, moved along it [mm]."""
    count = len(moved)
    rest = np.zeros((1, count, 3))
    rest[0, :, 0] = np.arange(count)
    marks: Any = [np.array([[link in some for link in range(count)]]) for some in (cut | severed, severed)]
    places: Any = rest + np.array(moved)[:, None] * [1.0, 0.0, 0.0]
    return crack_openings(marks[0], marks[1], places, rest, is_closed=False)[0]


def test_a_gap_is_how_far_its_sides_have_moved_apart() -> None:
    assert row([0.0, 0.0, 0.0, 0.3, 0.3, 0.3], set(), {2}) == pytest.approx([0.0, 0.0, 0.3, 0.0, 0.0, 0.0])
    # A closed gap does not count.
    assert not row([0.0, 0.0, 0.0, -0.3, -0.3, -0.3], set(), {2}).any()
    assert not row([0.0, 0.0, 0.0, 0.3, 0.3, 0.3], {2}, set()).any()


def test_a_strip_between_two_cracks_closes_no_gap_and_opens_none() -> None:
    for place in (-0.4, 0.0, 0.1, 0.3, 2.0):
        assert row([0.0, 0.0, 0.0, place, 0.3, 0.3], set(), {2, 3}) == pytest.approx([0.0, 0.0, 0.15, 0.15, 0.0, 0.0])
    # The column is not severed on both sides.
    assert row([0.0, 0.0, 0.0, 0.9, 0.3, 0.3], {3}, {2}) == pytest.approx([0.0, 0.0, 0.3, 0.0, 0.0, 0.0])


def test_a_lip_that_swings_back_opens_no_wider_gap() -> None:
    assert row([0.0, 0.0, -0.5, 0.3, 0.3, 0.3], set(), {2}).max() == pytest.approx(0.3)
    assert row([0.0, 0.0, 0.0, 0.8, 0.3, 0.3], set(), {2}).max() == pytest.approx(0.3)


def ring() -> Any:
    """Return the positions of 48 columns around a ring, shape (1, 48, 3)."""
    angle = np.arange(48) * np.pi / 24.0
    return np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)[None]


@pytest.mark.parametrize("holding", [[], [0], [3], [0, 24], [2, 3, 4, 5]])
def test_a_ring_in_pieces_gapes_by_what_it_has_grown(holding: list[int]) -> None:
    """All distances grow by half, and each broken link has opened by the same amount."""
    rest = ring()
    cut = np.array([[link not in holding for link in range(48)]])
    found = crack_openings(cut, cut, 1.5 * rest, rest, is_closed=True)
    assert found.sum() == pytest.approx(np.sin(np.pi / 48.0) * cut.sum(), rel=0.02)
    assert not found[~cut].any()
