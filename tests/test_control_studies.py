"""Studies: files, drives, counting, state after a kill, comparison, custom tasks."""

import csv
import signal
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from support.control_toys import Bowl, bowl_study

from granular_env.cli import main
from granular_env.components.errors import ExperimentError, MissingExtraError, ParameterError
from granular_env.control import figure
from granular_env.control.drive import DriveShape
from granular_env.control.problem import Problem
from granular_env.control.runner import run_study
from granular_env.control.study import Study, load_study
from granular_env.documents import parse_assignments, to_toml
from granular_env.package_contents import shipped_files
from granular_env.recording import verify

ROOT = Path(__file__).resolve().parents[1]
SEARCHES = [{"type": "gradient"}, {"type": "cma"}, {"type": "random"}]
SMALL = {
    "version": 1, "name": "small", "budget": 3000,
    "task": {"name": "protection", "grains": 6, "deadline": 60, "impulse": 0.005},
    "drive": {"knots": 4, "lowest": 0.0}, "method": [{"type": "random", "batch": 8}, {"type": "cma", "population": 8}],
}  # fmt: skip


@pytest.fixture(autouse=True)
def without_figure(request, monkeypatch):
    """Omit the figure, which takes most of the time of a small study, in tests that do not check it."""
    if request.node.get_closest_marker("figures") is None:
        monkeypatch.setattr(figure, "draw_study", lambda result: b"")


# -- drives ---------------------------------------------------------------------------------------------------------------


def test_linear_knots_are_met_and_joined_by_straight_lines():
    shape = DriveShape(steps=12, entries=2, knots=3, driven=9)
    first, second = [0.0, 0.8, -0.4], [1.0, 1.0, 0.0]
    actions = shape.actions(np.array([first + second]))[0]
    np.testing.assert_allclose(actions[:9, 0], [0, 0.2, 0.4, 0.6, 0.8, 0.5, 0.2, -0.1, -0.4], atol=1e-15)
    np.testing.assert_allclose(actions[:9, 1], [1, 1, 1, 1, 1, 0.75, 0.5, 0.25, 0], atol=1e-15)
    assert not actions[9:].any()


def test_held_knots_hold_and_lie_within_the_bounds():
    shape = DriveShape(steps=6, entries=1, knots=2, between="held", lowest=0.0)
    assert shape.actions(np.array([[-0.5, 3.0]]))[0, :, 0].tolist() == [0, 0, 0, 1, 1, 1]


def test_the_rate_limit_follows_as_fast_as_it_may():
    shape = DriveShape(steps=5, entries=1, knots=5, between="held", rate=0.25)
    assert shape.actions(np.array([[1.0, 1.0, 0.4, 0.4, -1.0]]))[0, :, 0].tolist() == [0.25, 0.5, 0.4, 0.4, 0.4 - 0.25]


@pytest.mark.parametrize("rate", [None, 0.07])
@pytest.mark.parametrize("between", ["linear", "held"])
def test_slopes_of_a_drive_are_those_of_central_differences(between, rate):
    shape = DriveShape(steps=40, entries=2, knots=5, between=between, driven=31, rate=rate)
    draw = np.random.default_rng(3)
    point, weights = draw.uniform(-0.9, 0.9, shape.size), draw.normal(size=(40, 2))
    numbers = lambda points: (shape.actions(points) * weights).sum(axis=(1, 2))  # noqa: E731
    step = 1e-6 * np.eye(shape.size)
    differences = (numbers(point + step) - numbers(point - step)) / 2e-6
    np.testing.assert_allclose(shape.pullback(point, weights), differences, atol=1e-8)


@pytest.mark.parametrize("between", ["linear", "held"])
def test_the_point_of_a_drive_is_found_again(between):
    shape = DriveShape(steps=30, entries=2, knots=6, between=between, driven=25)
    point = np.random.default_rng(1).uniform(-1.0, 1.0, shape.size)
    np.testing.assert_allclose(shape.fit_point(shape.actions(point[None])[0]), point, atol=1e-13)
    # A drive that ends early is 0 afterwards.
    assert not shape.fit_point(np.zeros((3, 2))).any()


# -- files ----------------------------------------------------------------------------------------------------------------


def test_a_study_is_written_as_it_is_read():
    document = bowl_study({"type": "cma", "name": "wide", "spread": 0.4}, {"type": "gradient"}, description='a "b"\nc\\')
    study = load_study(document)
    assert tomllib.loads(to_toml(study.to_dict())) == document


@pytest.mark.parametrize(
    ("document", "told"),
    [
        (bowl_study(version=2), "study: version: got 2, expected 1"),
        (bowl_study({"type": "cmaes"}), "study: method[0].type: got 'cmaes'; did you mean 'cma'?"),
        (bowl_study({"type": "cma", "populaton": 3}), "study: method[0].populaton: unknown; did you mean 'population'?"),
        (bowl_study({"type": "cma"}, {"type": "cma"}), "method: 'cma' occurs more than once; give each a different name"),
        (bowl_study(drive={"lowest": 0.5, "highest": 0.5}), "study: drive.highest: got 0.5, expected more than lowest (0.5)"),
        (bowl_study(bugdet=1), "study: bugdet: unknown; did you mean 'budget'?"),
        ({key: value for key, value in bowl_study().items() if key != "method"}, "study: method: missing; give tables"),
    ],
)
def test_what_is_wrong_with_a_study_is_named(document, told):
    with pytest.raises(ExperimentError) as error:
        load_study(document)
    assert told in str(error.value)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("task.name=protecton", "task.name: got 'protecton', expected the name of a task; did you mean 'protection'?"),
        ("task.grians=5", "task.grians: unknown; did you mean 'grains'?"),
        ("drive.knots=100", "drive.knots: got 100, expected a whole number from 1 to 60"),
        ("budget=59", "budget: got 59, expected a whole number of at least 60"),
    ],
)
def test_what_does_not_fit_the_task_is_named_before_anything_is_written(change, told, tmp_path):
    with pytest.raises(ExperimentError) as error:
        run_study(SMALL, tmp_path / "out", overrides=parse_assignments([change]))
    assert told in str(error.value)
    assert not (tmp_path / "out").exists()


# -- methods --------------------------------------------------------------------------------------------------------------


def test_every_method_gets_the_same_budget_and_none_exceeds_it(tmp_path):
    result = run_study(bowl_study(*SEARCHES, seeds=[1, 2]), tmp_path, problem=Bowl())
    assert [trial.name for trial in result.trials] == [f"{one['type']}-{seed}" for one in SEARCHES for seed in (1, 2)]
    for trial in result.trials:
        # The remaining budget is too small for another evaluation of a drive, or of an objective with slopes.
        assert 4000 - 4 * Bowl.steps < trial.spent <= 4000
        assert trial.score.value == pytest.approx(trial.search_return, abs=1e-15)
        best = [value for _, value in trial.curve]
        assert best == sorted(best) and best[-1] == trial.search_return
    found = {one["type"]: result.method_trials(one["type"])[0].score.value for one in SEARCHES}
    # The best drive is a straight line, which knots can represent but uniform random knots do not find.
    assert found["gradient"] > -1e-15 and found["random"] < found["cma"] < 1e-15


def test_slopes_count_as_forward_runs(tmp_path):
    problem = Bowl()
    once = {"type": "gradient", "starts": 1, "trial": 1, "iterations": 1, "rounds": 1}
    [trial] = run_study(bowl_study(once), tmp_path, problem=problem).trials
    # Each drive that lowers the objective is also evaluated by its return: a return costs 1 run, an objective with slopes 4.
    runs = trial.spent // Bowl.steps
    slopes = (runs - problem.asked) // 3
    assert trial.spent == Bowl.steps * (4 * slopes + problem.asked - slopes) < 4000 and slopes >= 2


def test_a_budget_that_is_too_small_for_a_first_result_is_refused(tmp_path):
    least = 5 * Bowl().steps
    with pytest.raises(ExperimentError, match=f"budget: got {least - 1}, expected a whole number of at least {least}"):
        run_study(bowl_study({"type": "gradient"}, budget=least - 1), tmp_path / "a", problem=Bowl())
    assert run_study(bowl_study({"type": "gradient"}, budget=least), tmp_path / "a", problem=Bowl()).method_trials("gradient")


def test_a_gradient_of_a_task_without_one_is_refused_before_anything_is_computed(tmp_path):
    study = load_study("splitting", {"method": [{"type": "random"}, {"type": "gradient"}]})
    with pytest.raises(ExperimentError, match=r"method\[1\]\.type: got 'gradient', but task 'splitting' has no objective"):
        run_study(study, tmp_path / "study")
    assert not (tmp_path / "study").exists()


@pytest.mark.parametrize("method", ["gradient", "cma"])
def test_a_search_may_begin_at_a_baseline(method, tmp_path):
    [trial] = run_study(bowl_study({"type": method, "begin": "theory"}, budget=400), tmp_path / "a", problem=Bowl()).trials
    theory = -float(np.mean((0.25 - Bowl().target) ** 2))
    assert trial.spent <= 400 and trial.search_return > -float(np.mean(Bowl().target ** 2))
    if method == "gradient":
        assert trial.search_return > theory and trial.curve[0][1] == pytest.approx(theory, rel=1e-12)
    with pytest.raises(ExperimentError, match="begin: got 'theroy', expected a baseline of this task; did you mean 'theory'"):
        run_study(bowl_study({"type": method, "begin": "theroy"}), tmp_path / "b", problem=Bowl())


def test_the_same_seed_finds_the_same_and_another_seed_another(tmp_path):
    first = run_study(bowl_study(*SEARCHES), tmp_path / "a", problem=Bowl())
    np.random.seed(5)  # noqa: NPY002  what others draw from numpy's global generator changes nothing
    second = run_study(bowl_study(*SEARCHES), tmp_path / "b", problem=Bowl())
    other = run_study(bowl_study(*SEARCHES, seeds=[2]), tmp_path / "c", problem=Bowl())
    assert first.trials == second.trials
    assert (tmp_path / "a" / "table.csv").read_bytes() == (tmp_path / "b" / "table.csv").read_bytes()
    assert all(one.score != another.score for one, another in zip(first.trials, other.trials, strict=True))


# -- kills, Ctrl-C, NaN ---------------------------------------------------------------------------------------------------

ENDED = """
import sys
sys.path.insert(0, {tests!r})
from support.control_toys import Bowl, bowl_study
from granular_env.control import figure, runner
figure.draw_study = lambda result: b""
print(runner.run_study(bowl_study(*{methods!r}), {folder!r}, problem=Bowl(sent={sent}, sent_at=200)).interrupted)
"""


@pytest.mark.parametrize("sent", [signal.SIGKILL, signal.SIGINT], ids=["killed", "ctrl-c"])
def test_a_study_that_was_ended_keeps_its_finished_trials_and_finds_what_an_uninterrupted_one_finds(sent, tmp_path):
    whole = run_study(bowl_study(*SEARCHES), tmp_path / "whole", problem=Bowl())
    code = ENDED.format(tests=str(ROOT / "tests"), methods=SEARCHES, folder=str(tmp_path / "ended"), sent=int(sent))
    ended = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert ended.stdout == ("" if sent == signal.SIGKILL else "True\n"), ended.stderr
    assert [path.stem for path in (tmp_path / "ended" / "trials").iterdir()] == ["gradient-1"]  # ended in the second search
    problem = Bowl()
    again = run_study(bowl_study(*SEARCHES), tmp_path / "ended", problem=problem)
    assert again.trials == whole.trials and problem.asked < 450  # the gradient trial is read, not repeated
    assert (tmp_path / "ended" / "table.csv").read_bytes() == (tmp_path / "whole" / "table.csv").read_bytes()


def test_trials_of_another_budget_seed_or_option_are_computed_and_others_are_kept(tmp_path):
    run_study(bowl_study({"type": "random"}), tmp_path, problem=Bowl())
    for changes, computed in (({}, False), ({"name": "other"}, False), ({"seeds": [1, 2]}, True), ({"budget": 300}, True)):
        problem = Bowl()
        run_study(bowl_study({"type": "random"}, **changes), tmp_path, problem=problem)
        assert bool(problem.asked) == computed
    path = tmp_path / "trials" / "random-1.json"
    path.write_text(path.read_text()[:-20])
    problem = Bowl()
    run_study(bowl_study({"type": "random"}, budget=300), tmp_path, problem=problem)
    assert problem.asked == 15  # a damaged file does not count as a trial


def test_a_return_that_is_no_number_ends_its_method_and_the_others_run(tmp_path):
    with pytest.raises(ExperimentError, match="random-1: the return is nan after 60 control steps, expected a finite number"):
        run_study(bowl_study({"type": "random"}, {"type": "cma"}), tmp_path, problem=Bowl(broken_at=4))
    assert [path.stem for path in (tmp_path / "trials").iterdir()] == ["cma-1"]


# -- results of a study ---------------------------------------------------------------------------------------------------


@pytest.mark.figures
def test_a_study_of_an_environment_leaves_a_table_a_figure_and_logs_that_replay(tmp_path):
    result = run_study(SMALL, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"study.toml", "trials", "logs", "table.csv", "figure.png"}
    assert (tmp_path / "figure.png").read_bytes().startswith(b"\x89PNG")
    for trial in result.trials:
        # The search's batch and the evaluating single environment are bitwise identical.
        assert trial.score.value == trial.search_return
        assert verify(tmp_path / "logs" / f"{trial.name}.mcap").identical
    rows = list(csv.DictReader((tmp_path / "table.csv").open()))
    names = [f"baseline {name}" for name in result.baselines]
    assert [row["method"] for row in rows] == ["random", "cma", *names] and result.baselines["nothing"].value == 0.0
    assert [float(row["return"]) for row in rows[:2]] == [trial.score.value for trial in result.trials]


def test_the_lower_median_of_the_seeds_decides_what_a_method_beats(tmp_path):
    result = run_study(bowl_study({"type": "random", "batch": 1}, seeds=[1, 2], budget=100), tmp_path, problem=Bowl())
    values = sorted(trial.score.value for trial in result.trials)
    heads, row = result.comparison()
    assert row[1:4] == [values[0], values[0], values[1]]
    assert heads[5:] == ["beats nothing", "beats theory"]
    assert row[5:] == ["yes" if values[0] > score.value else "no" for score in result.baselines.values()]


def test_methods_whose_package_is_missing_say_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    monkeypatch.setitem(sys.modules, "cma", None)
    for method, extra in (("ppo", "rl"), ("cma", "control")):
        with pytest.raises(MissingExtraError, match=rf"method '{method}' needs .*pip install 'granular-env\[{extra}\]'"):
            run_study(bowl_study({"type": method}), tmp_path / "a", problem=Bowl())
    assert not (tmp_path / "a").exists()


# -- the command line -----------------------------------------------------------------------------------------------------


def test_the_command_checks_runs_lists_and_copies_studies(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("small.toml").write_text(to_toml(load_study(SMALL).to_dict()))
    assert main(["check", "small.toml"]) == 0
    found = "task protection of 60 control steps, 4 numbers to choose, 3000 control steps for each of random, cma"
    assert capsys.readouterr().out == f"valid: small, {found}\n"
    assert main(["check", "small.toml", "--set", "task.name=protecton"]) == 2
    assert "did you mean 'protection'?" in capsys.readouterr().err
    command = ["study", "small.toml", "--set", "budget=1000", "--only", "random"]
    assert main(command) == 0
    told = capsys.readouterr().out
    assert "beats nothing" in told and "baselines: nothing 0" in told and "table: studies/small/table.csv" in told
    assert main([*command, "--quiet"]) == 0 and capsys.readouterr().out == "studies/small/table.csv\n"
    assert main(["study", "small.toml", "--only", "rnadom"]) == 2
    assert "did you mean 'random'?" in capsys.readouterr().err
    assert main(["study", "--list"]) == 0
    told = capsys.readouterr().out
    for name in shipped_files(Study.shelf):
        assert name in told
        assert main(["check", name]) == 0
        assert main(["new", name, "-o", f"{name}.toml"]) == 0
        assert load_study(f"{name}.toml").to_dict() == load_study(name).to_dict()


# -- custom tasks ---------------------------------------------------------------------------------------------------------

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

    def evaluate_rows(self, rows, constants, counters, elapsed):
        last = counters["last_velocity"] = rows.velocity[..., -1]
        return np.where(elapsed == self.deadline, -np.abs(last - self.target), 0.0), False

    def objective(self, chain, steps, *, way=0.0):
        goal = velocity(-1).at_end(target=self.target)
        return total(chain, goal, way * velocity(3).mean(target=1.0)) if way else total(chain, goal)


def make(target=1.0, deadline=40, step_size=5e-7, **options):
    chain = ge.make("chain", grains=6, step_size=step_size)
    return ComponentEnv(chain, LastVelocity(target, deadline), deadline=deadline, **options)


def no_chain(clock):
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
stages = [{{ way = 1.0 }}, {{ way = 0.1 }}, {{ way = 0.0 }}]
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
    """Write a module next to a study's file; unload it afterwards."""
    monkeypatch.setattr(sys, "path", list(sys.path))
    name = f"own_{tmp_path.name.replace('-', '_')}"
    (tmp_path / f"{name}.py").write_text(MODULE)
    (tmp_path / "study.toml").write_text(STUDY.format(name=f"{name}:make"))
    yield name
    sys.modules.pop(name, None)


def test_a_module_beside_the_file_is_found_and_its_task_searched(module, tmp_path):
    result = run_study(tmp_path / "study.toml", tmp_path / "results")
    values = {trial.method: trial.score.value for trial in result.trials}
    assert values["gradient"] > -1e-3 > values["random"] > result.baselines["nothing"].value
    # An edited task counts as a different task.
    path = tmp_path / f"{module}.py"
    path.write_text(path.read_text().replace("last - self.target", "last - 2.0 * self.target"))
    sys.modules.pop(module)
    assert run_study(tmp_path / "study.toml", tmp_path / "results", only=["random"]).trials[0].score.value != values["random"]


def test_check_does_not_import_a_task_of_ones_own(module, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / f"{module}.py").write_text("raise SystemExit('it was run')\n")
    assert main(["check", "study.toml"]) == 0
    assert "whose code `check` does not import" in capsys.readouterr().out


def test_what_is_no_task_is_one_clear_fault(module, tmp_path):
    cases = {
        "no_such_module:make": "name: got 'no_such_module:make': No module named 'no_such_module'",
        f"{module}:mkae": "has no attribute 'mkae'",
        f"{module}:no_chain": "it returns 3, expected a ComponentEnv",
        "pulse-formign": "did you mean 'pulse-forming'?",
    }
    for name, said in cases.items():
        with pytest.raises(ParameterError, match=said):
            Problem(name, {}, tmp_path)


def test_a_stage_belongs_to_the_objective_alone(module, tmp_path):
    problem = Problem(f"{module}:make", {}, tmp_path)
    drive = np.full((problem.steps, 1), 0.3)
    plain, _ = problem.value_and_grad(drive, [1])
    problem.stage = {"way": 1.0}
    staged, slopes = problem.value_and_grad(drive, [1])
    assert staged > plain and np.abs(slopes).max() > 0.0
    problem.stage = {"way": 0.0}
    assert problem.value_and_grad(drive, [1])[0] == plain
    problem.stage = {"sharpness": (5, 0.01)}
    with pytest.raises(ParameterError, match=r"sharpness: got .*'last velocity' has no argument 'sharpness'"):
        problem.value_and_grad(drive, [1])


def test_the_way_finds_a_wave_that_the_end_alone_does_not(tmp_path):
    """Two thirds along a short chain: without the weight `way`, the gradient leads to a misplaced wave."""
    task = {"name": "pulse-forming", "grains": 20, "place": 12.0, "deadline": 60, "internal_steps": 3}
    method = {"type": "gradient", "starts": 1, "spread": 0.05, "trial": 1, "iterations": 25, "rounds": 1}
    study = {"version": 1, "name": "way", "budget": 100_000, "task": task, "drive": {"knots": 40, "driven": 40}}
    found = {}
    for name, options in (("plain", {}), ("staged", {"stages": [{"way": 1.0}, {"way": 0.3}, {"way": 0.0}]})):
        result = run_study({**study, "method": [{**method, **options}]}, tmp_path / name)
        found[name] = result.method_trials("gradient")[0].score.value
    assert found["staged"] > -0.02 and found["staged"] > found["plain"]
