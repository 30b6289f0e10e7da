"""Studies of tasks that are not of this package: by module and name, by a registered name, in stages."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import gymnasium
import numpy as np
import pytest

from granular_env.cli import main
from granular_env.components.errors import ExperimentError, ParameterError
from granular_env.control.study.results import Score
from granular_env.control.study.runner import run_study
from granular_env.control.task_problem import TaskProblem

ROOT = Path(__file__).resolve().parents[1]
MODULE = '''
import granular_env as ge
import numpy as np
from granular_env.domains.chain.control import total, velocity
from granular_env.envs import ComponentEnv, RowTask


class LastVelocity(RowTask):
    """The last of six grains shall move at 1 m/s at the end; on the way, the fourth."""

    name = "last velocity"
    actions, observations = {"left_force": 100.0}, {"displacement": 1e-5, "velocity": 1.0}
    counter_names = ("last_velocity",)

    def __init__(self, target=1.0, deadline=40):
        self.target, self.deadline = target, deadline

    def begin_rows(self, rows, constants, counters):
        pass

    def judge_rows(self, rows, constants, counters, elapsed):
        last = counters["last_velocity"][:] = rows.velocity[:, -1]
        return np.where(elapsed == self.deadline, -np.abs(last - self.target), 0.0), False

    def objective(self, chain, steps, *, way=0.0):
        goal = velocity(-1).at_end(target=self.target)
        return total(chain, goal, way * velocity(3).mean(target=1.0)) if way else total(chain, goal)


def boom():
    raise RuntimeError("boom")


def make(target=1.0, deadline=40, step_size=5e-7):
    """Takes neither what a batch tells its environments nor options."""
    return ComponentEnv(ge.make("chain", grains=6, step_size=step_size), LastVelocity(target, deadline), deadline=deadline)


def no_chain():
    return 3


answer = 42
'''
STUDY = """
version = 1
name = "own"
budget = 30000

[task]
name = "{name}"
target = 0.5

[drive]
knots = 4
lowest = 0.0

[[method]]
type = "gradient"
way = [1.0, 0.1, 0.0]
starts = 2
trial = 3
iterations = 30
rounds = 1

[[method]]
type = "random"
batch = 8
"""


@pytest.fixture
def module(tmp_path, monkeypatch):
    """A module beside a study's file; forgotten afterwards."""
    monkeypatch.setattr(sys, "path", list(sys.path))
    name = f"own_{tmp_path.name.replace('-', '_')}"
    (tmp_path / f"{name}.py").write_text(MODULE)
    (tmp_path / "study.toml").write_text(STUDY.format(name=f"{name}:make"))
    yield name
    sys.modules.pop(name, None)


def best_of(result, label) -> Score:
    score = result.of(label)[0].score
    assert score is not None
    return score


def test_a_module_beside_the_file_is_found_and_its_task_searched(module, tmp_path):
    result = run_study(tmp_path / "study.toml", tmp_path / "results")
    gradient, drawn = best_of(result, "gradient"), best_of(result, "random")
    assert gradient.value > -1e-3 > drawn.value > result.baselines["nothing"].value
    assert gradient.episode.counters["last_velocity"] == pytest.approx(0.5, abs=1e-3)


def test_from_the_command_line_a_task_of_ones_own_is_a_script_that_check_does_not_run(module, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = (tmp_path / f"{module}.py").read_text()
    (tmp_path / f"{module}.py").write_text("raise SystemExit('it was run')\n")
    assert main(["check", "study.toml"]) == 0
    assert "which check does not import" in capsys.readouterr().out
    (tmp_path / f"{module}.py").write_text(text)
    command = [sys.executable, "-m", "granular_env", "study", "study.toml", "--only", "random", "--quiet"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env=environment)
    assert (done.returncode, done.stdout, done.stderr) == (0, "studies/own/report.html\n", "")


def test_a_name_that_gymnasium_knows_is_a_task(module, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))
    gymnasium.register("own/Task-v0", entry_point=f"{module}:make", kwargs={"deadline": 30})
    try:
        for name in ("own/Task-v0", f"{module}:own/Task-v0"):
            problem = TaskProblem(name, {"target": 2.0})
            assert (problem.steps, problem.env.task.target) == (30, 2.0)
            drives = np.zeros((2, 30, 1))
            assert problem.returns(drives, [1])[0].tolist() == [-2.0, -2.0]
        with pytest.raises(ParameterError, match="traget: unknown; did you mean 'target'?"):
            TaskProblem("own/Task-v0", {"traget": 2.0})
    finally:
        del gymnasium.registry["own/Task-v0"]


def test_what_is_no_task_is_one_clear_fault(module, tmp_path):
    cases = {
        "no_such_module:make": "there is no module 'no_such_module' in .* and on Python's path",
        f"{module}:mkae": "the module has no 'mkae'; did you mean 'make'?",
        f"{module}:answer": "which is 42, expected what makes a ComponentEnv",
        f"{module}:no_chain": "it makes 3, expected a ComponentEnv",
        f"{module}:LastVelocity": "it makes a task, expected its environment",
        f"{module}:own/Missing-v0": "got 'own/Missing-v0', expected the name of a task",
        f"{module}:boom": f"^task {module}:boom: it ends with RuntimeError: boom$",
        "own/Missing-v0": "or 'module:id' of one that it registers",
        "pulse-formign": "did you mean 'pulse-forming'?",
    }
    for name, said in cases.items():
        with pytest.raises(ParameterError, match=said):
            TaskProblem(name, {}, tmp_path)
    with pytest.raises(ParameterError) as caught:
        TaskProblem("own/Missing-v0", {})
    assert "phys2d" not in str(caught.value) and "pulse-forming" in str(caught.value)
    (tmp_path / "broken_module.py").write_text("import numpy\n1 / 0\n")
    with pytest.raises(ParameterError, match="its import ends with ZeroDivisionError: division by zero"):
        TaskProblem("broken_module:make", {}, tmp_path)
    (tmp_path / "study.toml").write_text(STUDY.format(name=f"{module}:mkae"))
    with pytest.raises(ExperimentError, match=r"study.toml: task.name: got .*:mkae'") as caught:
        run_study(tmp_path / "study.toml", tmp_path / "results")
    assert len(str(caught.value).splitlines()) == 1 and not (tmp_path / "results").exists()


def test_a_stage_belongs_to_the_objective_alone(module, tmp_path):
    problem = TaskProblem(f"{module}:make", {}, tmp_path)
    drive = np.full((problem.steps, 1), 0.3)
    plain, _ = problem.value_and_grad(drive, [1])
    problem.stage = {"way": 1.0}
    staged, slopes = problem.value_and_grad(drive, [1])
    assert staged > plain and np.abs(slopes).max() > 0.0
    problem.stage = {"way": 0.0}
    assert problem.value_and_grad(drive, [1])[0] == plain
    problem.stage = {"sharpness": (5, 0.01)}
    with pytest.raises(ParameterError, match=r"sharpness: got .*'last velocity' takes no 'sharpness'"):
        problem.value_and_grad(drive, [1])


def test_the_way_finds_a_wave_that_the_end_alone_does_not(tmp_path):
    """Two thirds of the way through a short chain: without the way the slopes lead to a wave in a wrong place."""
    task = {"name": "pulse-forming", "grains": 20, "place": 12.0, "deadline": 60, "internal_steps": 3}
    method = {"type": "gradient", "starts": 1, "spread": 0.05, "trial": 1, "iterations": 25, "rounds": 1}
    study = {"version": 1, "name": "way", "budget": 100_000, "task": task, "drive": {"knots": 40, "driven": 40}}
    found = {}
    for name, options in (("plain", {}), ("staged", {"way": [1.0, 0.3, 0.0]})):
        result = run_study({**study, "method": [{**method, **options}]}, tmp_path / name)
        found[name] = best_of(result, "gradient").value
    assert found["staged"] > -0.02 and found["staged"] > found["plain"]
