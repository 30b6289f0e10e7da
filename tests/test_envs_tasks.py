"""What the tasks reward, what the environments refuse to be made of, and their pictures."""

from __future__ import annotations

import math
from collections.abc import Callable

import gymnasium
import numpy as np
import pytest
from support.env_toys import MAKERS, Swing

from granular_env.components.errors import ParameterError
from granular_env.components.oscillator import Oscillator
from granular_env.domains.chain import ChainEnv
from granular_env.domains.chain.tasks.piston import make_piston
from granular_env.domains.chain.tasks.protection import make_protection
from granular_env.envs import ComponentEnv


@pytest.fixture(params=sorted(MAKERS))
def make(request: pytest.FixtureRequest) -> Callable[..., ComponentEnv]:
    return MAKERS[request.param]


# -- the tasks --------------------------------------------------------------------------------------------------------


def episode(env: ComponentEnv, policy: Callable[[int], float]) -> tuple[float, int, bool, dict]:
    env.reset(seed=1)
    total, count, over, terminated, info = 0.0, 0, False, False, {}
    while not over:
        _, reward, terminated, truncated, info = env.step([policy(count)])
        total, count, over = total + float(reward), count + 1, terminated or truncated
    return total, count, terminated, info


def test_piston_returns_what_its_page_says() -> None:
    env = make_piston()
    total, count, terminated, info = episode(env, lambda count: 0.24 if count < 12 else 0.0)
    energy = 0.5 * env.component.geometry.mass[-1] * 5.0**2
    # The rewards telescope: 285 additions of numbers below 1.
    assert total == pytest.approx(info["closeness"] - 0.2 * info["work"] / energy, abs=1e-13)
    assert terminated and 200 < count < 400
    assert info["closeness"] == pytest.approx(1.0 - abs(info["velocity"][-1] / 5.0 - 1.0), abs=1e-15)
    assert total == pytest.approx(0.77, abs=0.01)
    assert episode(env, lambda count: 0.0)[:3] == (0.0, 600, False)
    assert episode(env, lambda count: 1.0)[0] < -50.0


def test_force_returns_what_its_page_says() -> None:
    env = make_protection(clock=0)
    total, _, terminated, info = episode(env, lambda count: 0.1)
    delivered = min(info["delivered_impulse"] / 0.05, 1.0)
    assert total == pytest.approx(delivered - info["peak_wall_force"] / 1000.0, abs=1e-13)
    assert terminated and delivered == 1.0
    assert total == pytest.approx(0.75, abs=0.01)
    assert episode(env, lambda count: 0.6)[0] == pytest.approx(-0.5, abs=0.01)
    late, count, terminated, _ = episode(env, lambda count: 0.05)
    assert late == pytest.approx(0.37, abs=0.01) and count == 700 and not terminated
    assert episode(env, lambda count: 0.0)[:3] == (0.0, 700, False)


def test_the_walls_impulse_is_the_momentum_that_is_missing() -> None:
    """Applied impulse less the chain's momentum is what the wall took; the trapezoid sum is near it."""
    env = make_protection(grains=16, impulse=10.0, deadline=600)
    _, count, _, info = episode(env, lambda count: 0.2)
    taken = 100.0 * count * env.duration - env.component.get("momentum")
    # The wall's force turns over within some 30 control steps: the trapezoid rule is good to a fraction of (1/30)^2.
    assert info["delivered_impulse"] == pytest.approx(taken, rel=1e-3)


def test_arguments_reach_the_chain() -> None:
    env = make_protection(
        grains=5, radius=1e-3, chain={"right": "plane", "integrator": "leapfrog"}, step_size=2e-8, internal_steps=10
    )
    assert env.component.get("right") == "plane" and env.component.get("integrator") == "leapfrog"
    assert env.duration == pytest.approx(2e-7)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"grains": 1.5}, "grains"),
        ({"radius": -1.0}, "radius"),
        ({"chain": {"rihgt": "plane"}}, "did you mean 'right'"),
        ({"internal_steps": 0}, "internal_steps"),
        ({"internal_steps": 2.0}, "internal_steps"),
        ({"deadline": 0}, "deadline"),
        ({"render_mode": "human"}, "render_mode"),
        ({"velocity_scale": math.nan}, "velocity_scale"),
    ],
)
@pytest.mark.parametrize("env", [make_piston, make_protection])
def test_wrong_arguments_are_refused(env: type[ComponentEnv], arguments: dict, words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        env(**arguments)


@pytest.mark.parametrize(
    ("attribute", "value", "words"),
    [
        ("actions", {"forse": 1.0}, "did you mean 'force'"),
        ("actions", {"position": 1.0}, "actions.position: got 'position', expected an input of"),
        ("actions", {"force": 0.0}, "more than 0"),
        ("actions", {"force": math.nan}, "finite"),
        ("actions", {}, "none"),
        ("observations", {"force": 1.0}, "observations.force: got 'force', expected an output of"),
        ("observations", {"velocity": -1.0}, "more than 0"),
    ],
)
def test_a_task_that_does_not_fit_is_refused(attribute: str, value: dict, words: str) -> None:
    task = Swing()
    setattr(task, attribute, value)
    with pytest.raises(ParameterError, match=words):
        ComponentEnv(Oscillator(), task)


# -- pictures ---------------------------------------------------------------------------------------------------------


def test_pictures_show_what_moves(make: Callable[..., ComponentEnv]) -> None:
    env = make(render_mode="rgb_array")
    env.reset(seed=1)
    before = env.render()
    assert before.shape == (360, 960, 3) and before.dtype == np.uint8
    assert env.render().tobytes() == before.tobytes()
    for _ in range(12):
        env.step([1.0])
    after = env.render()
    assert (after != before).any()
    red = (after[..., 0].astype(int) - after[..., 2] > 60).sum()
    assert red > 200, "what moves to the right is red"
    assert make().render() is None


def test_a_moving_grain_is_coloured_where_it_is() -> None:
    env = make_piston(grains=10, render_mode="rgb_array")
    env.reset(options={"velocity": {2: 10.0, 7: -10.0}})
    row = env.render()[105].astype(int)
    centres = [round(40 + (index + 0.5) * 88) for index in range(10)]
    assert [index for index in range(10) if row[centres[index], 0] - row[centres[index], 2] > 100] == [2]
    assert [index for index in range(10) if row[centres[index], 2] - row[centres[index], 0] > 100] == [7]


def test_a_picture_says_when_and_what_is_put_in() -> None:
    env = make_piston(grains=10, render_mode="rgb_array")
    env.reset(seed=1)
    caption = lambda: env.render()[14:34, 40:].tobytes()  # noqa: E731
    before = caption()
    env.step([0.5])
    after = caption()
    env.reset(seed=1)
    assert before == caption() != after


# -- authors' slips -----------------------------------------------------------------------------------------------------


class Nameless(Swing):
    name = property()  # type: ignore[assignment]


def test_what_an_author_forgets_is_named() -> None:
    def swing(**changes: object) -> Swing:
        task = Swing()
        for name, value in changes.items():
            if value is None:
                delattr(task, name)
            else:
                setattr(task, name, value)
        return task

    component = Oscillator(step_size=0.01)
    for task, words in (
        (swing(actions=None), "Swing has no actions; give it one"),
        (swing(observations=None), "Swing has no observations; give it one"),
        (Nameless(), "Nameless has no name; give it one"),
        (3, "task: got 3, expected an object of a class made from Task"),
    ):
        with pytest.raises(ParameterError, match=words):
            ComponentEnv(component, task)  # type: ignore[arg-type]
    env = ComponentEnv(component, swing(judge=lambda *_: 0.5))
    env.reset(seed=1)
    with pytest.raises(ParameterError, match=r"judge gave 0.5, expected \(reward, done\)"):
        env.step([0.1])
    with pytest.raises(ParameterError, match="expected a Chain"):
        ChainEnv(component, make_piston(grains=4).task)  # type: ignore[arg-type]


def test_an_argument_that_is_not_there_gets_the_nearest_name() -> None:
    with pytest.raises(ParameterError, match="make_piston: grain: unknown; did you mean 'grains'"):
        gymnasium.make("granular_env/Piston-v1", grain=16)
    with pytest.raises(ParameterError, match="did you mean 'randomise'"):
        gymnasium.make_vec("granular_env/Piston-v1", 2, randomize={})
    with pytest.raises(ParameterError, match=r"^action: got 'hammer'; (?!.*force.*force)"):
        gymnasium.make("granular_env/Protection-v1", action="hammer")


@pytest.mark.parametrize(
    ("name", "given", "words"),
    [
        ("Piston", {"grains": 5, "chain": {"grains": 7}}, "chain.grains: got 7, and grains = 5 as an argument of the env"),
        ("Protection", {"grains": 64, "chain": {"grains": 7}}, "chain.grains: got 7, and grains = 64"),
        ("PulseForming", {"radius": 3e-3, "chain": {"radius": 2e-3}}, "chain.radius: got 0.002, and radius = 0.003"),
        ("Splitting", {"columns": 8, "discs": {"columns": 9}}, "discs.columns: got 9, and columns = 8"),
    ],
)
def test_a_parameter_that_is_given_twice_is_refused(name: str, given: dict, words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        gymnasium.make(f"granular_env/{name}-v1", **given)


def test_a_parameter_that_is_given_once_counts() -> None:
    assert make_piston(radius=None, chain={"grains": 7, "radius": 2e-3}).component.parameters.grains == 7
    with pytest.raises(ParameterError, match="chain.grains: got 7, and grains = 5"):
        make_piston(5, chain={"grains": 7})


def test_pictures_show_walls_and_what_is_wanted() -> None:
    from granular_env.domains.chain.tasks.pulse_forming import make_pulse_forming

    dark = lambda image, rows, columns: (image[rows, columns].max(axis=2) < 60).sum()  # noqa: E731
    pictures = {}
    for side in ("plane", "free"):
        env = make_piston(grains=10, chain={"right": side}, render_mode="rgb_array")
        env.reset(seed=1)
        pictures[side] = dark(env.render(), slice(60, 150), slice(920, 935))
    assert pictures["plane"] > 400 and pictures["free"] < 20
    env = make_pulse_forming(render_mode="rgb_array")
    env.reset(seed=1)
    at_rest = dark(env.render(), slice(150, 250), slice(40, 920))
    for _ in range(100):
        env.step([0.0])
    # The wave that should be on its way now covers a few grains: bars of 13 pixels, three high.
    assert at_rest == 0 and dark(env.render(), slice(150, 250), slice(40, 920)) > 60
