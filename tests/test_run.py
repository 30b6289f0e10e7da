"""The run loop: bits that do not depend on observers, and complete logs for every ending."""

import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

from granular_env.components import catalogue
from granular_env.components.errors import ExperimentError, GranularError, GranularWarning, StepError
from granular_env.components.profiles import Profile
from granular_env.experiments import load_experiment, shipped_experiments
from granular_env.experiments.preparation import prepare_experiment
from granular_env.recording import open_log, verify
from granular_env.run_loop import run

ROOT = Path(__file__).resolve().parents[1]
OSCILLATOR = {
    "name": "swing",
    "duration": 10.0,
    "component": {"type": "oscillator", "stiffness": 4.0},
    "start": {"position": 1.0},
    "input": {"force": {"profile": "triangle", "peak": 1.0, "duration": 0.5}},
    "record": {"every": 0.1, "variables": ["position"]},
}


def state(component) -> bytes:
    return component.save().to_bytes()


# Full-size bodies of the paper, which take half a minute to build.
LARGE = ("gato-shie-2010/notch-1-inch-fine", "gato-shie-2010/notch-1-inch-finest")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] if name in LARGE else []) for name in shipped_experiments()]
)
def test_every_shipped_experiment_has_its_name_and_runs(name, tmp_path):
    experiment = load_experiment(name)
    assert experiment.name == name
    assert len(experiment.description) > 80
    # A fiftieth of the duration, with at least two frames.
    every = experiment.record.every
    assert every is not None
    duration = round(max(experiment.duration / 50, 2 * every) / every) * every
    result = run(name, overrides={"duration": float(f"{duration:.9g}")}, log=tmp_path / "log.mcap")
    assert result.ticks == result.component.duration_ticks(duration)
    assert np.isfinite(result.component.get("kinetic_energy"))
    with open_log(tmp_path / "log.mcap") as log:
        assert log.complete
        entries = {name for balance in log.balances for name in (*balance.entries, balance.residual)}
        inputs = {name for name, one in log.input_variables.items() if one.shape == ()}
        assert entries and set(log.variables) == set(experiment.record.variables or []) | entries | inputs
    assert verify(tmp_path / "log.mcap").identical


def test_a_run_has_the_bits_of_a_script(tmp_path):
    script = catalogue.make("oscillator", stiffness=4.0)
    script.reset(position=1.0)
    script.step(10.0, force=Profile.triangle(1.0, 0.5))
    plain = run(OSCILLATOR)
    watched = run(OSCILLATOR, log=tmp_path / "a.mcap", progress=True, overrides={"record.hash_every": 1, "record.every": 0.01})
    ruled = run(OSCILLATOR, overrides={"stop": [{"variable": "position", "above": 1e9, "every": 0.07}]})
    assert plain.ticks == 1000
    assert state(script) == state(plain.component) == state(watched.component) == state(ruled.component)


def test_a_stop_rule_ends_the_run_at_its_own_instants(tmp_path):
    rule = {"variable": "position", "below": 0.0, "every": 0.05}
    result = run(OSCILLATOR, overrides={"stop": [rule]}, log=tmp_path / "stopped.mcap")
    assert result.stopped_by == "position below 0"
    assert not result.interrupted
    assert result.component.tick % 5 == 0
    assert result.component.get("position") < 0.0
    # The stop rule was not met at the previous check.
    earlier = run({**OSCILLATOR, "duration": result.component.time - 0.05})
    assert earlier.component.get("position") >= 0.0
    with open_log(tmp_path / "stopped.mcap") as log:
        assert log.complete
        assert log.duration == pytest.approx(result.component.time, rel=1e-12)


def test_nothing_is_written_when_the_experiment_is_wrong(tmp_path):
    log = tmp_path / "logs" / "x.mcap"
    for overrides in [
        {"input.forse": 1},
        {"record.variables": ["positon"]},
        {"duration": 0.0123},
        {"start.velocity": "x"},
        {"component.mass": -1},
    ]:
        with pytest.raises(ExperimentError):
            run(OSCILLATOR, log=log, overrides=overrides)
        assert not log.parent.exists()


def test_an_existing_log_is_kept_unless_told(tmp_path):
    log = tmp_path / "x.mcap"
    run(OSCILLATOR, log=log)
    before = log.read_bytes()
    with pytest.raises(GranularError, match="exists"):
        run(OSCILLATOR, log=log)
    assert log.read_bytes() == before
    run(OSCILLATOR, log=log, overwrite=True, overrides={"duration": 20})
    with open_log(log) as opened:
        assert opened.duration == pytest.approx(20.0, rel=1e-12)


def test_the_log_holds_the_experiment_and_can_be_run_from_it(tmp_path):
    first = run(OSCILLATOR, log=tmp_path / "x.mcap")
    with open_log(tmp_path / "x.mcap") as log:
        again = run(log.metadata["experiment"])
    assert state(first.component) == state(again.component)


def test_a_run_that_breaks_down_leaves_a_complete_log(tmp_path):
    broken = {**OSCILLATOR, "component": {"type": "oscillator", "stiffness": 1e9}, "duration": 1e4}
    with pytest.raises(StepError):
        run(broken, log=tmp_path / "x.mcap")
    with open_log(tmp_path / "x.mcap") as log:
        assert log.complete
        assert {incident["incident"] for incident in log.incidents} == {"failed"}
    assert verify(tmp_path / "x.mcap").identical


def test_a_run_that_breaks_down_is_recorded_up_to_its_last_good_tick(tmp_path):
    crushed = {
        "name": "crushed", "duration": 2e-4,
        "component": {
            "type": "grid", "mesh": {"name": "rectangle", "columns": 4, "rows": 4, "cell_size": 1e-3},
            "boundaries": {"bottom": "fixed", "top": "velocity"},
        },
        "input": {"top_velocity": [0.0, -100.0]}, "record": {"every": 1e-6, "variables": ["displacement"]},
    }  # fmt: skip
    with pytest.raises(StepError) as caught:
        run(crushed, log=tmp_path / "x.mcap")
    alone = prepare_experiment(load_experiment(crushed)).component
    with pytest.raises(StepError) as expected:
        alone.step(alone.step_size, top_velocity=[0.0, -100.0])
        while True:
            alone.step(alone.step_size)
    assert str(caught.value) == str(expected.value)
    with open_log(tmp_path / "x.mcap") as log:
        assert log.complete and log.end_tick == alone.tick > 100
        assert log.incidents[-1]["undone_ticks"] == 0
    assert verify(tmp_path / "x.mcap").identical


def test_warnings_are_in_the_result_and_warned_of():
    table = {"profile": "triangle", "peak": 1.0, "duration": 0.505, "start": 0.001}
    with pytest.warns(GranularWarning, match="between ticks"):
        result = run({**OSCILLATOR, "input": {"force": table}})
    assert any("between ticks" in text for text in result.warnings)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert run(OSCILLATOR).warnings == []


def test_an_error_in_the_middle_tells_of_the_log_that_is_left(tmp_path, capsys):
    from granular_env.cli import main

    path, child = tmp_path / "broken.mcap", tmp_path / "child.mcap"
    fatal = 'input.force={ profile = "constant", value = 1e308 }'
    assert main(["run", "oscillator/pushed", "--set", fatal, "--log", str(path)]) == 2
    lines = capsys.readouterr().err.splitlines()
    with open_log(path) as log:
        assert lines[-1] == f"log: {str(path)!r} is complete until {log.end_tick * log.step_size:.9g} s"
    run(OSCILLATOR, log=tmp_path / "whole.mcap")
    assert main(["branch", str(tmp_path / "whole.mcap"), "--at", "0.5", "--set", fatal, "--log", str(child)]) == 2
    assert capsys.readouterr().err.splitlines()[-1].startswith(f"log: {str(child)!r} is complete until ")
    # An existing file is not mistaken for the run's log.
    assert main(["run", "oscillator/pushed", "--log", str(path)]) == 2
    assert "complete until" not in capsys.readouterr().err


# -- Ctrl-C ---------------------------------------------------------------------------------------------------------


def test_an_interrupt_inside_the_loop_gives_a_result(tmp_path):
    class Interrupter:
        next_tick = 400

        def on_reset(self, component): ...

        def on_sample(self, component):
            self.next_tick = 10**9
            signal.raise_signal(signal.SIGINT)

        def on_step(self, component, ticks, inputs): ...

        def on_failure(self, component, error): ...

    handler = signal.getsignal(signal.SIGINT)
    # The duration is so large that the interrupted piece is never the last on any machine.
    result = run(OSCILLATOR, log=tmp_path / "x.mcap", overrides={"duration": 1e5}, observers=[Interrupter()])
    assert signal.getsignal(signal.SIGINT) is handler
    assert result.interrupted
    assert 400 <= result.ticks < 10**7
    with open_log(tmp_path / "x.mcap") as log:
        assert log.complete
        assert log.duration == pytest.approx(result.component.time, rel=1e-12)
    assert verify(tmp_path / "x.mcap").identical


@pytest.mark.parametrize("command", ["run", "branch"])
def test_ctrl_c_on_the_command_line_leaves_a_complete_log(command, tmp_path):
    log, parent = tmp_path / "long.mcap", tmp_path / "parent.mcap"
    arguments = ["oscillator/pushed", "--set", "duration=1e6"]
    if command == "branch":
        run(OSCILLATOR, log=parent)
        arguments = [str(parent), "--at", "0.5", "--until", "1e9"]
    command = [sys.executable, "-m", "granular_env", command, *arguments, "--log", str(log)]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        # The loop is running once the log is longer than its header.
        for _ in range(3000):
            if process.poll() is not None or (log.exists() and log.stat().st_size > 20_000):
                break
            time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        output, errors = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 130, errors
    assert "Traceback" not in errors
    assert "interrupted: the log is complete up to this time" in output
    assert str(log) in output
    assert verify(log).identical
    with open_log(log) as opened:
        assert opened.complete
        assert opened.duration > 0.0
