"""Constants, rewards, goals, gradients and drives do not depend on the instruction sets used by libraries."""

from __future__ import annotations

import numpy as np
import pytest
from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__  # type: ignore[attr-defined]
from support.chain_tools import run_python

from granular_env.components.support.elementary_functions import (
    exponential,
    fourier,
    logarithm,
    natural_spline,
    root,
    sine_of_pi,
)

FEATURES = [name for name in __cpu_dispatch__ if __cpu_features__.get(name)]
HASHES = """
import hashlib
import gymnasium as gym
import numpy as np
import granular_env
from granular_env.domains.chain.control import value_and_grad

CASES = [
    ("PulseForming-v1", {}), ("PulseForming-v1", {"action": "piston", "chain": {"precompression": 10.0}}),
    ("SolitonTrain-v1", {}), ("EnergyDelivery-v1", {}), ("EnergyDelivery-v1", {"chain": {"precompression": 10.0}}),
    ("Protection-v1", {}), ("Absorption-v1", {}), ("Piston-v1", {}),
]

def said(*values):
    return hashlib.sha256(b"".join(np.asarray(value, dtype=np.float64).tobytes() for value in values)).hexdigest()[:12]

found = {}
for name, arguments in CASES:
    env = gym.make(f"granular_env/{name}", **arguments).unwrapped
    task, what = env.task, f"{name} {arguments}"
    found[f"{what}: constants"] = said(*(np.ravel(one) for one in task.constants or ()))
    observation, info = env.reset(seed=4)
    policy = task.baselines().get("theory")
    theory = []
    if policy is not None:
        policy.reset()
    rewards = []
    for _ in range(60):
        action = [0.3] if policy is None else policy(observation, info)
        observation, reward, *_, info = env.step(action)
        theory.append(action)
        rewards.append(reward)
    found[f"{what}: theory"] = said(*theory)
    found[f"{what}: rewards"] = said(*rewards)
    found[f"{what}: episode"] = hashlib.sha256(env.save().snapshot.to_bytes()).hexdigest()[:12]
    if name != "Piston-v1":
        env.reset(seed=4)
        drive = np.full((40, 2), 20.0 if "force" in next(iter(task.actions)) else 0.5)
        value, slopes = value_and_grad(task, env.component, drive, ticks=3)
        found[f"{what}: gradient"] = said(value, slopes["drive"])
print(found)
"""


@pytest.mark.slow  # it compiles an environment without them
@pytest.mark.skipif(not FEATURES, reason="this CPU has nothing that numpy's baseline does not use")
def test_without_the_newer_instructions_environments_are_the_same() -> None:
    """The vector paths of NumPy, the C library and BLAS: as available, and as on the oldest x86-64."""
    oldest = {
        "NPY_DISABLE_CPU_FEATURES": " ".join(FEATURES), "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F",
        "OPENBLAS_CORETYPE": "Prescott",
    }  # fmt: skip
    assert run_python(HASHES, **oldest) == run_python(HASHES)


def test_the_functions_are_those_that_they_are_called_after() -> None:
    x = np.linspace(-300.0, 300.0, 2001)
    large = np.exp(x)
    assert exponential(x) == pytest.approx(large, rel=1e-15)
    assert logarithm(large) == pytest.approx(x, abs=1e-13)
    assert logarithm(1.0 + 1e-9) == pytest.approx(np.log(1.0 + 1e-9), rel=1e-15)
    for degree in (2, 5, 6):
        found = root(large, degree)
        assert found**degree == pytest.approx(large, rel=1e-14)
    assert sine_of_pi(np.arange(-8, 9) / 2.0).tolist() == [0.0, 1.0, 0.0, -1.0] * 4 + [0.0]
    assert sine_of_pi(x / 7.0) == pytest.approx(np.sin(np.pi * np.remainder(x / 7.0, 2.0)), abs=4e-15)


def test_the_transform_and_the_spline_agree_with_those_of_the_libraries() -> None:
    from scipy.interpolate import CubicSpline

    rng = np.random.default_rng(1)
    for count in (1, 2, 64, 1024):
        a, b = rng.normal(size=(2, count))
        real, imaginary = fourier(a, b)
        wanted = np.fft.fft(a + 1j * b)
        assert real == pytest.approx(wanted.real, abs=1e-12) and imaginary == pytest.approx(wanted.imag, abs=1e-12)
    values = rng.normal(size=30)
    spline = CubicSpline(np.arange(30), values, bc_type="natural")
    assert natural_spline(values, 8) == pytest.approx(spline(np.arange(29 * 8 + 1) / 8), abs=1e-13)
