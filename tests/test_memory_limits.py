"""Requests beyond the memory are refused in advance with both sizes; running out of memory later is reported."""

from __future__ import annotations

import tracemalloc

import pytest

from granular_env.cli import main
from granular_env.components import catalogue
from granular_env.components.errors import ExperimentError, LogError, ParameterError
from granular_env.components.support import memory_limits
from granular_env.log_runs import replay
from granular_env.recording.container import Limits
from granular_env.recording.log import check_size
from granular_env.run_loop import run

CHAIN = {
    "name": "long",
    "duration": 1e-4,
    "component": {"type": "chain", "grains": 100_000_000},
    "start": {"velocity": {"0": 1.0}},
}


@pytest.fixture
def small_machine(monkeypatch):
    monkeypatch.setattr(memory_limits, "available_memory", lambda: 8_000_000_000)


def test_a_hundred_million_grains_are_refused_before_they_are_built(small_machine, tmp_path):
    said = r"needs at least 36 GB of memory, but 8 GB are available; reduce the size"
    with pytest.raises(ParameterError, match=f"component 'chain' {said}"):
        catalogue.make("chain", grains=100_000_000)
    with pytest.raises(ExperimentError, match=f"component: .*{said}"):
        run(CHAIN, log=tmp_path / "x.mcap")
    assert [*tmp_path.iterdir()] == []


def test_the_copies_that_a_recorder_holds_are_counted_too(tmp_path, monkeypatch):
    small = {**CHAIN, "component": {"type": "chain", "grains": 1000}}
    monkeypatch.setattr(memory_limits, "available_memory", lambda: 100_000)
    monkeypatch.setattr(catalogue.component_class("chain"), "memory_needed", classmethod(lambda kind, parameters: 0))
    with pytest.raises(ExperimentError, match=r"recording component 'chain' needs at least 0\.000212 GB"):
        run(small, log=tmp_path / "x.mcap")
    assert [*tmp_path.iterdir()] == []


def test_a_log_that_asks_for_more_than_there_is_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "a.mcap"
    run({**CHAIN, "component": {"type": "chain", "grains": 1000}}, log=path)
    monkeypatch.setattr(memory_limits, "available_memory", lambda: 1000)
    with pytest.raises(LogError, match="needs at least .* are available"):
        replay(path, allow_large=True)
    with pytest.raises(LogError, match=r"the requested data needs at least 9 GB"):
        check_size(9_000_000_000, Limits("a.mcap", lifted=True))


@pytest.mark.parametrize(
    "integrator",
    [
        "pefrl",
        "rk4",
    ],
)
def test_a_chain_takes_what_it_was_said_to_take(integrator):
    kind = catalogue.component_class("chain")
    kind(grains=10, integrator=integrator).step()  # compiled
    parameters = kind.Parameters(grains=100_000, integrator=integrator)
    tracemalloc.start()
    try:
        chain = kind(grains=100_000, integrator=integrator)
        chain.step()
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert 0.8 * peak < kind.memory_needed(parameters) < 1.05 * peak


@pytest.mark.parametrize(("fracture", "around"), [("none", 60), ({"name": "principal_stress"}, 62)])
def test_a_shell_takes_what_it_was_said_to_take(fracture, around):
    """Each body has a separate mesh, because bodies with the same mesh share its tables."""
    kind, given = catalogue.component_class("shell"), {"fracture": fracture, "material": "thermoviscoplastic"}
    kind(**given).step()  # compiled
    tracemalloc.start()
    try:
        shell = kind(body={"name": "tube", "along": 61, "around": around}, **given)
        shell.step()
        taken = tracemalloc.get_traced_memory()[0]
    finally:
        tracemalloc.stop()
    assert 0.9 * taken < kind.memory_needed(shell.parameters) < 1.05 * taken


def test_what_the_system_says_is_understood(tmp_path, monkeypatch):
    monkeypatch.setattr(memory_limits, "_MEMINFO", tmp_path / "meminfo")
    monkeypatch.setattr(memory_limits, "_CONTAINER_LIMIT", tmp_path / "max")
    (tmp_path / "meminfo").write_text("MemTotal: 9 kB\nMemAvailable:    2000 kB\n")
    (tmp_path / "max").write_text("max\n")
    assert memory_limits.available_memory() == 2_048_000
    (tmp_path / "max").write_text("1000000\n")
    assert memory_limits.available_memory() == 1_000_000
    (tmp_path / "max").unlink()
    (tmp_path / "meminfo").write_text("nothing of the kind\n")
    assert memory_limits.available_memory() == memory_limits.total_memory()
    monkeypatch.setattr(memory_limits, "total_memory", lambda: None)
    memory_limits.refuse_excess_memory(10**30, "anything")  # the memory is unknown, so nothing is refused


def test_memory_that_runs_out_in_any_command_is_no_traceback(monkeypatch, capsys):
    from granular_env.cli.program import program

    def greedy(**options):
        raise MemoryError

    monkeypatch.setattr(program.commands["list"], "callback", greedy)
    assert main(["list"]) == 2
    assert "not enough memory" in capsys.readouterr().err
