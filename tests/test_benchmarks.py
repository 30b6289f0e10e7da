"""Each benchmark runs on a tiny problem. The tests check the compared computations, not the measured speeds."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).resolve().parent.parent))

from benchmarks import __main__ as program  # noqa: E402
from benchmarks import (  # noqa: E402
    automata,
    calls,
    chains,
    compilation,
    coupled,
    detonation,
    environments,
    gradient,
    grid,
    kernel,
    lammps_solid_peer,
    laws,
    numpy_peer,
    pyro_peer,
    recording,
    replay,
    scipy_peer,
    shell,
    sweeps,
)
from granular_env.components.chain.laws import LAWS  # noqa: E402

SMALL = {
    "kernel": (lambda: kernel.measure(sizes=(30,), rounds=2), 2),
    "laws": (lambda: laws.measure(grains=30, rounds=2), 6),
    "numpy": (lambda: numpy_peer.measure(grains=30, ticks=5, rounds=2), 1),
    "scipy": (lambda: scipy_peer.measure(grains=20, tolerances=4, rounds=2), 1),
    "calls": (lambda: calls.measure(calls=5, rounds=2), 7),
    "compilation": (lambda: compilation.measure(repeats=1), 10),
    "gradient": (lambda: gradient.measure(steps=40, rounds=2, chains=("PEFRL, pressed", "PEFRL, viscous")), 3),
    "grid": (lambda: grid.measure(sides=(6, 9), triad_words=1000, rounds=2, smallest=6), 4),
    "automata": (lambda: automata.measure(side=8, triad_words=1000, rounds=2, cracking=2.3e-4), 5),
    "coupled": (lambda: coupled.measure(side=6, rounds=2), 2),
    "detonation": (lambda: detonation.measure(cells=60, triad_words=1000, rounds=2), 2),
    "shell": (lambda: shell.measure(along=26, around=40, triad_words=1000, rounds=2), 10),
    "environments": (lambda: environments.measure(steps=2, rounds=2), 4),
    "recording": (lambda: recording.measure(steps=20, rounds=2, long_grains=50, long_steps=200, long_rounds=2), 3),
    "replay": (lambda: replay.measure(grains=40, steps=20, rounds=2), 2),
    "sweeps": (lambda: sweeps.measure(tasks=3, task_seconds=0.001, rounds=1, least_tasks=3, uncounted=0), 2),
}


# Other benchmarks compile kernels that few tests need, or start many processes.
QUICK = {"calls", "numpy", "recording", "replay"}


@pytest.mark.parametrize("name", [one if one in QUICK else pytest.param(one, marks=pytest.mark.slow) for one in SMALL])
def test_a_benchmark_gives_its_figures(name):
    measure, count = SMALL[name]
    figures = list(measure())
    assert len(figures) == count
    assert all(np.isfinite(figure.value) for figure in figures)


def test_the_chain_in_numpy_is_the_chain():
    chain = chains.struck_chain(30)
    u, v = chain.get("displacement"), chain.get("velocity")
    numpy_peer.pefrl(u, v, chains.STIFFNESS, chains.MASS, chain.step_size, 100)
    chain.step(100 * chain.step_size)
    np.testing.assert_allclose(v, chain.get("velocity"), rtol=0, atol=1e-12 * chains.SPEED)


@pytest.mark.slow  # it compiles all laws
def test_every_law_is_timed_while_all_its_contacts_are_closed():
    assert {"hertz", *laws.LAWS} == set(LAWS)
    for parameters in laws.LAWS.values():
        chain = chains.precompressed_chain(50, **parameters)
        chain.step(500 * chain.step_size)
        assert chain.get("overlap")[chain.geometry.contact_slice].min() > 0.0


@pytest.mark.slow
def test_our_side_of_the_rod_beside_lammps_swings_as_theory_says():
    """The ends of a free bar come to rest after half of the sound's travel time through the bar."""
    rod = lammps_solid_peer.swinging_rod(13, 3)
    rest = lammps_solid_peer.zero_crossing(
        lambda: rod.step(rod.step_size), lambda: rod.get("nodal_velocity")[:, 0], rod.step_size
    )
    assert rest == pytest.approx(0.5 * 0.012 * (2719.0 / 69e9) ** 0.5, rel=0.02)


def test_our_side_of_the_gas_beside_pyro_solves_sods_problem(monkeypatch):
    tube, start = pyro_peer.sod_tube(100)
    tube.step(0.2)
    assert pyro_peer.density_error(tube.centres, tube.get("density"), tube.time) < 6e-3
    tube.restore(start)
    assert tube.tick == 0
    monkeypatch.setitem(sys.modules, "pyro", None)
    with pytest.raises(SystemExit, match="make bench-peers"):
        next(pyro_peer.measure(cells=10, rows=2, rounds=1))


def test_peers_that_are_not_installed_are_skipped_by_name(monkeypatch, capsys):
    for module in ("lammps", "pyro"):
        monkeypatch.setitem(sys.modules, module, None)
    assert program.main(["--peers", "--strict"]) == 0
    assert "lammps-bonds: skipped: LAMMPS cannot be used" in capsys.readouterr().err
