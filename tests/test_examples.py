"""Every example runs and gives its expected numbers."""

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
    # Reference integration: 2.876160. The default integrator at this step is accurate to a few 1e-5.
    assert numbers["last grain / piston velocity"] == pytest.approx(2.876160, abs=2e-4)
    assert abs(numbers["energy residual / work of the piston"]) < 1e-5
    assert abs(numbers["momentum residual / impulse"]) < 1e-13


def test_record_and_branch(run):
    numbers = run("record_and_branch")
    assert numbers["identical"] and numbers["internal steps compared"] > 0
    assert numbers["bits of the final state changed by the unchanged branch"] == 0
    assert 0 < numbers["grains reached by the other push"] < 60


def test_own_component(run):
    numbers = run("own_component")
    assert numbers["identical"]
    # The first bounce, at 0.45 s, dissipates 1 - 0.5^2 of the energy; the second, at 0.90 s, the same fraction of the rest.
    assert numbers["energy lost / energy at the start"] == pytest.approx(1.0 - 0.5**4, abs=2e-2)
    assert abs(numbers["energy residual"]) < 1e-12


def test_gym_loop(run):
    numbers = run("gym_loop")
    assert numbers["identical"]
    assert numbers["closeness to the target of 5 m/s"] == pytest.approx(0.98, abs=0.01)
    assert 0.7 < numbers["return"] < numbers["closeness to the target of 5 m/s"]


def test_absorbing_end(run):
    numbers = run("absorbing_end")
    assert numbers["wall"] == pytest.approx(1.0, abs=0.01)
    # An endless chain reflects nothing; the error is due to inputs held for 2 us.
    assert 0.0 < numbers["matched piston"] < 5e-4 and abs(numbers["matched force"]) < 2e-4
    assert numbers["matched piston"] < 0.2 * numbers["best linear dashpot"] < numbers["free end, last grain caught"]


@pytest.mark.slow
def test_pulse_shaping(run):
    numbers = run("pulse_shaping")
    assert abs(numbers["shaped: amplitude at grain 60, relative error"]) < 1e-3
    assert numbers["shaped: energy outside the wave / input"] < 1e-5
    assert numbers["shaped: peak force [N]"] < 0.7 * numbers["triangle: peak force [N]"]
    for name in ("radii +-5 %", "viscous, 2 N s/m"):
        assert numbers[f"{name}: distance"] < 0.5 * numbers[f"{name}: with the uniform chain's drive"]
    assert abs(numbers["first wave, relative error"]) < 1e-3 and abs(numbers["second wave, relative error"]) < 1e-3
    assert abs(numbers["delay, relative error"]) < 1e-3 and numbers["energy outside the waves / input"] < 1e-5


def test_lamb_problem(run):
    numbers = run("lamb_problem")
    assert numbers["Rayleigh speed / S speed"] == pytest.approx(0.9194, abs=1e-4)
    # 18 cells per load length, second-order: 3.2 % and 1.5 % at 20; the sides reflect slightly.
    assert numbers["misfit at x = 0.2 m, depth 0.01 m"] < 0.05
    assert numbers["misfit at x = 0.12 m, depth 0.12 m"] < 0.025
    assert 0.3 < numbers["peak behind a hole / without it"] < 0.9


@pytest.mark.extra
def test_the_notebook_shows_figures_and_tables(tmp_path):
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    notebook = nbformat.read(EXAMPLES / "figures.ipynb", as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells)
    nbclient.NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(tmp_path)}}).execute()
    shown = [output["data"] for cell in notebook.cells for output in cell.get("outputs", []) if "data" in output]
    assert [("image/png" in data, "text/html" in data) for data in shown] == [(False, True)] + [(True, False)] * 6
