"""Sweeps: plans, their faults, the table, and the state after tasks, processes or the whole program end."""

import importlib
import math
import multiprocessing
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import granular_env as ge
from granular_env.cli import main
from granular_env.code_hash import code_hash
from granular_env.components.support import jit
from granular_env.domains.chain import measurement
from granular_env.package_contents import shipped_files
from granular_env.sweep import (
    check_sweep,
    load_plan,
    open_sweep,
    parameter_values,
    run_sweep,
    tasks,
)
from granular_env.sweep.ray_cluster import compute_on_node
from granular_env.sweep.store import Store, read_description
from granular_env.sweep.tasks import make_workload
from granular_env.sweep.worker import TaskComputer

ROOT = Path(__file__).resolve().parents[1]
SHIPPED_PLANS = shipped_files("plans of sweeps")
TOO_FAST = 30000.0  # m/s, above the sound speed of steel


def plan(**changes):
    """Return a plan of short chains with two lengths, struck at two speeds."""
    base = {
        "version": 1,
        "name": "short",
        "experiment": "nesterenko-1983/3.1-one-grain",
        "set": {"duration": 4e-5},
        "grid": {"component.grains": [6, 8], "start.velocity.0": [0.5, 1.0]},
        "measure": {"peak": "max velocity[2]", "energy": "final kinetic_energy"},
    }
    return {**base, **changes}


def lines(folder: Path) -> int:
    return len((folder / "results.jsonl").read_bytes().splitlines())


# -- values ---------------------------------------------------------------------------------------------------------


def values(**table):
    return parameter_values.Range(**table).values()


def test_ranges_are_even_and_meet_their_ends():
    assert values(**{"from": 10, "to": 40, "count": 4}) == [10, 20, 30, 40]
    assert all(isinstance(value, int) for value in values(**{"from": 10, "to": 40, "count": 4}))
    assert values(**{"from": 0.1, "to": 0.3, "count": 3}) == [0.1, 0.2, 0.3]
    assert values(**{"from": 3, "to": 102, "count": 100}) == list(range(3, 103))
    assert values(**{"from": 1.0, "to": 100.0, "count": 3, "spacing": "log"}) == [1.0, 10.0, 100.0]
    assert values(**{"from": 2.0, "to": 2.0, "count": 1}) == [2]


@pytest.mark.parametrize(
    "table",
    [
        {"distribution": "uniform", "from": 2.0, "to": 3.0},
        {"distribution": "log_uniform", "from": 2.0, "to": 3.0},
        {"distribution": "integer", "from": 2, "to": 3},
        {"distribution": "choice", "values": [2, 2.5, 3]},
    ],
    ids=lambda table: table["distribution"],
)
def test_a_sample_depends_on_its_number_only(table):
    one = parameter_values.Distribution.model_validate(table)
    few, many = parameter_values.sample_values(one, "a", 5, 20), parameter_values.sample_values(one, "a", 5, 2000)
    assert many[:20] == few
    assert parameter_values.sample_values(one, "b", 5, 20) != few and parameter_values.sample_values(one, "a", 6, 20) != few
    assert all(2 <= value <= 3 for value in many) and len(set(many)) >= 2
    # Within 5 standard deviations of the mean; the coarsest sample, the integer, has 0.5.
    expected = 1.0 / math.log(1.5) if table["distribution"] == "log_uniform" else 2.5
    assert np.mean(many) == pytest.approx(expected, abs=5 * 0.5 / math.sqrt(2000))


# -- plans ----------------------------------------------------------------------------------------------------------

FAULTS = {
    "version": (plan(version=2), r"version: got 2, expected 1"),
    "unknown key": (plan(grids={}), "grids: unknown; did you mean 'grid'"),
    "key of the experiment": (plan(duration=1.0), r"duration: unknown; keys of the experiment belong in \[set\]"),
    "no such measure": (
        plan(measure={"a": "maximum velocity"}),
        "measure.a: got 'maximum velocity', expected a measure such as",
    ),
    "unknown variable": (plan(measure={"a": "max velocty"}), "^plan: measure.a: got 'velocty'.* did you mean 'velocity'"),
    "array": (plan(measure={"a": "final velocity"}), r"6 elements; give an index, such as velocity\[-1\]"),
    "unknown parameter": (plan(set={"component.graisn": 5}), "plan: component.graisn: unknown; did you mean 'grains'"),
    "every": (plan(every=1.7e-9), "every: got 1.7e-09 s, which is .* internal steps"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_of_a_plan_is_named_and_nothing_is_written(name, tmp_path):
    content, message = FAULTS[name]
    with pytest.raises(ge.ExperimentError, match=message):
        run_sweep(content, tmp_path / "out", engine="serial")
    assert not (tmp_path / "out").exists()


def test_a_plan_of_too_many_tasks_is_refused_before_they_are_made_and_computed_on_request(tmp_path, monkeypatch):
    grid = {f"start.velocity.{n}": {"from": 1.0, "to": 2.0, "count": 10**9} for n in range(4)}
    with pytest.raises(ge.ExperimentError, match="at most 100000"):
        run_sweep(plan(grid=grid), tmp_path / "out")
    assert load_plan(plan(grid=grid)).size == 10**36
    monkeypatch.setattr(tasks, "LARGEST", 3)
    with pytest.raises(ge.ExperimentError, match="at most 3"):
        check_sweep(plan())
    assert run_sweep(plan(), tmp_path / "out", engine="serial", allow_large=True).done == 4


def hashes(**changes):
    return [task.hash for task in make_workload(load_plan(plan(**changes))).tasks]


def test_hashes_tell_what_decides_a_result(monkeypatch):
    first = hashes()
    assert len(set(first)) == 4
    assert set(hashes(grid={"component.grains": [6, 8, 10], "start.velocity.0": [0.5, 1.0]})) > set(first)
    assert set(hashes(name="other", description="of the same")) == set(first)
    monkeypatch.setattr(tasks, "code_hash", lambda: "other code")
    assert not set(hashes()) & set(first)


# -- results --------------------------------------------------------------------------------------------------------


def test_the_table_holds_what_runs_come_to(tmp_path):
    measures = {
        "final": "final velocity[-1]",
        "start": "start momentum",
        "peak": "max contact_force",
        "least": "min |velocity|",
        "mean": "mean kinetic_energy",
        "when": "time of max velocity[2]",
        "greatest": "max velocity[2]",
        "pressure": "report peak contact pressure",
        "amplitude": {"measurement": "waves_at", "take": "amplitude", "grain": 2, "above": 0.1},
        "waves": {"measurement": "waves_at", "take": "count", "grain": 2, "above": 0.1},
        "tenth": {"measurement": "waves_at", "take": "speed", "which": 9, "grain": 2, "above": 0.1},
        "front": {"measurement": "front_speed", "above": 0.05, "first": 1, "last": 4},
        "too far": {"measurement": "front_speed", "above": 100.0, "first": 1, "last": 4},
    }
    sweep = run_sweep(plan(measure=measures, every=1e-6), tmp_path / "out", engine="serial")
    table = sweep.table
    assert list(table["component.grains"]) == [6, 6, 8, 8] and list(table["start.velocity.0"]) == [0.5, 1.0, 0.5, 1.0]
    for row in table.itertuples():
        watch = measurement.Watch(every=1e-6)
        overrides = {"duration": 4e-5, "component.grains": row[2], "start.velocity.0": row[3]}
        done = ge.run("nesterenko-1983/3.1-one-grain", overrides=overrides, observers=[watch])
        history = watch.history
        assert row.final == done.component.get("velocity")[-1]
        assert row.start == history.mass[0] * row[3]
        assert row.peak == history.contact_force.max()
        assert row.least == abs(history.velocity).min()
        assert row.mean == pytest.approx(measurement.kinetic_energy(history).mean(), rel=1e-12)
        crest = max(measurement.crests(history.time, history.velocity[:, 2], 0.1), key=lambda one: one.height)
        assert (row.when, row.greatest) == pytest.approx((crest.time, crest.height), rel=1e-12)
        assert row.pressure == done.report["peak contact pressure [Pa]"]
        waves = measurement.waves_at(history, 2, 0.1)
        assert (row.amplitude, row.waves) == (waves[0].amplitude, len(waves))
        assert row.front == measurement.front_speed(history, 0.05, 1, 4)
        assert math.isnan(row.tenth) and "too far: " in row.notes
    assert repr(sweep) == "<Sweep 'short': 4 tasks, 4 done, 0 failed, 0 pending>"
    assert np.isnan(table["too far"]).all() and (table["outcome"] == "done").all()


def test_the_time_of_a_crest_of_a_force_is_known_between_the_looks(tmp_path):
    kind, name = "min", "right_wall_force"  # negative in compression
    chain = {"component.grains": 14, "component.right": "plane", "component.step_size": 2e-8}
    experiment = {"duration": 2e-4, "start.velocity.0": 1.0, **chain}
    content = {
        "version": 1,
        "experiment": "nesterenko-1983/3.1-one-grain",
        "set": experiment,
        "grid": {"component.radius": [2.4e-3, 3e-3, 3.6e-3]},
        "measure": {"when": f"time of {kind} {name}", "height": f"{kind} {name}"},
    }
    coarse = run_sweep({**content, "name": "coarse", "every": 1e-6}, tmp_path / "coarse", engine="serial").columns()
    fine = run_sweep({**content, "name": "fine", "every": 2e-8}, tmp_path / "fine", engine="serial").columns()
    # Sampling only every microsecond would be wrong by up to 5e-7 s.
    assert coarse["when"] == pytest.approx(fine["when"], abs=1e-8)
    assert coarse["height"] == pytest.approx(fine["height"], rel=1e-4)
    assert not any("crest" in (note or "") for note in coarse["notes"])


def test_columns_have_units(tmp_path):
    measures = {
        "peak": "max velocity[2]",
        "when": "time of max velocity[2]",
        "pressure": "report peak contact pressure",
        "part": "report contact radius",
        "wave": {"measurement": "waves_at", "take": "width", "grain": 2, "above": 0.1},
        "ratio": {"measurement": "pressure_ratio", "take": "ratio", "grain": 3},
    }
    content = plan(measure=measures, grid={"component.radius": [3e-3], "start.velocity.0": [1.0], "duration": [4e-5]}, set={})
    sweep = run_sweep(content, tmp_path / "out", engine="serial")
    expected = {"component.radius": "m", "start.velocity.0": "m/s", "duration": "s", "peak": "m/s", "when": "s"}
    expected |= {"pressure": "Pa", "part": "1", "wave": "m", "ratio": "1"}
    assert open_sweep(tmp_path / "out").units == expected
    heading, row = (tmp_path / "out" / "table.csv").read_text().splitlines()
    assert heading.startswith(
        "task,component.radius [m],start.velocity.0 [m/s],duration [s],peak [m/s],when [s],pressure [Pa],part,"
    )
    assert float(row.split(",")[4]) == sweep.columns()["peak"][0]


def test_equal_tasks_are_computed_once_and_a_plan_that_grows_keeps_what_holds(tmp_path):
    out = tmp_path / "out"
    grid = {"component.grains": [6, 8, 6], "start.velocity.0": [0.5]}
    sweep = run_sweep(plan(grid=grid), out, engine="serial")
    assert (sweep.size, lines(out)) == (3, 2)
    before = (out / "table.csv").read_bytes()
    run_sweep(plan(grid=grid), out, engine="serial")
    assert lines(out) == 2 and (out / "table.csv").read_bytes() == before
    sweep = run_sweep(plan(), out, engine="serial")
    assert lines(out) == 4 and sweep.done == 4
    assert (out / "table.csv").read_bytes() == run_sweep(plan(), tmp_path / "b", engine="serial").write_csv().read_bytes()
    # A different name or description of the experiment does not make a new result; a different measure does.
    run_sweep(plan(measure={"energy": "final kinetic_energy"}), out, engine="serial")
    assert lines(out) == 8


def test_a_task_that_fails_is_a_row(tmp_path):
    content = plan(grid={"start.velocity.0": [0.5, TOO_FAST, 1000.0, 1.0]}, log_every=2)
    sweep = run_sweep(content, tmp_path / "out", engine="serial")
    table = sweep.table
    assert list(table["outcome"]) == ["done", "failed", "failed", "done"]
    assert table["error"][1].startswith("ExperimentError: ") and "start" in table["error"][1]
    assert table["error"][2].startswith("StepError: ")
    assert np.isnan(table["peak"][1:3]).all() and not np.isnan(table["peak"][[0, 3]]).any()
    # The recordable part of the failed task was logged.
    assert list(table["log"].notna()) == [True, False, True, False]
    with ge.open_log(sweep.log(2)) as log:
        assert log.end_tick >= 0
    assert list(sweep.errors) == [1, 2]


MACHINE = [MemoryError(), ge.LogError("the log cannot be written")]
MACHINE[1].__cause__ = OSError(28, "No space left on device")


@pytest.mark.parametrize("error", MACHINE, ids=["memory", "disk of the log"])
def test_failures_of_the_machine_are_tried_again(error, tmp_path, monkeypatch):
    run_task = TaskComputer._run_task

    def fail_once(self, task):
        if ("start.velocity.0", 1.0) in task.overrides:
            raise error
        return run_task(self, task)

    content = plan(grid={"start.velocity.0": [0.5, 1.0]})
    monkeypatch.setattr(TaskComputer, "_run_task", fail_once)
    sweep = run_sweep(content, tmp_path / "out", engine="serial")
    assert (sweep.done, sweep.failed) == (1, 1) and type(error).__name__ in sweep.errors[1]
    monkeypatch.undo()
    assert run_sweep(content, tmp_path / "out", engine="serial").done == 2


# -- components of other packages -------------------------------------------------------------------------------------

BALLS = {
    "version": 1,
    "name": "balls",
    "experiment": "ball.toml",
    "grid": {"component.restitution": [0.65, 0.5, 0.8]},
    "measure": {"low": "min velocity"},
}


@pytest.fixture
def ball(tmp_path, monkeypatch):
    """Create a package with the component of the example; return its file."""
    package, about = tmp_path / "site" / "ball_of_another_package", tmp_path / "site" / "ball-1.dist-info"
    for folder in (package, about):
        folder.mkdir(parents=True)
    shutil.copy(ROOT / "examples" / "own_component.py", package / "__init__.py")
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: ball\nVersion: 1\n")
    (about / "entry_points.txt").write_text("[granular_env.components]\nball = ball_of_another_package:Ball\n")
    (tmp_path / "ball.toml").write_text(
        "name = 'ball'\nduration = 1.0\n[component]\ntype = 'ball'\n[start]\nheight = 1.0\n[record]\nevery = 0.1\n"
    )
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path / "site")
    forget_code()
    yield package / "__init__.py"
    monkeypatch.undo()
    forget_code()


def forget_code():
    """Unload the package, as in a new process."""
    sys.modules.pop("ball_of_another_package", None)
    importlib.invalidate_caches()
    for cached in (jit._hashed_package_names, code_hash):
        cached.cache_clear()


def test_results_of_an_edited_package_are_computed_again(ball, tmp_path):
    assert [low < -3.0 for low in run_sweep(BALLS, "out", engine="serial").columns()["low"]] == [True] * 3
    # The text has another length, because Python treats files with equal time (in seconds) and size as equal.
    ball.write_text(ball.read_text().replace("GRAVITY = 9.81", "GRAVITY = 1.620"))
    # This process has the old code and a new process the edited code; their results must not be in one table.
    with pytest.raises(ge.SweepError, match="a different version of granular-env, of a plug-in"):
        run_sweep(BALLS, "other", workers=1)
    workload = make_workload(load_plan(BALLS))
    forget_code()
    with pytest.raises(ge.SweepError, match="a different version of granular-env, of a plug-in"):
        compute_on_node(workload.job, workload.tasks[0])
    forget_code()
    assert [low > -2.0 for low in run_sweep(BALLS, "out", engine="serial").columns()["low"]] == [True] * 3
    assert lines(tmp_path / "out") == 6


def test_errors_of_another_package_are_rows_of_the_table_in_every_engine(ball):
    """Including errors of the first task, which compiles the kernels, and errors while a log is recorded."""
    ball.write_text(ball.read_text().replace("height, velocity, h = ", "height, velocity, h = 1 // 0, "))
    content = {**BALLS, "log_every": 2}
    errors = [run_sweep(content, engine, engine=engine).errors for engine in ("serial", "processes")]
    assert errors[0] == errors[1] == dict.fromkeys(range(3), "ZeroDivisionError: integer division or modulo by zero")
    forget_code()
    workload = make_workload(load_plan(BALLS))
    assert compute_on_node(workload.job, workload.tasks[0])[0].outcome == "failed"


@pytest.mark.parametrize(
    ("fault", "limit", "error"),
    [
        ("while True:\n                pass", 2.0, "took longer than the time limit of 2 s"),
        (
            "import os\n            os._exit(9)",
            None,
            "its process or node ended 3 times: the process ended (killed, out of memory, or a crash of compiled code)",
        ),
    ],
    ids=["hangs", "ends its process"],
)
def test_a_task_that_costs_its_process_is_named_and_the_rest_goes_on(fault, limit, error, ball, tmp_path):
    """The first task, which compiles the kernels for the others."""
    text, head = ball.read_text(), "def _advance_state(self, ticks: int) -> int:\n        "
    assert head in text
    ball.write_text(text.replace(head, f"{head}if self.parameters.restitution == 0.65:\n            {fault}\n        "))
    sweep = run_sweep(BALLS, "out", workers=1, time_limit=limit)
    assert sweep.outcomes == ["failed", "done", "done"] and sweep.errors[0].startswith(error)
    # The next sweep retries the task.
    ball.write_text(text)
    forget_code()
    assert run_sweep(BALLS, "out", engine="serial").done == 3


def test_logs_replay(tmp_path):
    sweep = run_sweep(plan(log_every=2), tmp_path / "out", engine="serial")
    assert list(sweep.table["log"].notna()) == [True, False, True, False]
    assert ge.verify(sweep.log(2)).identical
    # More logs are requested now: only tasks without a log run again.
    more = run_sweep(plan(log_every=1), tmp_path / "out", engine="serial")
    assert more.table["log"].notna().all() and lines(tmp_path / "out") == 6


def test_a_measured_input_goes_with_the_tasks_by_its_content(tmp_path):
    (tmp_path / "blow.csv").write_text("time [us],force [kN]\n0,0\n10,0.8\n20,0\n")
    (tmp_path / "blow.toml").write_text(
        "name = 'blow'\nduration = 1e-4\n[component]\ntype = 'chain'\ngrains = 8\nmaterial = 'steel'\n"
        "[input.left_force]\nprofile = 'csv'\npath = 'blow.csv'\ntime_column = 'time'\nvalue_column = 'force'\n"
    )
    content = {
        "version": 1, "name": "blow", "experiment": str(tmp_path / "blow.toml"),
        "grid": {"input.left_force.scale": [0.5, 1.0]}, "measure": {"work": "final input_work"},
    }  # fmt: skip
    out = tmp_path / "out"
    first = run_sweep(content, out, engine="serial").table["work"]
    direct = ge.run(tmp_path / "blow.toml").component.get("input_work")
    assert first[1] == direct and 0.0 < first[0] < direct
    (tmp_path / "blow.csv").write_text("time [us],force [kN]\n0,0\n10,0.9\n20,0\n")
    again = run_sweep(content, out, engine="serial").table["work"]
    assert lines(out) == 4 and again[1] > first[1]
    assert len(list((out / "inputs").iterdir())) == 2


# Nine tearing tubes take minutes.
LONG_PLANS = {"notches-and-pressures"}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] if name in LONG_PLANS else []) for name in SHIPPED_PLANS],
)
def test_shipped_plans_are_computed(name, tmp_path):
    sweep = run_sweep(name, tmp_path / "out", engine="serial")
    assert sweep.done == sweep.size
    table = sweep.table
    if name == "solitary-wave-speed":
        # Without precompression V scales as v^(1/5), and the amplitude is proportional to the striker's speed.
        slope = np.polyfit(np.log(table["amplitude"]), np.log(table["speed"]), 1)[0]
        assert slope == pytest.approx(0.2, abs=2e-4)
        np.testing.assert_allclose(table["amplitude"] / table["start.velocity.0"], 0.6816, atol=5e-4)
    if name == "discs-breaking":
        # The springs are linear, so twice the force at twice the breaking strain is the same run with twice the velocities.
        rows = table.set_index(["component.breaking_strain", "input.force.peak"])
        for force in (0.5, 1.0, 1.5):
            once, twice = rows.loc[(0.01, force)], rows.loc[(0.02, 2.0 * force)]
            assert (twice["broken"], twice["middle"]) == (once["broken"], once["middle"])
            assert twice["fastest"] == pytest.approx(2.0 * once["fastest"], rel=1e-9)
            assert twice["torn"] == pytest.approx(4.0 * once["torn"], rel=1e-9)
        assert rows.loc[(0.01, 1.5), "broken"] == 1.0 and rows.loc[(0.01, 1.5), "middle"] == 0.0
    if name == "notches-and-pressures":
        # With a higher filling pressure, the tube tears earlier and farther, for every notch.
        for _, rows in table.groupby("component.shell.body.notch.length"):
            assert rows.sort_values("component.gas.initial_pressure")["crack"].is_monotonic_increasing
            assert rows.sort_values("component.gas.initial_pressure")["torn_at"].is_monotonic_decreasing


# -- engines --------------------------------------------------------------------------------------------------------


def test_processes_give_the_bits_of_one_process(tmp_path):
    content = plan(grid={"start.velocity.0": [0.5, TOO_FAST, 1.0], "component.grains": {"from": 3, "to": 12, "count": 10}})
    one = run_sweep(content, tmp_path / "one", engine="serial")
    run_sweep(content, tmp_path / "many", workers=3)
    assert (one.done, one.failed) == (20, 10)
    assert (tmp_path / "one" / "table.csv").read_bytes() == (tmp_path / "many" / "table.csv").read_bytes()
    assert multiprocessing.active_children() == []


def long_plan(count: int = 120):
    return plan(
        grid={"start.velocity.0": {"from": 0.5, "to": 1.0, "count": count}, "component.grains": [60]}, set={"duration": 2e-4}
    )


def test_a_process_that_is_killed_costs_only_its_running_tasks(tmp_path, monkeypatch):
    keep, killed = Store.add_result, []

    def kill_one(self, results):
        keep(self, results)
        others = [child.pid for child in multiprocessing.active_children() if child.pid not in killed]
        if len(killed) < 2 and others:
            killed.append(others[0])
            os.kill(others[0], signal.SIGKILL)

    monkeypatch.setattr(Store, "add_result", kill_one)
    sweep = run_sweep(long_plan(), tmp_path / "many", workers=2)
    assert len(killed) == 2 and sweep.done == 120
    monkeypatch.undo()
    run_sweep(long_plan(), tmp_path / "one", engine="serial")
    assert (tmp_path / "one" / "table.csv").read_bytes() == (tmp_path / "many" / "table.csv").read_bytes()


def test_a_script_is_not_run_again_by_the_processes(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import granular_env as ge\nprint('begin')\n"
        f"sweep = ge.run_sweep({plan()!r}, {str(tmp_path / 'out')!r}, workers=2)\nprint('end', sweep.done)\n"
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=300)
    assert (done.stdout, done.returncode) == ("begin\nend 4\n", 0), done.stderr


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"engine": "proceses"}, "did you mean 'processes'"),
        ({"engine": "serial", "time_limit": 2.0}, "time_limit: the engine 'serial' does not support this option"),
        ({"workers": 0}, "workers: got 0"),
        ({"part": "3/3"}, "part: got '3/3', expected I/N with 0 <= I < N"),
    ],
)
def test_wrong_options_are_named_and_nothing_is_written(options, message, tmp_path):
    with pytest.raises(ge.GranularError, match=message):
        run_sweep(**{"plan": plan(), "folder": tmp_path / "out", **options})
    assert not (tmp_path / "out").exists()


# -- parts ----------------------------------------------------------------------------------------------------------


def test_the_table_of_all_parts_is_that_of_the_whole_plan(tmp_path):
    grid = {"component.grains": [6, 8, 6], "start.velocity.0": [0.5, 1.0, TOO_FAST]}  # six distinct tasks
    whole = run_sweep(plan(grid=grid), tmp_path / "whole", engine="serial")
    for index in range(4):
        part = run_sweep(plan(grid=grid), tmp_path / "parts", engine="serial", part=f"{index}/4")
    assert part.done == whole.done == 6 and not (tmp_path / "parts" / "table.csv").exists()
    assert sum(len(path.read_bytes().splitlines()) for path in (tmp_path / "parts").glob("results-*.jsonl")) == 6
    open_sweep(tmp_path / "parts").write_csv()
    assert (tmp_path / "parts" / "table.csv").read_bytes() == (tmp_path / "whole" / "table.csv").read_bytes()


# -- stored results -------------------------------------------------------------------------------------------------


def test_a_line_that_was_cut_off_is_computed_again(tmp_path):
    out = tmp_path / "out"
    run_sweep(plan(), out, engine="serial")
    before, journal = (out / "table.csv").read_bytes(), out / "results.jsonl"
    whole = journal.read_bytes()
    for size, done in ((len(whole) - 1, 4), (len(whole) - 30, 3), (5, 0)):
        journal.write_bytes(whole[:size])
        assert open_sweep(out).done == done
        run_sweep(plan(), out, engine="serial")
        assert (out / "table.csv").read_bytes() == before and open_sweep(out).done == 4


def test_folders_that_are_not_this_sweeps(tmp_path):
    run_sweep(plan(), tmp_path / "mine", engine="serial")
    with pytest.raises(ge.SweepError, match="results of the plan 'short', not of 'other'"):
        run_sweep(plan(name="other"), tmp_path / "mine")
    about = tmp_path / "mine" / "sweep.json"
    store = Store(tmp_path / "mine", read_description(tmp_path / "mine"))
    with store, pytest.raises(ge.SweepError, match="another process is computing this sweep"):
        run_sweep(plan(), tmp_path / "mine")
    about.write_text("{")
    for call in (lambda: run_sweep(plan(), tmp_path / "mine"), lambda: open_sweep(tmp_path / "mine")):
        with pytest.raises(ge.SweepError, match="Invalid"):
            call()
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.tex").write_text("")
    with pytest.raises(ge.SweepError, match="is not empty and contains no sweep"):
        run_sweep(plan(), tmp_path / "full")
    for nothing in (tmp_path, tmp_path / "none"):
        with pytest.raises(ge.SweepError):
            open_sweep(nothing)


# -- the command ----------------------------------------------------------------------------------------------------

LONG = """
version = 1
name = "long"
experiment = "nesterenko-1983/3.1-one-grain"
[grid]
"start.velocity.0" = { from = 0.5, to = 1.0, count = 2000 }
[measure]
peak = "max velocity[40]"
"""


def called(folder: Path, *arguments: str) -> subprocess.Popen:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "granular_env", "sweep", *arguments]
    return subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def first_results(folder: Path, program: subprocess.Popen) -> None:
    """Wait until the program has stored a result."""
    path = folder / "sweeps" / "long" / "results.jsonl"
    while not (path.exists() and path.stat().st_size):
        assert program.poll() is None, program.communicate()
        time.sleep(0.05)


def alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def children(pid: int) -> list[int]:
    return [int(one) for one in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def all_gone(pids: list[int], seconds: float = 30.0) -> bool:
    """Return whether all processes end in time; multiprocessing's resource tracker outlives its program briefly."""
    limit = time.monotonic() + seconds
    while any(alive(pid) for pid in pids) and time.monotonic() < limit:
        time.sleep(0.05)
    return not any(alive(pid) for pid in pids)


def test_the_command_ends_by_telling_where_the_table_is(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("plan.toml").write_text(LONG.replace("2000", "2").replace("long", "tiny"))
    assert main(["sweep", "plan.toml", "--engine", "serial", "--set", "duration=1e-4"]) == 0
    told = capsys.readouterr().out
    assert (
        told.startswith("2 tasks: 2 done, 0 failed\n")
        and re.search(r"^task +start.velocity.0 \[m/s\] +peak \[m/s\]\n0 +0.5 +\S+\n1 +1 +\S+$", told, re.MULTILINE)
        and "\ntable: sweeps/tiny/table.csv\n" in told
        and "ge.open_sweep('sweeps/tiny')" in told
    )
    assert main(["sweep", "plan.toml", "--engine", "serial", "--set", "duration=1e-4", "--quiet"]) == 0
    assert capsys.readouterr().out == "sweeps/tiny/table.csv\n"
    assert main(["sweep", "plan.toml", "--engine", "serial", "--set", "duration=1e-4", "--set", "start.velocity.3=1e5"]) == 2
    Path("plan.toml").write_text(LONG.replace("2000", "3").replace("long", "tiny").replace("to = 1.0", "to = 20000.0"))
    assert main(["sweep", "plan.toml", "--engine", "serial", "--set", "duration=1e-4"]) == 1
    assert "failed: task 2: ExperimentError: " in capsys.readouterr().out
    assert main(["sweep", "tapered-chain"]) == 2
    assert "did you mean 'tapered-chains'" in capsys.readouterr().err
    assert main(["describe", "tapered-chains"]) == 0
    assert "[measure]" in capsys.readouterr().out


def test_the_command_checks_and_copies_plans(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name in SHIPPED_PLANS:
        assert main(["new", name, "-o", f"{name}.toml"]) == 0
        assert f"run it with: granular-env sweep {name}.toml" in capsys.readouterr().out
        for source in (name, f"{name}.toml"):
            assert main(["check", source]) == 0
            told = capsys.readouterr().out
            assert told.startswith(f"valid: {name}, {load_plan(name).size} tasks of the experiment ")
    assert main(["check", "tapered-chains.toml", "--set", "component.grain=3"]) == 2
    assert "did you mean 'grains'?" in capsys.readouterr().err
    assert not Path("sweeps").exists()


def test_the_command_computes_parts_and_merges_them(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("plan.toml").write_text(LONG.replace("2000", "3").replace("long", "tiny"))
    command = ["sweep", "plan.toml", "--engine", "serial", "--set", "duration=1e-4"]
    assert main([*command, "--part", "2/2"]) == 2 and "expected I/N with 0 <= I < N" in capsys.readouterr().err
    assert [main([*command, "--part", part]) for part in ("0/2", "1/2")] == [0, 0]
    assert "run the command with --merge to write the table" in capsys.readouterr().out
    assert main([*command, "--merge"]) == 0
    assert "3 tasks: 3 done, 0 failed" in capsys.readouterr().out and Path("sweeps/tiny/table.csv").exists()


def test_ctrl_c_ends_the_command_with_what_is_done(tmp_path):
    (tmp_path / "plan.toml").write_text(LONG)
    program = called(tmp_path, "plan.toml", "--workers", "2")
    first_results(tmp_path, program)
    workers = children(program.pid)
    program.send_signal(signal.SIGINT)
    told, errors = program.communicate(timeout=60)
    assert program.returncode == 130, errors
    assert "interrupted: finished results are kept" in told and "pending" in told
    assert "Traceback" not in errors
    assert all_gone(workers)
    assert 0 < open_sweep(tmp_path / "sweeps" / "long").done < 2000
