"""The shipped experiments on the solid, against theory."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.solid_tools import RADIUS, WALL, frequency

import granular_env as ge
from granular_env.components.shell.theory import breathing_frequency, lame_displacement, mott_fragments


def test_the_tube_breathes_and_its_log_replays(tmp_path: Path) -> None:
    """With a third of the length, because nothing varies along the tube."""
    path = tmp_path / "tube.mcap"
    overrides = {"component.body.length": 0.02, "component.body.along": 9, "component.gauges": [[0.01, 1.0]], "duration": 6e-5}
    ge.run("gato-shie-2010/breathing-mode", log=path, overrides=overrides)
    time, strain = ge.open_log(path).series("gauge_strain")
    hoop = strain[:, 0, 1]
    outer = RADIUS + WALL
    static = lame_displacement(69e9, 0.33, RADIUS, WALL, 3e6, outer) / outer
    assert hoop.max() / static == pytest.approx(2.0, abs=0.02)
    exact = breathing_frequency(69e9, 0.33, 2719.0, RADIUS + 0.5 * WALL)
    assert frequency(hoop, float(time[1] - time[0])) / exact == pytest.approx(1.0, abs=3e-3)
    assert np.abs(strain[:, 0, 0]).max() < 0.005 * hoop.max()
    assert ge.verify(path).identical


def test_a_rod_that_hits_a_wall_mushrooms() -> None:
    """A coarser rod until it is at rest; it stays symmetric."""
    overrides = {"component.body.along": 16, "component.body.across": 4, "component.step_size": 1e-7, "duration": 4e-5}
    rod: Any = ge.run("gato-shie-2010/taylor-rod", overrides=overrides).component
    place = rod.nodes + rod.get("displacement")
    length = float(np.ptp(place[:, 0]))
    # exp(-rho v^2 / 2 sigma) of Wilkins & Guinan (1973), without hardening, for the flow stress at 1e4/s between zero strain,
    # 1.17 sigma_0, and a strain of one, 1.9 sigma_0.
    least, most = (math.exp(-2719.0 * 200.0**2 / (2.0 * factor * 275e6)) for factor in (1.17, 1.9))
    assert least < length / 0.03 < most
    face = place[rod.nodes[:, 0] == 0.0]
    assert np.ptp(face[:, 1]) > 1.3 * 0.006
    for axis in (1, 2):
        mirrored = rod.nodes.copy()
        mirrored[:, axis] = 0.006 - mirrored[:, axis]
        order, twin = np.lexsort(np.round(rod.nodes, 9).T), np.lexsort(np.round(mirrored, 9).T)
        reflected = place[twin].copy()
        reflected[:, axis] = 0.006 - reflected[:, axis]
        np.testing.assert_allclose(reflected, place[order], rtol=0.0, atol=1e-8)
    assert rod.get("temperature").max() > 350.0
    energy, momentum, _ = rod.balances()
    assert abs(energy.residual) < 0.01 * energy.initial
    assert momentum.entries["wall_impulse"][0] > -momentum.initial[0]  # type: ignore[index]


def test_a_ring_flies_apart_into_about_as_many_pieces_as_mott_counts(tmp_path: Path) -> None:
    path = tmp_path / "ring.mcap"
    ring: Any = ge.run("gato-shie-2010/expanding-ring", log=path, overrides={"record.variables": ["pieces"]}).component
    first = ring.events("point_parted")[0].tick * ring.step_size
    place, velocity = ring.nodes + ring.get("displacement"), ring.get("velocity")
    outwards = (place[:, 1:] * velocity[:, 1:]).sum() / (place[:, 1:] ** 2).sum()
    # The ring breaks at a strain of 0.2 at most. Its speed then is that of the pieces, which store little energy.
    radius = 1.15 * (RADIUS + 0.5 * WALL)
    rate = outwards * np.sqrt((place[:, 1:] ** 2).sum(axis=1)).mean() / radius
    # Each of the 3 * 128 columns breaks at a strain of 0.14 to 0.26; the law gives the flow stress at this strain and rate.
    begun = 3 * 128 / (2.0 * math.pi * radius * 0.12)
    flow = 275e6 * (1.0 + 0.15 / 0.001) ** 0.07 * (rate / 1e-3) ** 0.01
    expected = mott_fragments(radius, rate, flow, 2719.0, begun)
    assert 8.0 < expected < 20.0
    assert ring.get("pieces") == pytest.approx(expected, rel=0.4)
    assert 1.5e-5 < first < 4e-5
    # Neither even nor odd columns are preferred.
    parted = np.unique([event.index // 2 % 128 for event in ring.events("point_parted")])
    assert abs((parted % 2).mean() - 0.5) < 0.1
    energy = ring.balances()[0]
    assert abs(energy.residual) < 1e-4 * energy.supplied["pressure_work"]
    # A run from the first snapshot after some cracks gives the same cracks.
    assert ge.verify(path).identical
