"""Numbering of contacts: place i is left of grain i, the last place right of the last grain; 0 without a contact."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import granular_env as ge
from granular_env.components.chain.adjoint import evaluate_objective
from granular_env.domains.chain import measurement
from granular_env.domains.chain.control import contact_force, total
from granular_env.domains.chain.tasks.protection import make_protection
from granular_env.sweep import run_sweep

GRAINS = 8
ENDS = [("free", "free"), ("plane", "free"), ("free", "rigid_plane"), ("piston", "fixed_grain")]


def struck(left: str, right: str, **parameters: Any) -> ge.Chain:
    chain = ge.Chain(grains=GRAINS, left=left, right=right, **{"step_size": 2e-7} | parameters)
    chain.reset(velocity={2: 0.5, 3: 0.7})
    return chain


@pytest.mark.parametrize(("left", "right"), ENDS)
def test_component_geometry_log_and_history_name_the_same_contact(tmp_path: Path, left: str, right: str) -> None:
    chain = struck(left, right)
    with ge.record(
        chain, tmp_path / "run.mcap", every=1e-6, variables=["velocity", "displacement", "contact_force", "overlap"]
    ):
        chain.reset(velocity={2: 0.5, 3: 0.7})
        chain.step(2e-5)
    live, rest = chain.get("contact_force"), chain.geometry.rest_overlap
    u = chain.get("displacement")
    by_hand = rest[1:-1] - np.diff(u)
    assert chain.variables["contact_force"].shape == chain.variables["overlap"].shape == (GRAINS + 1,)
    np.testing.assert_allclose(chain.get("overlap")[1:-1], by_hand, rtol=1e-12, atol=1e-20)
    np.testing.assert_allclose(live, chain.geometry.stiffness * np.maximum(chain.get("overlap"), 0.0) ** 1.5, rtol=1e-12)
    with ge.open_log(tmp_path / "run.mcap") as log:
        history = measurement.history(log)
        np.testing.assert_array_equal(log.series("contact_force")[1][-1], live)
        np.testing.assert_array_equal(log.series("overlap")[1], history.overlap)
    np.testing.assert_array_equal(history.contact_force[-1], live)
    assert np.count_nonzero(live) >= 3 and np.isfinite(history.overlap).all()
    for place, end in ((0, left), (-1, right)):
        if end in ("free", "piston"):
            assert live[place] == chain.get("overlap")[place] == 0.0


def test_sensors_objectives_and_sweeps_count_as_the_output_does(tmp_path: Path) -> None:
    env = make_protection(grains=GRAINS, clock=0, observe={"contact_force": [2, -3]}, deadline=None)
    env.reset(seed=0)
    for _ in range(20):
        observation, *_ = env.step(np.array([0.8], np.float32))
    force = env.component.get("contact_force")
    assert force[2] != force[-3]
    np.testing.assert_allclose(observation, force[[2, -3]] / 500.0, rtol=2e-7)
    chain = struck("free", "free")
    value = float(evaluate_objective(chain, np.zeros((1, 10, 2)), 2, total(chain, contact_force(4).at_end()))[0])
    chain.step(20 * chain.step_size)
    assert value == pytest.approx(chain.get("contact_force")[4], rel=1e-12)
    settings = {
        "duration": 4e-6, "component.grains": GRAINS, "component.step_size": 2e-7, "start.velocity.2": 0.5,
        "start.velocity.3": 0.7,
    }  # fmt: skip
    done = ge.run("nesterenko-1983/3.1-one-grain", overrides=settings)
    plan = {
        "version": 1, "name": "numbering", "experiment": "nesterenko-1983/3.1-one-grain", "set": settings,
        "grid": {"component.left": ["free", "plane"]},
        "measure": {"fourth": "final contact_force[4]", "end": "max contact_force[-1]"},
    }  # fmt: skip
    table = run_sweep(plan, tmp_path / "out", engine="serial").table
    assert list(table["fourth"]) == [done.component.get("contact_force")[4]] * 2 != [0.0, 0.0]
    assert list(table["end"]) == [0.0, 0.0]


def test_lists_of_stiffness_gap_and_losses_have_the_places_of_the_outputs() -> None:
    given = {"contact_stiffness": [0.0, 1e9, 2e9, 3e9], "gap": [0.0, 1e-6, 0.0, 2e-6]}
    chain = ge.Chain(grains=3, right="plane", law={"name": "viscous", "dissipation": [0.0, 1.0, 2.0, 3.0]}, **given)
    assert chain.geometry.stiffness.tolist() == given["contact_stiffness"]
    assert chain.geometry.law_constants[:, 0].tolist() == [0.0, 1.0, 2.0, 3.0]
    assert chain.get("overlap").tolist() == pytest.approx([0.0, -1e-6, 0.0, -2e-6], abs=1e-18)
    # Values from the geometry are valid parameters.
    again = ge.Chain(grains=3, right="plane", contact_stiffness=chain.geometry.stiffness)
    assert np.array_equal(again.geometry.stiffness, chain.geometry.stiffness)
