"""The suggested step of a chain under a static load: no warning from the guard, and the stated accuracy of velocities."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from support.chain_tools import laws_and_integrators

import granular_env as ge

POWERS = [{"name": "power", "exponent": exponent} for exponent in (1.3, 2.0)]


@pytest.mark.parametrize("radius", [1e-3, 1e-2])
@pytest.mark.parametrize(("law", "scheme"), laws_and_integrators(["hertz", *POWERS]))
def test_no_default_step_of_a_pressed_chain_is_warned_of(law: Any, scheme: str, radius: float) -> None:
    stiffness = {} if law == "hertz" else {"contact_stiffness": 1e11 ** (law["exponent"] / 1.5)}
    for force in (0.1, 10.0, 100.0, 1000.0):
        for speed in (1e-4, 1e-2, 1.0):
            for right in ("free", "plane"):
                chain = ge.make(
                    "chain", grains=12, radius=radius, precompression=force, velocity_scale=speed, right=right,
                    integrator=scheme, overlap_limit=0.5, law=law, **stiffness,
                )  # fmt: skip
                chain.reset(velocity={0: speed})
                with warnings.catch_warnings():
                    warnings.simplefilter("error")
                    chain.step(200 * chain.step_size)
                assert not [said for said in chain.cautions() if "evaluations" in said], (force, speed, right)


@pytest.mark.parametrize(("scheme", "bound"), [("pefrl", 3e-5), ("leapfrog", 2e-4), ("rk4", 1e-4), ("hamming", 1e-4)])
def test_the_default_step_of_a_pressed_chain_is_as_exact_as_said(scheme: str, bound: float) -> None:
    for radius, force in ((2e-3, 10.0), (5e-3, 1000.0), (3e-3, 100.0)):
        given = {"grains": 20, "radius": radius, "precompression": force, "velocity_scale": 1e-3}
        chain = ge.make("chain", integrator=scheme, **given)
        reference = ge.make("chain", step_size=chain.step_size / 50, **given)
        for one in (chain, reference):
            one.reset(velocity={0: 1e-3})
            one.step(400 * chain.step_size)
        assert np.abs(chain.get("velocity") - reference.get("velocity")).max() < bound * 1e-3, (radius, force)
