"""Confinement-v3: returns of pressures, theoretical pressure, and conformance of the environment."""

from __future__ import annotations

import copy
import pickle

import gymnasium
import numpy as np
import pytest

import granular_env as ge
from granular_env.components.automata.theory import confined_strength, confining_pressure, platen_stress
from granular_env.components.errors import ParameterError
from granular_env.domains.automata.tasks.confinement import interpolate_drive, make_confinement
from granular_env.envs.policies import play

NAME = "granular_env/Confinement-v3"
SCALE = 6e7  # Pa at action 1


@pytest.fixture(scope="module")
def returns() -> dict[str, tuple[float, dict]]:
    """Return the return and the last info of each baseline."""
    env = gymnasium.make(NAME).unwrapped
    return {name: play(env, policy, seed=0) for name, policy in env.task.baselines().items()}


def test_without_pressure_the_specimen_bursts_and_the_more_is_known_the_better(returns) -> None:
    assert returns["nothing"][0] == pytest.approx(-1.0)
    assert returns["nothing"][1]["broken_part"] > 0.3 and returns["nothing"][1]["time"] < 0.5 * 2.5e-4
    order = [returns[name][0] for name in ("nothing", "constant", "theory", "best")]
    assert order == sorted(order)
    # Pinned to three digits, because the docstring and the page state them.
    assert [round(value, 3) for value in order[1:]] == [-0.296, -0.089, -0.063]
    # The threshold is the worst return of 100 samples, -0.103; this sample returns -0.089.
    assert gymnasium.spec(NAME).reward_threshold == pytest.approx(returns["theory"][0], abs=0.02)
    assert returns["theory"][0] > gymnasium.spec(NAME).reward_threshold
    assert returns["theory"][1]["broken_part"] < 0.01 and returns["best"][1]["broken_part"] < 0.05


def test_the_return_is_what_broke_and_what_the_pressure_cost(returns) -> None:
    env = gymnasium.make(NAME).unwrapped
    for name in ("constant", "theory"):
        policy = env.task.baselines()[name]
        drive = np.full(50, 0.5) if name == "constant" else policy.drive[:, 0]
        followed = np.minimum(drive, 0.05 * (1.0 + np.arange(50)))  # largest rate of the pressure
        mean = float(followed.mean())
        assert returns[name][0] == pytest.approx(-returns[name][1]["broken_part"] - 0.2 * mean, abs=1e-6)


def test_each_episode_draws_its_strengths() -> None:
    """The reset's seed sets the strengths, a saved state contains them, and `strength_seed` fixes them for all episodes."""
    env = make_confinement(deadline=4, internal_steps=2)

    def strengths(seed: int | None) -> np.ndarray:
        env.reset(seed=seed)
        return env.component.specimen.medium.law.factors

    first, second = strengths(1), strengths(2)
    assert (first != second).any() and (first == strengths(1)).all() and (first != strengths(None)).any()
    assert env.randomization.parameters
    env.reset(seed=1)
    state = env.save()
    env.reset(seed=2)
    env.restore(state)
    np.testing.assert_array_equal(env.component.specimen.medium.law.factors, first)
    one = make_confinement(strength_seed=3, deadline=4, internal_steps=2)
    one.reset(seed=1)
    assert not one.randomization.parameters and one.component.parameters.strength_seed == 3
    with pytest.raises(ParameterError, match="strength_seed"):
        one.restore(state)


def test_both_sides_are_pressed_and_the_middle_bears_what_theory_says() -> None:
    env = make_confinement(strength_seed=3)
    env.reset(seed=0)
    for part in interpolate_drive([0.0, 0.3], 25):
        env.step([part])
    pressure = SCALE * float(np.float32(part))
    left, right = (float(env.component.get(f"{side}_traction")[0]) for side in ("left", "right"))
    assert left == -right == pytest.approx(pressure)
    height = env.component.packing.reference[:, 1]
    middle = np.abs(height - height.mean()) < 0.15 * np.ptp(height)
    xx, yy, _ = env.component.get("stress")[middle].mean(axis=0)
    # The load rises within ten P-wave transits of the specimen, which leaves oscillations of a few percent.
    assert -xx == pytest.approx(pressure, rel=0.1)
    assert -yy == pytest.approx(platen_stress(1.75e-3, pressure, 5e10, 0.25), rel=0.05)


def test_theory_is_consistent() -> None:
    for cohesion in (0.0, 1e7):
        pressure = confining_pressure(3e-3, 5e10, 0.25, 0.4, cohesion)
        assert pressure > 0.0
        assert platen_stress(3e-3, pressure, 5e10, 0.25) == pytest.approx(confined_strength(pressure, cohesion, 0.4))
    # Tractions on faces whose normals lie at 60 degrees to the rows.
    p, q, cohesion = 2e7, confined_strength(2e7, 1e7, 0.4), 1e7
    normal = np.array([0.5, np.sqrt(0.75)])
    traction = np.diag([-p, -q]) @ normal
    along = float(normal @ traction)
    across = np.sqrt(traction @ traction - along * along)
    assert across + 0.4 * along == pytest.approx(cohesion)
    assert confining_pressure(1e-4, 5e10, 0.25, 0.4, cohesion) == 0.0 and confined_strength(p, cohesion, 0.6) == np.inf


def test_saved_states_and_copies_go_on_with_the_same_bits_also_while_it_cracks() -> None:
    env = make_confinement(strain=7e-3, deadline=24, lost=0.9)
    env.reset(seed=1)
    for _ in range(12):
        env.step([0.1])
    assert env.component.get("broken_links") > 0
    state = env.save()
    others = [copy.deepcopy(env), pickle.loads(pickle.dumps(env)), make_confinement(strain=7e-3, deadline=24, lost=0.9)]
    others[-1].reset(seed=1)
    others[-1].restore(state)
    for one in (env, *others):
        one.step([0.5])
    for one in others:
        np.testing.assert_array_equal(env.component.get("velocity"), one.component.get("velocity"))
        assert one.task.counters == env.task.counters


def test_an_episode_is_recorded_with_the_loads_that_the_task_adds(tmp_path) -> None:
    env = make_confinement(deadline=4, internal_steps=5)
    env.reset(seed=0)
    with ge.record(env.component, tmp_path / "episode.mcap", variables=["velocity", "linked"]):
        env.reset(seed=0)  # the same specimen again
        for _ in range(4):
            env.step(np.array([0.1], np.float32))
    with ge.open_log(tmp_path / "episode.mcap") as log:
        assert list(log.input_intervals("right_traction"))[-1].value.tolist() == pytest.approx([-0.1 * SCALE, 0.0])
    assert ge.verify(tmp_path / "episode.mcap").identical
