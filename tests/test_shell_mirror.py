"""A symmetric tube, whole and half: degree of agreement, and differences."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import granular_env as ge

ALONG, AROUND, HALF = 25, 60, 31
STEP, PRESSURE = 1.9e-8, 8e6


def notched_tube(half: bool) -> Any:
    """Return a tube with a notch centred in the plane y = 0."""
    notch = {"length": 0.006, "depth": 0.0006, "width": 0.0005}
    body = {"name": "tube", "length": 0.02, "along": ALONG, "around": HALF if half else AROUND, "half": half, "notch": notch}
    return ge.make(
        "shell", body=body, material="thermoviscoplastic", boundaries={"start": "clamped", "end": "clamped"},
        fracture={"name": "principal_stress", "factor": 1.3}, step_size=STEP,
    )  # fmt: skip


def first_stations(tube: Any, around: int) -> dict[int, int]:
    """Return the positions along the tube at which the ligament (three columns) breaks, and the times [ticks]."""
    ticks: dict[int, int] = {}
    for event in tube.events("point_parted"):
        along, place = divmod(event.index // 2, around)
        assert min(place, AROUND - place) <= 1
        ticks.setdefault(along, event.tick)
    return ticks


def test_a_full_tube_is_its_mirror_image_until_it_parts_and_a_half_tube_parts_first_at_the_same_places() -> None:
    full, half = notched_tube(half=False), notched_tube(half=True)
    ring = full.lattice.axes[1].positions
    twins = np.array([np.abs((2.0 * math.pi - angle) % (2.0 * math.pi) - ring).argmin() for angle in ring])
    assert twins[0] == 0 and twins[1] == AROUND - 1
    full.step(190 * STEP, pressure=PRESSURE)
    moved = full.get("nodal_displacement").reshape(ALONG, AROUND, -1, 3)
    image = moved[:, twins] * [1.0, -1.0, 1.0]
    assert full.event_count == 0
    assert np.abs(moved - image).max() < 1e-12 * np.abs(moved).max()
    half.step(190 * STEP, pressure=PRESSURE)
    own = half.get("nodal_displacement").reshape(ALONG, HALF, -1, 3)
    # One-sided functions at the plane of symmetry: the same body with lower resolution.
    assert 0.01 < np.abs(own - moved[:, :HALF]).max() / np.abs(moved).max() < 0.06
    for tube in (full, half):
        tube.step(60 * STEP, pressure=PRESSURE)
    first, other = first_stations(full, AROUND), first_stations(half, HALF)
    assert set(first) == set(other) == set(range(8, 17))
    assert next(iter(first)) == next(iter(other)) == 12
    for ticks in (first, other):
        assert all(ticks[12 - apart] == ticks[12 + apart] for apart in (1, 2, 3, 4))
    # Within the travel time of sound over two spacings along the tube, 0.33 us.
    assert all(abs(first[along] - other[along]) * STEP < 2.0 * 0.02 / (ALONG - 1) / 5040.0 for along in first)
