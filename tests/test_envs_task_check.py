"""Slips in the kernels of a task of one's own are refused by name before they run; the shipped tasks have none."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import gymnasium
import numpy as np
import pytest
from numba import types
from numba.extending import intrinsic
from support.env_toys import MAKERS, Swing

from granular_env.components.chain import Chain, differentiable_quantities
from granular_env.components.chain.layout import U, V
from granular_env.components.component import Component
from granular_env.components.discs import Discs
from granular_env.components.errors import GranularWarning, ParameterError
from granular_env.components.oscillator import Oscillator
from granular_env.components.support.jit import jit
from granular_env.domains.chain import ChainEnv, ChainTask, ChainVectorEnv
from granular_env.domains.chain.tasks import ENVIRONMENTS
from granular_env.envs import ComponentEnv, Task, check_task
from granular_env.envs.task import refuse_incomplete

DEADLINE = 20


@jit
def begin(a, counters, constants):  # noqa: ANN001, ANN201
    counters[0] = 1.0


@jit
def judge(a, inputs, counters, constants, duration, elapsed, steps):  # noqa: ANN001, ANN201
    counters[0] += 1.0
    return -abs(a[U, 1]) + constants[0], False


@jit
def far(a, place):  # noqa: ANN001, ANN201
    return a[U, place]


def own_task(judge: Callable[..., Any] = judge, begin: Callable[..., Any] = begin, **attributes: Any) -> type[ChainTask]:
    """Return a class of its own at each call."""
    given = {
        "name": "own", "actions": {"left_force": 100.0}, "observations": {"displacement": 1e-5, "velocity": 0.1},
        "counter_names": ("steps",), "begin_kernel": staticmethod(begin), "judge_kernel": staticmethod(judge),
    } | attributes  # fmt: skip
    return type("Own", (ChainTask,), given)


def environment(judge: Callable[..., Any] = judge, begin: Callable[..., Any] = begin, **attributes: Any) -> ChainEnv:
    """Eight grains; each call is a class of its own."""
    return ChainEnv(Chain(grains=8), own_task(judge, begin, **attributes)(), deadline=DEADLINE)


@intrinsic
def only_compiled(context, counters):  # noqa: ANN001, ANN201
    """Return 0.5; numba alone can."""
    return types.float64(counters), lambda context, builder, signature, values: context.get_constant(types.float64, 0.5)


SLIPS: dict[str, tuple[Callable[..., Any], str]] = {
    "counter": (lambda a, i, c, k, d, e, s: (c[1], False), r"reads counters\[1\].*declares 1 \(steps\)"),
    "constant": (lambda a, i, c, k, d, e, s: (k[7], False), r"reads constants\[7\], but the task has 1"),
    "input": (lambda a, i, c, k, d, e, s: (i[2], False), r"reads inputs\[2\]"),
    "far column": (lambda a, i, c, k, d, e, s: (a[U, 500], False), r"reads a\[U, 500\], but the chain has 8 grains"),
    "column behind the chain": (lambda a, i, c, k, d, e, s: (a[V, 10], False), r"reads a\[V, 10\]"),
    "last grain as in Python": (lambda a, i, c, k, d, e, s: (a[V, -1], False), r"reads a\[V, -1\]"),
    "in a function it calls": (lambda a, i, c, k, d, e, s: (far(a, 12), False), r"reads a\[U, 12\]"),
    "in a function of the package": (
        lambda a, i, c, k, d, e, s: (differentiable_quantities.kinetic_energy(a, 0, 9), False), r"reads a\[MASS, 10\]",
    ),
    "at the deadline only": (lambda a, i, c, k, d, e, s: (c[5] if e == s else 0.0, False), r"reads counters\[5\]"),
}  # fmt: skip


@jit
def writes_physics(a, inputs, counters, constants, duration, elapsed, steps):  # noqa: ANN001, ANN201
    a[V, 1] = 99.0
    return 0.0, False


@jit
def writes_row(a, inputs, counters, constants, duration, elapsed, steps):  # noqa: ANN001, ANN201
    row = a[V]
    row[1] += 1.0
    return 0.0, False


@jit
def writes_constants(a, inputs, counters, constants, duration, elapsed, steps):  # noqa: ANN001, ANN201
    constants[0] = 1.0
    return 0.0, False


@jit
def writes_far(a, inputs, counters, constants, duration, elapsed, steps):  # noqa: ANN001, ANN201
    counters[3] += 1.0
    return 0.0, False


@pytest.mark.parametrize("name", SLIPS)
def test_a_slip_is_refused_by_name_before_it_runs(name: str) -> None:
    function, said = SLIPS[name]
    with pytest.raises(ParameterError, match=f"'own': judge_kernel {said}"):
        environment(function)


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (writes_physics, r"writes into a\[V, 1\], but it may write into counters alone"),
        (writes_row, "write"),
        (writes_constants, r"writes into constants\[0\]"),
        (writes_far, r"reads counters\[3\]"),
    ],
)
def test_a_kernel_writes_into_its_counters_alone(function: Callable[..., Any], said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        environment(function)


@jit
def writes_too_much(a, inputs, counters, constants, duration, elapsed, steps):  # noqa: ANN001, ANN201
    counters[:] = np.array([1.0, 2.0])
    return 0.0, False


def test_more_numbers_than_there_are_counters_are_refused_by_name() -> None:
    with pytest.raises(ParameterError, match=r"judge_kernel writes 2 numbers into counters\[:\].*declares 1 \(steps\)"):
        environment(writes_too_much)


@jit
def places(a, inputs, counters, constants, duration, elapsed, steps):  # noqa: ANN001, ANN201
    late = counters[4] if steps == 0 and constants[0] == 1.0 else 0.0
    return a[U, 8] + late + counters[int(constants[0]) - 1], False


def test_each_instance_of_one_task_is_checked_for_its_constants_deadline_and_chain() -> None:
    task = own_task(places)

    def make(constant: float, grains: int = 8, deadline: int | None = DEADLINE) -> ChainEnv:
        one = task()
        one.constants = np.array([constant])
        return ChainEnv(Chain(grains=grains), one, deadline=deadline)

    make(1.0)
    with pytest.raises(ParameterError, match=r"reads counters\[8\]"):
        make(9.0)
    with pytest.raises(ParameterError, match=r"reads counters\[4\]"):
        make(1.0, deadline=None)
    with pytest.raises(ParameterError, match=r"reads a\[U, 8\], but the chain has 5 grains"):
        make(1.0, grains=5)


@jit
def far_counter(counters):  # noqa: ANN001, ANN201
    return counters[3]


class Tools(NamedTuple):
    """Functions by name."""

    far: Any


FUNCTIONS, TOOLS, NESTED = (far_counter, far_counter), Tools(far_counter), (1.0, (far_counter,))


@pytest.mark.parametrize(
    "function",
    [
        lambda a, i, c, k, d, e, s: (FUNCTIONS[0](c), False),
        lambda a, i, c, k, d, e, s: (TOOLS.far(c), False),
        lambda a, i, c, k, d, e, s: (NESTED[1][0](c), False),
    ],
)
def test_functions_in_tuples_are_checked(function: Callable[..., Any]) -> None:
    with pytest.raises(ParameterError, match=r"reads counters\[3\]"):
        environment(function)


def test_a_kernel_that_python_cannot_run_is_told_of() -> None:
    with pytest.warns(GranularWarning, match="'own' could not be checked: judge_kernel .*NotImplemented.*; call check_task"):
        env = environment(lambda a, i, c, k, d, e, s: (only_compiled(c), False))  # type: ignore[call-arg]
    assert env.reset(seed=0) is not None and env.step([0.1])[1] == 0.5
    with pytest.raises(ParameterError, match="could not be checked: judge_kernel .*NotImplementedError"):
        check_task(env)


def test_numbers_divide_by_zero_as_compiled_ones_do(recwarn: pytest.WarningsRecorder) -> None:
    environment(lambda a, i, c, k, d, e, s: (1.0 if 1 / (e - 1) > 1e300 else 0.0, False))
    assert not [one for one in recwarn if issubclass(one.category, GranularWarning)]


def test_forgotten_counters_are_refused_in_single_environments_and_batches() -> None:
    """The kernel used to write into the actuator's memory, and in a batch into the next environment's clock."""
    with pytest.raises(ParameterError, match=r"begin_kernel writes into counters\[0\], but counter_names declares 0"):
        environment(counter_names=())
    with pytest.raises(ParameterError, match="counter_names declares 0"):
        ChainVectorEnv(lambda **options: environment(counter_names=()), num_envs=3)


def test_the_environment_is_untouched_by_its_check() -> None:
    one, other = environment(), environment()
    for env in (one, other):
        env.reset(seed=3)
        env.step([0.5])
    assert check_task(one, steps=7) == 7 and check_task(one, steps=100) == DEADLINE
    for env in (one, other):
        env.step([-0.5])
    assert one.save().to_bytes() == other.save().to_bytes()


def test_the_check_finds_what_an_episode_enters_later() -> None:
    late = environment(lambda a, i, c, k, d, e, s: (c[9] if e == 5 else 0.0, False))
    with pytest.raises(ParameterError, match=r"reads counters\[9\]"):
        check_task(late)
    assert check_task(late, steps=4) == 4


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
def test_a_reward_that_is_not_finite_is_refused(value: float) -> None:
    env = environment(lambda a, i, c, k, d, e, s: (value, False))
    env.reset(seed=1)
    with pytest.raises(ParameterError, match=f"its reward is {value} after control step 1"):
        env.step([0.1])
    with pytest.raises(ParameterError, match=f"its reward is {value}"):
        check_task(env)
    batch = ChainVectorEnv(lambda **options: environment(lambda a, i, c, k, d, e, s: (value, False)), num_envs=2)
    batch.reset(seed=1)
    with pytest.raises(ParameterError, match=f"its reward is {value} in environment 0"):
        batch.step(np.full((2, 1), 0.1))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ((float("nan"), False), "its reward is nan"),
        ((float("inf"), False), "its reward is inf"),
        (0.5, "expected .reward, done"),
    ],
)
def test_what_a_task_in_python_returns_is_looked_at(given: Any, said: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Swing, "judge", lambda self, component, seen, duration: given)
    env = ComponentEnv(Oscillator(step_size=0.01), Swing())
    env.reset(seed=1)
    with pytest.raises(ParameterError, match=f"'swing': .*{said}"):
        env.step([0.0])


@pytest.mark.parametrize("name", ["name", "actions", "observations"])
def test_a_task_that_lacks_something_is_told_what(name: str) -> None:
    given: dict[str, Any] = {"name": None, "actions": None, "observations": None} | {name: None}
    with pytest.raises(ParameterError, match=f"has no {name}"):
        environment(**{name: given[name]})
    with pytest.raises(ParameterError, match="task.actions: got .*expected a mapping"):
        environment(actions=["left_force"])
    with pytest.raises(ParameterError, match="expected an object of a class made from Task"):
        refuse_incomplete(None)


def test_an_environment_of_a_chain_wants_a_chain() -> None:
    with pytest.raises(ParameterError, match="expected a Chain"):
        ChainEnv(Oscillator(), environment().task)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", sorted(ENVIRONMENTS))
def test_the_shipped_tasks_have_no_slip(name: str) -> None:
    env = gymnasium.make(f"granular_env/{name}" if "/" not in name else name)
    assert check_task(env, steps=3) == 3


def test_a_component_with_a_task_in_python_is_played() -> None:
    assert check_task(MAKERS["swing"](), steps=5) == 5
    with pytest.raises(ParameterError, match="expected the environment of one task"):
        check_task(None)  # type: ignore[arg-type]


class Steady(Task):
    """A toy for one slip at a time."""

    name = "steady"
    actions, observations = {"force": 1.0}, {"position": 1.0}  # noqa: RUF012

    def begin(self, component: Component, seen: Any) -> None:
        self.counters = {"count": 0}

    def judge(self, component: Component, seen: Any, duration: float) -> tuple[float, bool]:
        self.counters["count"] += 1
        return np.float32(self.counters["count"]), np.bool_(False)  # type: ignore[return-value]


class Hidden(Steady):
    def begin(self, component: Component, seen: Any) -> None:
        self.count = 0

    def judge(self, component: Component, seen: Any, duration: float) -> tuple[float, bool]:
        self.count += 1
        return float(self.count), False


class Leftover(Steady):
    count = 0

    def begin(self, component: Component, seen: Any) -> None:
        Leftover.count += 1

    def judge(self, component: Component, seen: Any, duration: float) -> tuple[float, bool]:
        return float(Leftover.count), False


class Drawing(Steady):
    def judge(self, component: Component, seen: Any, duration: float) -> tuple[float, bool]:
        return float(np.random.default_rng().random()), False


class Stepping(Steady):
    def judge(self, component: Component, seen: Any, duration: float) -> tuple[float, bool]:
        component.step(component.step_size)
        return 0.0, False


class ArrayCounter(Steady):
    def begin(self, component: Component, seen: Any) -> None:
        self.counters = {"count": np.zeros(3)}  # type: ignore[dict-item]


class Writing(Steady):
    def judge(self, component: Component, seen: Any, duration: float) -> tuple[float, bool]:
        seen["position"] *= 0.0
        return 0.0, False


def steady(task: Task) -> ComponentEnv:
    return ComponentEnv(Oscillator(step_size=0.01), task, internal_steps=5, deadline=20)


@pytest.mark.parametrize("task", [Hidden, Leftover, Drawing])
def test_a_task_that_remembers_something_outside_its_counters_is_found(task: type[Task]) -> None:
    with pytest.raises(ParameterError, match=r"task 'steady': reward: got .* after action \d.*counters"):
        check_task(steady(task()))


@pytest.mark.parametrize(
    ("task", "said"),
    [
        (Stepping, "its judge moved the component from tick 5 to 6; read the component with get"),
        (ArrayCounter, r"counters: got .*expected name -> number"),
    ],
)
def test_a_task_that_steps_or_counts_in_arrays_is_refused_by_its_environment(task: type[Task], said: str) -> None:
    with pytest.raises(ParameterError, match=f"task 'steady': {said}"):
        env = steady(task())
        env.reset(seed=0)
        env.step([0.5])


@pytest.mark.parametrize("name", ["time", "position", "step_error"])
def test_a_counter_with_a_name_that_info_has_is_refused(name: str) -> None:
    class Clash(Steady):
        def begin(self, component: Component, seen: Any) -> None:
            self.counters = {name: -5.0}

    with pytest.raises(ParameterError, match=f"counters: got '{name}', which info already has"):
        steady(Clash()).reset(seed=0)


@pytest.mark.parametrize("names", [("time",), ("velocity",), ("left_force",), ("steps", "steps")])
def test_a_counter_of_a_chain_with_a_name_that_info_has_is_refused(names: tuple[str, ...]) -> None:
    with pytest.raises(ParameterError, match=f"counters: got '{names[0]}', which info already has"):
        environment(counter_names=names)


def test_a_task_cannot_write_into_what_it_sees() -> None:
    env = steady(Writing())
    env.reset(seed=0)
    with pytest.raises(TypeError, match="item assignment"):
        env.step([0.5])

    class WritingArray(Steady):
        actions, observations = {"force[0,0]": 1.0}, {"velocity": 1.0}  # noqa: RUF012

        def judge(self, component: Component, seen: Any, duration: float) -> tuple[float, bool]:
            seen["velocity"] *= 0.0
            return 0.0, False

    env = ComponentEnv(Discs(), WritingArray())
    env.reset(seed=0)
    with pytest.raises(ValueError, match="read-only"):
        env.step([0.5])


def test_what_a_task_counts_and_returns_are_plain_numbers_of_its_own() -> None:
    env = steady(Steady())
    _, first = env.reset(seed=0)
    saved = env.save()
    reward, info = env.step([0.5])[1], env.step([0.5])[4]
    assert type(reward) is float and reward == 1.0 and type(info["count"]) is float
    assert (first["count"], saved.episode[2]["count"], info["count"]) == (0.0, 0.0, 2.0)  # type: ignore[index]
    assert check_task(env, steps=3) == 3
