"""Every example runs and ends in the numbers that it is about."""

import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Run an example's `main` in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return lambda name: runpy.run_path(str(EXAMPLES / f"{name}.py"))["main"]()


def test_every_example_is_tested():
    tested = {name.removeprefix("test_") for name in globals() if name.startswith("test_")}
    assert {path.stem for path in EXAMPLES.glob("*.py")} <= tested


def test_piston(run):
    numbers = run("piston")
    # Reference integration: 2.876160. The default integrator at this step is good to a few 1e-5.
    assert numbers["last grain / piston velocity"] == pytest.approx(2.876160, abs=2e-4)
    assert abs(numbers["energy left over / work of the piston"]) < 1e-5
    assert abs(numbers["momentum left over / impulse"]) < 1e-13


def test_record_and_branch(run):
    numbers = run("record_and_branch")
    assert numbers["identical"] and numbers["internal steps compared"] > 0
    assert numbers["bits of the end that the unchanged branch changed"] == 0
    assert 0 < numbers["grains that the other push reached"] < 60


def test_own_component(run):
    numbers = run("own_component")
    assert numbers["identical"]
    # The first bounce, at .45 s, takes 1 - .5^2 of the energy; the second comes at .90 s and takes as much of the rest.
    assert numbers["energy lost / energy at the start"] == pytest.approx(1.0 - 0.5**4, abs=2e-2)
    assert abs(numbers["energy residual"]) < 1e-12


def test_gym_loop(run):
    numbers = run("gym_loop")
    assert numbers["identical"]
    assert numbers["closeness to the wanted 5 m/s"] == pytest.approx(0.98, abs=0.01)
    assert 0.7 < numbers["return"] < numbers["closeness to the wanted 5 m/s"]
