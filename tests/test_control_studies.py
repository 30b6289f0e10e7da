"""Studies: files, drives, counting, records that a kill cannot break, the comparison, and what a user is told."""

import json
import os
import random
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from support.control_toys import Bowl, bowl_study

from granular_env.cli import main
from granular_env.components.errors import ExperimentError, MissingExtraError, ParameterError
from granular_env.control.drive import Drive, DriveShape
from granular_env.control.study import figures, load_study, runner, shipped_studies
from granular_env.control.study.console import closing
from granular_env.control.study.method_comparison import headings, verdicts
from granular_env.control.study.methods.gradient import Gradient
from granular_env.control.study.runner import run_study
from granular_env.control.study.trial_record import PLAYED, RETURN, TrialRecord
from granular_env.documents import parse_assignments, to_toml
from granular_env.recording import verify

ROOT = Path(__file__).resolve().parents[1]
SEARCHES = ("gradient", "cma", "random")
SMALL = {
    "version": 1, "name": "small", "budget": 3000,
    "task": {"name": "protection", "grains": 6, "deadline": 60, "impulse": 0.005},
    "drive": {"knots": 4, "lowest": 0.0}, "method": [{"type": "random", "batch": 8}, {"type": "cma", "population": 8}],
}  # fmt: skip


@pytest.fixture(autouse=True)
def without_figures(request, monkeypatch):
    """Leave out the drawing, most of the time of a small study, where a test does not look at the figures."""
    if request.node.get_closest_marker("figures") is None:
        monkeypatch.setattr(figures, "pictures", lambda result: {})


def results_of(folder: Path) -> dict:
    return json.loads((folder / "results.json").read_text())


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
    np.testing.assert_allclose(shape.fit(shape.actions(point[None])[0]), point, atol=1e-13)
    # What ends early is rest from there on.
    assert not shape.fit(np.zeros((3, 2))).any()


def test_a_drive_is_an_agent_that_rests_after_its_end():
    drive = Drive(np.array([[0.5], [0.25]]))
    for _ in range(2):
        drive.reset()
        assert [float(drive(None, {})[0]) for _ in range(3)] == [0.5, 0.25, 0.0]


# -- files ----------------------------------------------------------------------------------------------------------------


def test_a_study_is_written_as_it_is_read():
    document = bowl_study({"type": "cma", "name": "wide", "spread": 0.4}, {"type": "gradient"}, description='a "b"\nc\\')
    study = load_study(document)
    assert tomllib.loads(to_toml(study.to_dict())) == document
    assert load_study(tomllib.loads(to_toml(study.to_dict()))).identity == study.identity


def test_the_identity_knows_what_changes_a_result():
    study = load_study(bowl_study())
    assert load_study(study, {"budget": 9}).identity == study.identity == load_study(study, {"name": "other"}).identity
    for change in ("seeds=[2]", "task.grains=3", "drive.knots=5", "method.0.batch=7", "episodes=2"):
        assert load_study(study, parse_assignments([change])).identity != study.identity


@pytest.mark.parametrize(
    ("document", "told"),
    [
        (bowl_study(version=2), "study: version: got 2, expected 1"),
        ({"name": "a"}, "study: version: missing"),
        (bowl_study({"type": "cmaes"}), "study: method[0].type: got 'cmaes'; did you mean 'cma'?"),
        (bowl_study({"name": "a"}), "study: method[0].type: missing"),
        (bowl_study({"type": "cma", "populaton": 3}), "study: method[0].populaton: unknown; did you mean 'population'?"),
        (
            bowl_study({"type": "cma", "population": 2}),
            "study: method[0].population: got 2, expected greater",
        ),
        (bowl_study({"type": "cma"}, {"type": "cma"}), "method: 'cma' more than once; give each a name of its own"),
        (bowl_study({"type": "cma", "name": "../a"}), "study: method[0].name"),
        (bowl_study(drive={"knots": 0}), "study: drive.knots: got 0"),
        (bowl_study(drive={"between": "cubic"}), "study: drive.between: got 'cubic'"),
        (bowl_study(drive={"lowest": 0.5, "highest": 0.5}), "study: drive.highest: got 0.5, expected more than lowest, 0.5"),
        (bowl_study(seeds=[1, 1]), "study: seeds: got [1, 1], expected different whole numbers"),
        (bowl_study(budget=0), "study: budget: got 0"),
        (bowl_study(bugdet=1), "study: bugdet: unknown; did you mean 'budget'?"),
        (bowl_study(task={}), "study: task.name: missing"),
        (bowl_study(task={"name": "protection", "impulse": float("inf")}), "study: task: not usable"),
        ({key: value for key, value in bowl_study().items() if key != "task"}, "study: task: missing; give a table [task]"),
        ({key: value for key, value in bowl_study().items() if key != "method"}, "study: method: missing; give tables"),
    ],
)
def test_what_is_wrong_with_a_study_is_named(document, told):
    with pytest.raises(ExperimentError) as error:
        load_study(document)
    assert told in str(error.value)


@pytest.mark.parametrize(
    ("override", "told"),
    [
        ("bugdet=3", "override 'bugdet=3': bugdet: unknown; did you mean 'budget'?"),
        ("drive.knot=3", "drive.knot: unknown; did you mean 'knots'?"),
        ("method.1.batch=3", "got the index '1', expected -1 to 0"),
        ("method.0.bach=3", "method[0].bach: unknown; did you mean 'batch'?"),
        ("budget.a=3", "budget is 4000, so it has no 'a'"),
    ],
)
def test_what_is_wrong_with_an_override_is_named(override, told):
    with pytest.raises(ExperimentError) as error:
        load_study(bowl_study(), parse_assignments([override]))
    assert told in str(error.value)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("task.name=protecton", "task.name: got 'protecton', expected the name of a task; did you mean 'protection'?"),
        ("task.grians=5", "task.grians: unknown; did you mean 'grains'?"),
        ("task.noize=0.1", "task.noize: unknown; did you mean 'noise'?"),
        ("task.grains=-5", "task.grains: got -5"),
        ("drive.knots=100", "drive.knots: got 100, expected at most 60"),
        ("drive.driven=100", "drive.driven: got 100, expected at most 60"),
        ("budget=59", "budget: got 59, expected at least 60, which the first result of 'random' takes"),
    ],
)
def test_what_does_not_fit_the_task_is_named_before_anything_is_written(change, told, tmp_path):
    with pytest.raises(ExperimentError) as error:
        run_study(SMALL, tmp_path / "out", overrides=parse_assignments([change]))
    assert told in str(error.value)
    assert not (tmp_path / "out").exists()


# -- methods --------------------------------------------------------------------------------------------------------------


def test_a_gradient_of_a_task_without_one_is_refused_before_anything_is_computed(tmp_path):
    study = load_study("splitting", {"method": [{"type": "random"}, {"type": "gradient"}]})
    with pytest.raises(ExperimentError, match=r"method\[1\]\.type: got 'gradient', but task 'splitting' has no objective"):
        run_study(study, tmp_path / "study")
    assert not (tmp_path / "study").exists()


def test_a_gradient_wants_the_budget_of_an_objective_with_its_slopes_and_a_return(tmp_path):
    study = bowl_study({"type": "gradient"})
    least = 5 * Bowl().steps
    with pytest.raises(ExperimentError, match=f"budget: got {least - 1}, expected at least {least}, .* 'gradient' takes"):
        run_study(study, tmp_path / "a", overrides={"budget": least - 1}, problem=Bowl())
    assert run_study(study, tmp_path / "a", overrides={"budget": least}, problem=Bowl()).of("gradient")


def test_every_method_gets_the_same_budget_and_none_exceeds_it(tmp_path):
    methods = [{"type": "gradient"}, {"type": "cma"}, {"type": "random"}, {"type": "policy", "population": 8}]
    result = run_study(bowl_study(*methods, seeds=[1, 2]), tmp_path, problem=Bowl())
    assert [trial.name for trial in result.trials] == [f"{one['type']}-{seed}" for one in methods for seed in (1, 2)]
    for trial in result.trials:
        # What is left holds no further evaluation: a drive, or an objective with its slopes.
        assert 4000 - 4 * Bowl.steps < trial.record.spent <= 4000
        assert trial.record.finished and trial.score is not None
        assert trial.score.value == pytest.approx(trial.record.best_return, abs=1e-15)
    found = {label: result.of(label)[0].score.value for label in result.labels()}
    # The best drive is a straight line, which knots and a linear policy can be; evenly drawn knots are not.
    assert found["gradient"] > -1e-15
    assert found["random"] < found["cma"] < 1e-15
    assert found["policy"] > found["random"]


def test_slopes_count_as_forward_runs_and_so_does_judging(tmp_path):
    problem = Bowl()
    result = run_study(
        bowl_study({"type": "gradient", "starts": 1, "trial": 1, "iterations": 1, "rounds": 1}), tmp_path, problem=problem
    )
    record = result.trials[0].record
    returns, slopes = record.count(RETURN), len(record) - record.count(RETURN)
    assert returns >= 1 and slopes >= 2
    assert record.spent == Bowl.steps * (returns + 4 * slopes) < 4000
    assert problem.asked == returns + slopes


@pytest.mark.parametrize("method", ["gradient", "cma"])
def test_a_search_may_begin_at_a_baseline(method, tmp_path):
    study = bowl_study({"type": method, "begin": "theory"}, budget=20 * Bowl.steps)
    record = run_study(study, tmp_path / "a", problem=Bowl()).trials[0].record
    # Looking at the baseline costs an episode; the first drive of the gradient is the baseline's, the best is better.
    assert record.count(PLAYED) == 1 and record.spent <= 400
    theory = -float(np.mean((0.25 - Bowl().target) ** 2))
    if method == "gradient":
        assert record._values[2] == pytest.approx(theory, rel=1e-12)
        assert record.best_return > theory
    with pytest.raises(ExperimentError, match="begin: got 'theroy', expected a baseline of this task; did you mean 'theory'"):
        run_study(bowl_study({"type": method, "begin": "theroy"}), tmp_path / "b", problem=Bowl())


def test_the_same_seed_finds_the_same_and_another_seed_another(tmp_path):
    methods = [{"type": name} for name in SEARCHES]
    first = run_study(bowl_study(*methods), tmp_path / "a", problem=Bowl())
    np.random.seed(5)  # noqa: NPY002  what others draw from numpy's global generator changes nothing
    second = run_study(bowl_study(*methods), tmp_path / "b", problem=Bowl())
    other = run_study(bowl_study(*methods, seeds=[2]), tmp_path / "c", problem=Bowl())
    for one, same, different in zip(first.trials, second.trials, other.trials, strict=True):
        assert np.array_equal(one.record.best["point"], same.record.best["point"])
        assert not np.array_equal(one.record.best["point"], different.record.best["point"])
    assert (tmp_path / "a" / "results.json").read_bytes() == (tmp_path / "b" / "results.json").read_bytes()


def test_a_larger_budget_goes_on_and_finds_what_it_would_have_found_at_once(tmp_path):
    methods = [{"type": name} for name in SEARCHES]
    run_study(bowl_study(*methods, budget=700), tmp_path / "a", problem=Bowl())
    problem = Bowl()
    run_study(bowl_study(*methods, budget=4000), tmp_path / "a", problem=problem)
    whole = Bowl()
    run_study(bowl_study(*methods, budget=4000), tmp_path / "b", problem=whole)
    assert results_of(tmp_path / "a") == results_of(tmp_path / "b")
    assert problem.asked < whole.asked
    with pytest.raises(ExperimentError, match="budget: got 699, but gradient-1 has simulated"):
        run_study(bowl_study(*methods, budget=699), tmp_path / "a", problem=Bowl())


# -- kills, Ctrl-C, NaN ---------------------------------------------------------------------------------------------------

KILLED = """
import sys
sys.path.insert(0, {tests!r})
from support.control_toys import Bowl, bowl_study
from granular_env.control.study import figures, runner
runner._SAVED_EVERY = 0.0
figures.pictures = lambda result: {{}}
runner.run_study(bowl_study(*({{"type": name}} for name in {methods!r})), {folder!r}, problem=Bowl(pause={pause}))
"""


def test_a_study_that_is_killed_again_and_again_finds_what_an_uninterrupted_one_finds(tmp_path):
    methods = [{"type": name} for name in SEARCHES]
    run_study(bowl_study(*methods), tmp_path / "whole", problem=Bowl())
    draw, killed = random.Random(1), 0
    while True:
        # So slow that it cannot end before it is killed, and then as fast as it can.
        pause = 0.02 if killed < 2 else 0.0
        code = KILLED.format(tests=str(ROOT / "tests"), methods=SEARCHES, folder=str(tmp_path / "killed"), pause=pause)
        started = subprocess.Popen([sys.executable, "-c", code], cwd=ROOT, stderr=subprocess.PIPE, text=True)
        _wait_for(tmp_path / "killed" / "checkpoints", started)
        try:
            started.wait(draw.uniform(0.0, 0.4) if killed < 2 else None)
        except subprocess.TimeoutExpired:
            started.send_signal(signal.SIGKILL)
            killed += started.wait() == -signal.SIGKILL
            continue
        assert started.returncode == 0, started.stderr.read()
        break
    assert killed == 2
    assert results_of(tmp_path / "killed") == results_of(tmp_path / "whole")
    for name in SEARCHES:
        path, owner = Path("checkpoints") / f"{name}-1.trial", _owner(methods, name)
        one, other = (TrialRecord.load(tmp_path / way / path, owner) for way in ("killed", "whole"))
        assert np.array_equal(one.best["point"], other.best["point"]) and len(one) == len(other)


def _owner(methods: list, name: str) -> dict:
    return {"study": load_study(bowl_study(*methods)).identity, "method": name, "seed": 1}


def _wait_for(folder: Path, started: subprocess.Popen) -> None:
    """Until a process has written a record, not only begun to import."""
    before = {path: path.stat().st_mtime_ns for path in folder.glob("*.trial")} if folder.exists() else {}
    while started.poll() is None:
        now = {path: path.stat().st_mtime_ns for path in folder.glob("*.trial")} if folder.exists() else {}
        if now != before:
            return
        time.sleep(0.01)


class Interrupting(Bowl):
    def _value(self, drive: np.ndarray) -> float:
        if self.asked == 50:
            os.kill(os.getpid(), signal.SIGINT)
        return super()._value(drive)


def test_ctrl_c_keeps_what_was_found_and_the_same_command_goes_on(tmp_path):
    methods = [{"type": "cma"}, {"type": "random"}]
    result = run_study(bowl_study(*methods), tmp_path / "a", problem=Interrupting())
    assert result.interrupted and results_of(tmp_path / "a")["interrupted"]
    first, second = result.trials
    assert first.score is not None and 0 < first.record.spent < 4000 and not first.record.finished
    assert second.score is None and not len(second.record)
    assert "interrupted" in (tmp_path / "a" / "report.html").read_text()
    run_study(bowl_study(*methods), tmp_path / "a", problem=Bowl())
    run_study(bowl_study(*methods), tmp_path / "b", problem=Bowl())
    assert results_of(tmp_path / "a") == results_of(tmp_path / "b")


@pytest.mark.parametrize("method", SEARCHES)
def test_a_return_that_is_no_number_is_named_and_what_came_before_is_kept(method, tmp_path):
    with pytest.raises(ExperimentError, match=rf"{method}-1: evaluation 38: the \w+ is nan, expected a finite number") as error:
        run_study(bowl_study({"type": method}, {"type": "random", "name": "next"}), tmp_path, problem=Bowl(broken_at=38))
    assert error.value.__notes__ == [f"results so far: {tmp_path}"]
    failed, other = results_of(tmp_path)["trials"]
    assert failed["evaluations"] == 37 and failed["return"] is not None and "nan" in failed["failure"]
    assert other["finished"] and not other["failure"]
    assert "ended early" in (tmp_path / "report.html").read_text()


def test_a_folder_of_another_study_is_refused_and_replaced_only_when_asked(tmp_path):
    run_study(bowl_study(), tmp_path / "a", problem=Bowl())
    before = (tmp_path / "a" / "results.json").read_bytes()
    with pytest.raises(ExperimentError, match="it holds another study, 'bowl', or this one with other keys"):
        run_study(bowl_study(drive={"knots": 5}), tmp_path / "a", problem=Bowl())
    assert (tmp_path / "a" / "results.json").read_bytes() == before
    (tmp_path / "a" / "logs" / "mine.mcap").write_text("not of the study")
    run_study(bowl_study({"type": "cma"}), tmp_path / "a", problem=Bowl(), overwrite=True)
    assert sorted(path.name for path in (tmp_path / "a" / "logs").iterdir()) == ["cma-1.mcap", "mine.mcap"]
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "notes.txt").write_text("mine")
    for overwrite in (False, True):
        with pytest.raises(ExperimentError, match="it holds files and no study"):
            run_study(bowl_study(), tmp_path / "b", problem=Bowl(), overwrite=overwrite)
    with pytest.raises(ParameterError, match="is a file, expected a folder"):
        run_study(bowl_study(), tmp_path / "b" / "notes.txt", problem=Bowl())


def test_records_that_are_damaged_or_of_another_path_are_named(tmp_path):
    run_study(bowl_study(), tmp_path, problem=Bowl())
    path = tmp_path / "checkpoints" / "random-1.trial"
    whole = path.read_bytes()
    path.write_bytes(whole[:-20])
    with pytest.raises(ExperimentError, match=r"random-1.trial: cannot be read: .*; pass overwrite=True to start anew"):
        run_study(bowl_study(), tmp_path, problem=Bowl())
    record = TrialRecord()
    record.add(RETURN, np.zeros(4), -1.0, 20)
    record.save(path, _owner([{"type": "random"}], "random"))
    with pytest.raises(ExperimentError, match="evaluation 1 of the record is of another point"):
        run_study(bowl_study(), tmp_path, problem=Bowl())


def test_a_best_point_of_another_length_is_named(tmp_path):
    run_study(bowl_study(), tmp_path, problem=Bowl())
    path, owner = tmp_path / "checkpoints" / "random-1.trial", _owner([{"type": "random"}], "random")
    record = TrialRecord.load(path, owner)
    record.best = {"point": np.zeros(7)}
    record.save(path, owner)
    with pytest.raises(ExperimentError, match=r"random-1.trial: the best that it holds does not fit.*pass overwrite=True"):
        run_study(bowl_study(), tmp_path, problem=Bowl())


def test_a_folder_that_cannot_be_filled_is_not_left_behind(tmp_path, monkeypatch):
    def full(*_):
        raise ExperimentError("no space left on device")

    monkeypatch.setattr(runner, "write_files", full)
    with pytest.raises(ExperimentError, match="no space left"):
        run_study(bowl_study(), tmp_path / "results", problem=Bowl())
    assert not (tmp_path / "results").exists()


def test_several_seeds_are_told_by_their_lower_median_and_their_spread(tmp_path):
    result = run_study(bowl_study(seeds=[1, 2, 3, 4]), tmp_path, problem=Bowl())
    values = sorted(trial.score.value for trial in result.trials)
    row = dict(zip(headings(result), verdicts(result)[0], strict=True))
    assert row["return (lower median)"] == values[1]
    assert (row["worst seed"], row["best seed"]) == (values[0], values[3])
    assert row["beats theory"] == ("yes" if values[1] > result.baselines["theory"].value else "no")


def test_chosen_methods_are_run_alone_and_the_others_later(tmp_path):
    study = bowl_study({"type": "random"}, {"type": "cma", "population": 8})
    alone = run_study(study, tmp_path, problem=Bowl(), only=["cma"])
    assert alone.labels() == ["cma"]
    both = run_study(study, tmp_path, problem=Bowl())
    assert both.labels() == ["random", "cma"]
    assert both.of("cma")[0].score.value == alone.of("cma")[0].score.value
    with pytest.raises(ExperimentError, match="only: got 'cmaa', which is no method of it; did you mean 'cma'?"):
        run_study(study, tmp_path, problem=Bowl(), only=["cmaa"])


def test_an_end_that_flew_off_does_not_flatten_the_picture():
    from matplotlib.figure import Figure

    wave = np.linspace(0.0, 1e-5, 20)
    for end, expected in ((-1e-3, 1.2e-5), (-1e-6, 1.2e-5)):
        axes = Figure().subplots()
        axes.plot([end, *wave])
        figures._let_ends_leave(axes, [np.array([end, *wave])])
        low, high = axes.get_ylim()
        assert high - low < 1.1 * expected and high >= 1e-5


def test_a_record_is_the_same_after_saving_and_loading(tmp_path):
    record = TrialRecord()
    record.add(0, np.array([0.1, 0.2]), 1.5, 20)
    record.add(1, np.array([0.1, 0.3]), -2.0, 80, np.array([3.0, 4.0]))
    record.add(2, None, 0.0, 640)
    record.agent, record.notes, record.finished = {"a|b": np.ones((2, 3), np.float32)}, {"budget": 9}, True
    record.save(tmp_path / "one.trial", {"study": "x"})
    again = TrialRecord.load(tmp_path / "one.trial", {"study": "x"})
    assert (len(again), again.spent, again.best_return, again.notes, again.finished) == (3, 740, 1.5, {"budget": 9}, True)
    assert again.value(1, 1, np.array([0.1, 0.3])) == -2.0 and again.slopes(1).tolist() == [3.0, 4.0]
    assert again.best["point"].tolist() == [0.1, 0.2] and np.array_equal(again.agent["a|b"], record.agent["a|b"])
    with pytest.raises(ExperimentError, match="belongs to another study"):
        TrialRecord.load(tmp_path / "one.trial", {"study": "y"})


# -- what is left of a study ----------------------------------------------------------------------------------------------


@pytest.mark.figures
def test_a_study_of_an_environment_leaves_results_figures_and_logs_that_replay(tmp_path):
    result = run_study(SMALL, tmp_path)
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {
        "study.toml", "checkpoints", "logs", "results.json", "curves.csv", "report.html", "convergence.png", "drives.png",
        "final.png", "final-1.png",
    }  # fmt: skip
    page = (tmp_path / "report.html").read_text()
    assert page.count(">Final state</h2>") == 1
    # Its figures take their colours from the page, which is light or dark with the reader's system.
    assert page.count("<svg") == 4 and "<img" not in page and "var(--c0)" in page
    for trial in result.trials:
        # The batch of the search and the single environment that judges give the same bits.
        assert trial.score.value == trial.record.best_return
        assert verify(trial.log).identical
    assert result.baselines["nothing"].value == 0.0
    told = results_of(tmp_path)
    assert [trial["beats"]["nothing"] for trial in told["trials"]] == [trial["return"] > 0.0 for trial in told["trials"]]
    curve = (tmp_path / "curves.csv").read_text().splitlines()
    assert curve[0] == "method,seed,control_steps,best_return"
    best = [float(line.split(",")[3]) for line in curve[1:] if line.startswith("cma")]
    assert best == sorted(best) and best[-1] == told["trials"][1]["return"]


@pytest.mark.figures
def test_the_page_shows_the_comparison_and_escapes_the_studys_words(tmp_path):
    run_study(bowl_study(description="<script>alert(1)</script>"), tmp_path, problem=Bowl())
    page = (tmp_path / "report.html").read_text()
    assert "<script" not in page and "&lt;script&gt;" in page and "default-src 'none'" in page
    assert "beats theory" in page and "4 forward runs" in page


def test_methods_whose_package_is_missing_say_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    monkeypatch.setitem(sys.modules, "cma", None)
    for method, extra in (("ppo", "rl"), ("sac", "rl"), ("cma", "control"), ("policy", "control")):
        with pytest.raises(MissingExtraError, match=rf"method '{method}' needs .*pip install 'granular-env\[{extra}\]'"):
            run_study(bowl_study({"type": method}), tmp_path / "a", problem=Bowl())
    # Figures are drawn at the end; that they cannot be is said at the beginning.
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(MissingExtraError, match=r"the figures of a study needs the package matplotlib"):
        run_study(bowl_study({"type": "random"}), tmp_path / "a", problem=Bowl())
    assert not (tmp_path / "a").exists()


# -- the command line -----------------------------------------------------------------------------------------------------


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("small.toml").write_text(to_toml(load_study(SMALL).to_dict()))
    return tmp_path


@pytest.mark.figures
def test_the_command_runs_a_study_and_tells_how_it_went(folder, capsys):
    assert main(["study", "small.toml", "--set", "budget=1000"]) == 0
    told = capsys.readouterr().out
    assert "beats nothing" in told and "baselines: nothing 0" in told
    assert "page: studies/small/report.html" in told and Path("studies/small/report.html").is_file()
    assert main(["study", "small.toml", "--set", "budget=1000", "--quiet"]) == 0
    assert capsys.readouterr().out == "studies/small/report.html\n"
    assert main(["study", "small.toml", "--set", "budget=1000", "--set", "seeds=[4]"]) == 2
    assert "pass --overwrite to replace its results" in capsys.readouterr().err


def test_the_command_checks_lists_and_copies_studies(folder, capsys):
    assert main(["check", "small.toml"]) == 0
    told = capsys.readouterr().out
    found = "task protection of 60 control steps, 4 numbers to choose, 3000 control steps for each of random, cma"
    assert told == f"valid: small, {found}\n"
    assert main(["check", "small.toml", "--set", "task.name=protecton"]) == 2
    assert "did you mean 'protection'?" in capsys.readouterr().err
    assert main(["study", "--list"]) == 0
    told = capsys.readouterr().out
    for name in shipped_studies():
        assert name in told
        assert main(["check", name]) == 0
        assert main(["new", name, "-o", f"{name}.toml"]) == 0
        assert load_study(f"{name}.toml").to_dict() == load_study(name).to_dict()
    assert main(["study"]) == 2
    assert main(["study", "no-such-study"]) == 2


def test_check_says_which_methods_are_not_here_and_others_run_without_them(folder, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "cma", None)
    assert main(["check", "small.toml"]) == 0
    told = capsys.readouterr().out
    assert "not here: method 'cma' needs the package cma" in told and "--only METHOD" in told
    assert main(["study", "small.toml", "--quiet"]) == 2
    assert main(["study", "small.toml", "--quiet", "--only", "random"]) == 0
    assert results_of(Path("studies/small"))["trials"][0]["method"] == "random"


def test_starts_lie_about_a_baseline_on_a_few_straight_lines():
    shape = DriveShape(steps=40, entries=1, knots=40, lowest=0.0)
    middle = np.full(40, 0.5)
    search = SimpleNamespace(shape=shape, random=np.random.default_rng)
    gradient = Gradient(begin="theory", spread=0.2, draws=4)
    assert np.array_equal(gradient._start(search, middle, 0), middle)
    start = gradient._start(search, middle, 1)
    assert 0.0 < np.abs(start - middle).max() <= 0.2
    bends = np.abs(np.diff(start, 2)) > 1e-12
    assert bends.sum() <= 4 and not np.array_equal(start, gradient._start(search, middle, 2))


def test_a_search_whose_slopes_are_all_zero_is_reported(tmp_path: Path) -> None:
    class Flat(Bowl):
        def value_and_grad(self, drive: np.ndarray, seeds: list[int]) -> tuple[float, np.ndarray]:
            return -self._value(drive), np.zeros_like(drive)

    study = bowl_study({"type": "gradient", "rounds": 1}, {"type": "random"})
    found = run_study(study, tmp_path / "flat", problem=Flat())
    again = run_study(study, tmp_path / "flat", problem=Flat())
    for result in (found, again):
        assert "note: gradient-1: the slopes of the objective were 0 at every point" in closing(result)
    assert "slopes of the objective" not in closing(run_study(study, tmp_path / "bowl", problem=Bowl()))
