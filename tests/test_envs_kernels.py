"""A task of one's own: compiled once, kept on disk, and compiled anew when its file or its package is edited."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granular_env.components.chain import Chain
from granular_env.components.errors import ParameterError
from granular_env.components.support.jit import JIT, jit
from granular_env.domains.chain import ChainEnv, ChainTask, ChainVectorEnv
from granular_env.domains.chain.tasks.piston import make_piston
from granular_env.domains.chain.tasks.protection import make_protection
from granular_env.envs import ComponentEnv

TASK = """
import numpy as np
from granular_env.components.support.jit import jit
from granular_env.domains.chain import ChainEnv, ChainTask, ChainVectorEnv
import granular_env as ge
{imported}

@jit
def begin(a, counters, constants):
    counters[0] = {begun}

@jit
def judge(a, inputs, counters, constants, duration, elapsed, steps):
    return {reward}, False

class Own(ChainTask):
    name, counter_names = "own", ("begun",)
    actions, observations = {{"left_force": 1.0}}, {{"displacement": 1.0, "velocity": 1.0}}
    begin_kernel, judge_kernel = staticmethod(begin), staticmethod(judge)

def make(**options):
    return ChainEnv(ge.make("chain", grains=4), Own(), **options)
"""
RUN = """
import numpy as np
from {module} import *
env, batch = make(), ChainVectorEnv(make, 2)
info = env.reset(seed=1)[1]
batch.reset(seed=1)
print(info["begun"], env.step([0.0])[1], *batch.step(np.zeros((2, 1)))[1].tolist())
"""


def run(folder: Path, module: str) -> str:
    path = os.pathsep.join([str(folder), str(Path(__file__).resolve().parents[1])])
    # Python itself takes a source that was changed within a second, and has its old length, for the one it has compiled.
    environment = {**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"}
    script = RUN.format(module=module)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, env=environment, cwd=folder)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_an_edited_task_is_noticed(tmp_path: Path) -> None:
    file = tmp_path / "own_task.py"
    for begun, reward in ((1.0, 2.0), (3.0, 2.0), (3.0, 5.0)):
        file.write_text(TASK.format(imported="", begun=begun, reward=reward))
        assert run(tmp_path, "own_task") == f"{begun} {reward} {reward} {reward}"


def test_an_edited_neighbour_in_its_package_is_noticed(tmp_path: Path) -> None:
    package = tmp_path / "own_tasks"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "task.py").write_text(TASK.format(imported="from .prices import price", begun=0.0, reward="price()"))
    for price in (2.0, 4.0):
        (package / "prices.py").write_text(
            f"from granular_env.components.support.jit import jit\n\n\n@jit\ndef price():\n    return {price}\n"
        )
        assert run(tmp_path, "own_tasks.task") == f"0.0 {price} {price} {price}"


@pytest.mark.skipif(not JIT, reason="nothing is compiled")
def test_kernels_that_do_not_fit_are_refused_by_name() -> None:
    class Half(ChainTask):
        name = "half"
        actions, observations = {"left_velocity": 1.0}, {"displacement": 1.0, "velocity": 1.0}  # noqa: RUF012

    class Wrong(Half):
        name = "wrong"
        begin_kernel = staticmethod(jit(lambda a, counters, constants: None))
        judge_kernel = staticmethod(jit(lambda a, inputs: 1.0))

    with pytest.raises(ParameterError, match="'half': it has no begin_kernel"):
        ChainEnv(Chain(grains=4, left="piston"), Half())
    with pytest.raises(ParameterError, match="task 'wrong': judge_kernel: does not compile"):
        ChainEnv(Chain(grains=4, left="piston"), Wrong())


def test_plain_functions_are_compiled() -> None:
    """A decorator that was forgotten does not matter, in one environment and in a batch; what does not fit is named."""

    class Plain(ChainTask):
        name = "plain"
        actions, observations = {"left_velocity": 1.0}, {"displacement": 1.0, "velocity": 1.0}  # noqa: RUF012
        begin_kernel = staticmethod(lambda a, counters, constants: None)
        judge_kernel = staticmethod(lambda a, inputs, counters, constants, duration, elapsed, steps: (0.5, False))

    def make(**options: Any) -> ChainEnv:
        return ChainEnv(Chain(grains=3, left="piston"), Plain(), **options)

    env, batch = make(), ChainVectorEnv(make, 2)
    env.reset(seed=1)
    batch.reset(seed=1)
    assert env.step([0.0])[1] == 0.5 and batch.step(np.zeros((2, 1)))[1].tolist() == [0.5, 0.5]

    class Misfit(Plain):
        judge_kernel = staticmethod(lambda a, inputs: (0.5, False))

    if JIT:
        with pytest.raises(ParameterError, match="judge_kernel: does not compile"):
            ChainEnv(Chain(grains=3, left="piston"), Misfit())


def test_a_reward_that_is_not_a_number_is_named() -> None:
    class Undefined(ChainTask):
        name = "undefined"
        actions, observations = {"left_velocity": 1.0}, {"displacement": 1.0, "velocity": 1.0}  # noqa: RUF012
        begin_kernel = staticmethod(lambda a, counters, constants: None)
        judge_kernel = staticmethod(
            lambda a, inputs, counters, constants, duration, elapsed, steps: (inputs[0] * np.nan, False)
        )

    def make(**options: Any) -> ChainEnv:
        return ChainEnv(Chain(grains=3, left="piston"), Undefined(), **options)

    env, batch = make(), ChainVectorEnv(make, 2)
    env.reset(seed=1)
    batch.reset(seed=1)
    with pytest.raises(ParameterError, match="'undefined': its reward is nan after control step 1"):
        env.step([0.1])
    with pytest.raises(ParameterError, match="'undefined': its reward is nan in environment 0"):
        batch.step(np.full((2, 1), 0.1))


def test_a_chain_task_wants_its_own_environment() -> None:
    task = make_piston(grains=4).task
    assert isinstance(task, ChainTask)
    env = ComponentEnv(Chain(grains=4, left="piston"), task)
    env.reset(seed=1)
    with pytest.raises(ParameterError, match="ChainEnv"):
        env.step([0.0])
    with pytest.raises(ParameterError, match="no objective"):
        task.objective(env.component, 10)  # type: ignore[arg-type]
    assert task.baselines() == {} and isinstance(make_piston(grains=4), ChainEnv)


def test_a_judgement_that_is_set_on_the_task_itself_is_refused() -> None:
    env = make_protection(grains=4)
    env.task.judge_kernel = type(env.task).judge_kernel
    with pytest.raises(ParameterError, match="judge_kernel was set on the task itself, expected it in the body of"):
        ChainEnv(env.component, env.task)
