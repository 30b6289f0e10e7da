"""LAMMPS's bonded particles (package BPM) compared with linked automata: the same hexagonal packing, one core.

The two models differ and do not produce the same motion. A bond of `bpm/rotational` stretches, shears, bends and twists in
space, with quaternions, and breaks by its own forces. A pair of automata lies in a plane and depends on the volumes around both
automata, so that any Poisson ratio is met exactly. The benchmark compares the cost per step.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

import granular_env as ge

from .figures import Figure
from .grid import MEDIUM
from .lammps_peer import load_library
from .timing import median_ratio, time_interleaved

_NEVER = {"name": "strain", "tensile": 1e3, "shear": 1e3}


def measure(side: int = 100, ticks: int = 100, rounds: int = 9) -> Iterator[Figure]:
    """Compare about side x side linked particles with small motion; no pair breaks.

    Raises:
        SystemExit: LAMMPS is not installed, cannot find MPI, or lacks the package BPM.
    """
    linked, breakable = _specimen(side), _specimen(side, criterion=_NEVER)
    peer = _Bonds(linked)
    wanted = len(linked.get("linked"))
    yield Figure("LAMMPS's bonds minus our pairs", float(peer.count() - wanted), "", at_most=0.0, note=f"{wanted} pairs")
    runs = {
        "lammps": lambda: peer.run(ticks),
        "linked": lambda: linked._advance_state(ticks),
        "breakable": lambda: breakable._advance_state(ticks),
    }
    times = time_interleaved(runs, rounds)
    left = peer.count()
    peer.close()
    yield Figure("change of the number of LAMMPS's bonds in the runs", float(abs(left - wanted)), "", at_most=0.0)
    cost = {name: float(np.median(found)) / (ticks * linked.count) * 1e9 for name, found in times.items()}
    for name, what in (("linked", "automata that cannot break"), ("breakable", "automata that can break")):
        note = f"{cost['lammps']:.3g} ns per particle step (in space) against {cost[name]:.3g} ns (in a plane)"
        yield Figure(
            f"LAMMPS's bonds / {what}, per step, N = {linked.count}", median_ratio(times["lammps"], times[name]), note=note
        )


def _specimen(side: int, **breaking: Any) -> Any:
    shape = {"name": "rectangle", "width": float(side), "height": side * 0.5 * 3.0**0.5}
    automata = ge.make("automata", shape=shape, diameter=1.0, packing="hexagonal", material=MEDIUM, **breaking)
    automata.reset(velocity=1e-6 * np.random.default_rng(1).standard_normal((automata.count, 2)))
    return automata


class _Bonds:
    """Bonded discs at the positions of a specimen, with the same start velocities and internal step."""

    def __init__(self, specimen: Any) -> None:
        self._lammps = load_library()
        if "BPM" not in self._lammps.installed_packages:
            raise SystemExit("this LAMMPS has no package BPM: run `make bench-peers`, which installs one that has it")
        places, count = np.zeros((specimen.count, 3)), specimen.count
        places[:, :2] = specimen.packing.reference
        low, high = places.min(axis=0) - 5.0, places.max(axis=0) + 5.0
        density = specimen.parameters.material.density
        self._lammps.commands_string(f"""
            units si
            dimension 2
            atom_style bpm/sphere
            atom_modify map array sort 0 0.0
            boundary f f p
            newton on off
            comm_modify vel yes cutoff 4.0
            special_bonds lj 0.0 1.0 1.0 coul 0.0 1.0 1.0
            region box block {low[0]} {high[0]} {low[1]} {high[1]} -0.5 0.5
            create_box 1 box bond/types 1 extra/bond/per/atom 8 extra/special/per/atom 80
        """)
        self._lammps.create_atoms(count, np.arange(1, count + 1).tolist(), [1] * count, places.ravel().tolist())
        # Springs with about the stiffness of a pair, far too strong to break.
        stiffness = 2.0 * specimen.shear_modulus * specimen.parameters.thickness
        springs = " ".join(str(part * stiffness) for part in (1.0, 0.4, 0.1, 0.1))
        limits = " ".join([str(1e6 * stiffness)] * 4)
        self._lammps.commands_string(f"""
            set group all diameter 1.0 density {density}
            pair_style gran/hooke {stiffness} NULL 0.0 NULL 0.5 0
            pair_coeff * *
            neighbor 0.3 bin
            neigh_modify delay 0 every 20 check yes
            create_bonds many all all 1 0.9 1.1
            special_bonds lj 0.0 1.0 1.0 coul 1.0 1.0 1.0
            bond_style bpm/rotational
            bond_coeff 1 {springs} {limits} 0.0 0.0 0.0 0.0
            fix move all nve/bpm/sphere disc
            fix plane all enforce2d
            timestep {specimen.step_size!r}
            thermo 1000000000
        """)
        velocity = np.zeros((count, 3))
        velocity[:, :2] = specimen.get("velocity")
        self._lammps.scatter_atoms("v", 1, 3, np.ctypeslib.as_ctypes(velocity.ravel()))
        self._lammps.command("run 0 post no")

    def run(self, ticks: int) -> None:
        """Advance by `ticks` internal steps."""
        self._lammps.command(f"run {ticks} pre no post no")

    def count(self) -> int:
        """Return the number of bonds."""
        return int(self._lammps.gather_bonds()[0])

    def close(self) -> None:
        """End LAMMPS."""
        self._lammps.close()
