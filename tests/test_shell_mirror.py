"""A tube that is its own mirror image, whole and half: how far both agree, and where they do not."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import granular_env as ge

ALONG, AROUND, HALF = 25, 60, 31
STEP, PRESSURE = 2e-8, 8e6


def notched_tube(half: bool) -> Any:
    """Return a tube with a notch whose middle lies in the plane y = 0."""
    notch = {"length": 0.006, "depth": 0.0006, "width": 0.0005}
    body = {"name": "tube", "length": 0.02, "along": ALONG, "around": HALF if half else AROUND, "half": half, "notch": notch}
    return ge.make(
        "shell", body=body, material="thermoviscoplastic", boundaries={"start": "clamped", "end": "clamped"},
        fracture={"name": "principal_stress", "factor": 1.3}, step_size=STEP,
    )  # fmt: skip


def first_columns(tube: Any, around: int) -> list[tuple[int, int]]:
    """Return the columns of the first seven points that have parted, one at a time or in pairs, sorted in each tick."""
    events = sorted((event.tick, *divmod(event.index // 2, around)) for event in tube.events("point_parted"))
    return [(along, place) for _, along, place in events[:7]]


def test_a_full_tube_is_its_mirror_image_until_it_parts_and_a_half_tube_parts_first_at_the_same_places() -> None:
    full, half = notched_tube(half=False), notched_tube(half=True)
    ring = full.lattice.axes[1].positions
    twins = np.array([np.abs((2.0 * math.pi - angle) % (2.0 * math.pi) - ring).argmin() for angle in ring])
    assert twins[0] == 0 and twins[1] == AROUND - 1
    full.step(200 * STEP, pressure=PRESSURE)
    moved = full.get("nodal_displacement").reshape(ALONG, AROUND, -1, 3)
    image = moved[:, twins] * [1.0, -1.0, 1.0]
    assert full.event_count == 0
    assert np.abs(moved - image).max() < 1e-12 * np.abs(moved).max()
    half.step(200 * STEP, pressure=PRESSURE)
    own = half.get("nodal_displacement").reshape(ALONG, HALF, -1, 3)
    # One-sided functions at the plane of symmetry: the same body, less well resolved.
    assert 0.01 < np.abs(own - moved[:, :HALF]).max() / np.abs(moved).max() < 0.1
    for tube in (full, half):
        tube.step(45 * STEP, pressure=PRESSURE)
    assert first_columns(full, AROUND) == first_columns(half, HALF)
    assert first_columns(full, AROUND) == [(12, 0), (11, 0), (13, 0), (10, 0), (14, 0), (9, 0), (15, 0)]
