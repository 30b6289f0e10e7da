"""A task in a study: the batch, the single environment and the objective agree."""

import sys
from types import ModuleType

import numpy as np
import pytest
from gymnasium.vector import SyncVectorEnv
from support.env_toys import Swing

from granular_env.components.errors import ParameterError
from granular_env.components.oscillator import Oscillator
from granular_env.control.drive import DriveShape
from granular_env.control.problem import Problem, environment_names
from granular_env.domains.chain.tasks import ENVIRONMENTS
from granular_env.envs import ComponentEnv, OpenLoop

SMALL = {"grains": 12, "deadline": 80, "place": 6.0, "amplitude": 4.0}
SEEDS = [7, 11, 40]


def drives(problem: Problem, count: int) -> np.ndarray:
    shape = DriveShape(problem.steps, problem.entries, 10, driven=40)
    return shape.actions(np.random.default_rng(2).uniform(0.0, 0.6, (count, shape.size)))


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("pulse-forming", SMALL),
        ("pulse-forming", {**SMALL, "control_delay": 3, "action_rate": 0.1}),
        ("pulse-forming", {**SMALL, "randomise": {"velocity": [0.0, 1.0], "radius": {"low": 2.8e-3, "high": 3.2e-3}}}),
        ("protection", {"grains": 8, "deadline": 120, "impulse": 0.01}),
        ("absorption", {"grains": 12, "deadline": 60}),
    ],
)
def test_the_batch_and_the_single_environment_give_the_same_return(name, arguments):
    problem = Problem(name, arguments)
    chosen = drives(problem, 4)
    found, steps = problem.returns(chosen, SEEDS)
    for member in range(4):
        episodes = [problem.play_episode(OpenLoop(chosen[member]), seed) for seed in SEEDS]
        assert found[member] == np.mean([value for value, _ in episodes])
        assert steps[member] == sum(len(actions) for _, actions in episodes)


@pytest.mark.parametrize(
    "changes",
    [{}, {"control_delay": 3, "action_rate": 0.03}, {"randomise": {"velocity": [0.2, 1.0]}}, {"action": "piston"}],
    ids=["plain", "delayed", "drawn", "piston"],
)
def test_slopes_by_the_point_are_those_of_central_differences(changes):
    problem = Problem("pulse-forming", {**SMALL, "chain": {"precompression": 20.0}, **changes})
    shape = DriveShape(problem.steps, problem.entries, 6, driven=60, rate=problem.rate)
    draw = np.random.default_rng(5)
    point, along = draw.uniform(0.05, 0.3, shape.size), draw.normal(size=shape.size)
    value = lambda at: problem.value_and_grad(shape.actions(at[None])[0], SEEDS)[0]  # noqa: E731
    slopes = shape.pullback(point, problem.value_and_grad(shape.actions(point[None])[0], SEEDS)[1])
    # Contacts open and close, so the error decreases more slowly than the step's square: 5e-6 at 1e-5, at most 1e-7 at 1e-6.
    differences = (value(point + 1e-6 * along) - value(point - 1e-6 * along)) / 2e-6
    assert slopes @ along == pytest.approx(differences, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("pulse-forming", {**SMALL, "control_delay": 2}),
        ("soliton-train", {"deadline": 120, "waves": 2, "front": [16, 20], "spacing": [6, 8]}),
    ],
)
def test_the_objective_of_an_episode_at_rest_is_minus_its_return(name, arguments):
    problem = Problem(name, arguments)
    drive = drives(problem, 1)[0]
    for seed in SEEDS:
        start = (
            problem.play_episode(OpenLoop(np.zeros_like(drive)), seed)[0]
            + problem.value_and_grad(np.zeros_like(drive), [seed])[0]
        )
        # `start` is the part of the wanted waves that should already be in the chain.
        value = problem.value_and_grad(drive, [seed])[0]
        assert value - start == pytest.approx(-problem.play_episode(OpenLoop(drive), seed)[0], rel=1e-9)


def test_every_environment_has_a_short_name():
    assert environment_names()["pulse-forming"] == "granular_env/PulseForming-v1"
    for short, registered in environment_names().items():
        small = {"grains": 48} if registered in ENVIRONMENTS else {}
        assert type(Problem(short, small).env.task) is type(Problem(registered, small).env.task)


def make_swing(deadline: int = 40, **options) -> ComponentEnv:
    return ComponentEnv(Oscillator(step_size=0.01), Swing(), internal_steps=5, deadline=deadline, **options)


@pytest.fixture
def swing(monkeypatch, tmp_path):
    """Return a task of a component whose domain has no batch and no gradients."""
    module = ModuleType("swing_of_my_own")
    module.make = make_swing
    monkeypatch.setitem(sys.modules, module.__name__, module)
    return Problem(f"{module.__name__}:make", {})


def test_without_a_native_batch_gymnasiums_own_gives_the_single_returns(swing):
    assert isinstance(swing.make_vector_env(2), SyncVectorEnv)
    chosen = drives(swing, 3)
    found, steps = swing.returns(chosen, SEEDS)
    for member in range(3):
        episodes = [swing.play_episode(OpenLoop(chosen[member]), seed) for seed in SEEDS]
        assert found[member] == np.mean([value for value, _ in episodes])
        assert steps[member] == sum(len(actions) for _, actions in episodes)


def test_without_gradients_a_method_that_wants_them_is_refused_by_name(swing):
    assert swing.gradient_runs == 0.0
    with pytest.raises(ParameterError, match="task 'swing' has no objective .*; components with gradients: chain"):
        swing.env.task.objective(swing.env.component, 10)
