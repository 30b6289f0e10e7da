"""A chain in equilibrium under its weight and a static load stays at rest; if no equilibrium exists, this is reported."""

from __future__ import annotations

import numpy as np
import pytest
from support.chain_tools import laws_and_integrators

import granular_env as ge

G = 9.81
LAWS = [
    "hertz",
    {"name": "power", "exponent": 1.3},
    {"name": "power", "exponent": 1.0},
    {"name": "kuwabara_kono", "dissipation": 1e3},
    {"name": "viscous", "dissipation": 1.0},
    {"name": "elastic_plastic", "yield_pressure": 2e8},
]


@pytest.mark.parametrize(("law", "integrator"), laws_and_integrators(LAWS, ["pefrl", "rk4"]))
@pytest.mark.parametrize(
    ("left", "right", "gravity", "precompression"),
    [("free", "plane", G, 0.0), ("free", "piston", G, 3.0), ("rigid_plane", "free", -G, 0.5), ("plane", "plane", G, 2.0),
     ("plane", "plane", -G, 0.0), ("fixed_grain", "free", G, 50.0), ("piston", "plane", -G, 1.0)],
)  # fmt: skip
def test_it_stays_at_rest(law: object, integrator: str, left: str, right: str, gravity: float, precompression: float) -> None:
    chain = ge.Chain(
        grains=8, law=law, integrator=integrator, left=left, right=right, gravity=gravity, precompression=precompression,
        contact_stiffness=1e7 if law == {"name": "power", "exponent": 1.0} else 6e9,
    )  # fmt: skip
    forces, weight = chain.get("contact_force"), chain.geometry.mass * gravity
    chain.step(500 * chain.step_size)
    # A free grain would have reached the velocity g t.
    assert np.abs(chain.get("velocity")).max() < 1e-9 * abs(gravity) * chain.time
    assert chain.get("contact_force") == pytest.approx(forces, rel=1e-9)
    # Every grain without a prescribed motion is supported.
    ends = [chain.geometry.static_force[0], chain.geometry.static_force[-1]]
    carried = np.diff(chain.geometry.static_force)
    free = slice(1 if left == "piston" else 0, -1 if right == "piston" else None)
    assert carried[free] == pytest.approx(weight[free], rel=1e-12)
    assert min(*ends, *forces) >= 0.0
    assert abs(chain.get("momentum_residual")) < 1e-9 * abs(weight.sum()) * chain.time


def test_a_column_weighs_on_its_floor() -> None:
    chain = ge.Chain(grains=20, right="plane", gravity=G)
    assert chain.get("right_wall_force") == pytest.approx(-chain.geometry.mass.sum() * G, rel=1e-12)
    assert chain.get("contact_force")[1] == pytest.approx(chain.geometry.mass[0] * G, rel=1e-12)


def test_grains_with_gaps_fall_and_bounce() -> None:
    height = 1e-3
    chain = ge.Chain(grains=1, right="rigid_plane", gap=height, gravity=G, velocity_scale=0.1)
    fall = (2.0 * height / G) ** 0.5
    chain.step(round(0.99 * fall / chain.step_size) * chain.step_size)
    assert chain.get("displacement")[0] == pytest.approx(0.5 * G * chain.time**2, rel=1e-9)
    assert chain.get("velocity")[0] == pytest.approx(G * chain.time, rel=1e-9)
    chain.step(round(0.5 * fall / chain.step_size) * chain.step_size)
    assert chain.get("velocity")[0] < 0.0
    balances = chain.balance_values()
    assert abs(balances["energy_residual"]) < 1e-6 * chain.geometry.mass[0] * G * height
    # The residual of floor force and weight is the rounding error of 4 kicks in each of about 100,000 steps.
    assert abs(balances["momentum_residual"]) < 4e5 * 2.0**-53 * chain.geometry.mass[0] * G * fall
