"""pyro's two-dimensional compressible gas compared with ours: Sod's problem on 400 cells along the tube, one core.

pyro is a two-dimensional textbook code in NumPy and numba. Our gas is one-dimensional; its reaction and moving cross-section
are not used here. Both methods are second-order with the HLLC solver. The benchmark compares the error of the density and the
cost per cell and step; pyro's cells have a second direction, and pyro adds four ghost cells on each side.
"""

from __future__ import annotations

import contextlib
import io
import os
import tempfile
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import numpy as np

import granular_env as ge
from granular_env.components.detonation.theory import Flow, riemann_problem

from .figures import Figure
from .timing import median_ratio, time_interleaved

# End time, at which the waves have covered a third of the tube (at a Courant number of 0.8 for pyro's fastest wave).
_END, _GAMMA = 0.2, 1.4


def measure(cells: int = 400, rows: int = 40, rounds: int = 3) -> Iterator[Figure]:
    """Compare on `cells` cells along the tube; pyro has `rows` equal rows.

    Raises:
        SystemExit: pyro is not installed.
    """
    load_solver()
    ours, start = sod_tube(cells)
    ours.step(_END)
    ticks = ours.tick
    yield Figure("our density error (Sod)", density_error(ours.centres, ours.get("density"), ours.time), "", at_most=2e-3)
    with _quiet():
        peer = _Sod(cells, rows)
        steps = peer.run()
    yield Figure(
        "pyro's density error (Sod)", density_error(ours.centres, peer.density(), peer.time), "", note=f"{steps} steps"
    )

    def back_to_start() -> None:
        ours.restore(start)
        with _quiet():
            peer.reset()

    runs = {"pyro": peer.run, "ours": lambda: ours._advance_state(ticks)}
    times = time_interleaved(runs, rounds, before=back_to_start)
    cost = {
        "pyro": float(np.median(times["pyro"])) / (steps * cells * rows) * 1e9,
        "ours": float(np.median(times["ours"])) / (ticks * cells) * 1e9,
    }
    note = f"{cost['pyro']:.3g} ns per cell step (in the plane, {rows} rows) against {cost['ours']:.3g} ns"
    each = ticks / (steps * rows)
    yield Figure(f"pyro / ours, per cell step, {cells} cells", each * median_ratio(times["pyro"], times["ours"]), note=note)


def sod_tube(cells: int) -> tuple[Any, Any]:
    """Return our tube (pressure 1 and density 1 on the left, 0.1 and 0.125 on the right) and its snapshot."""
    tube = ge.make(
        "detonation", gas={"gamma": _GAMMA, "gas_constant": 1.0}, initial_pressure=1.0, initial_temperature=1.0,
        cross_section=1.0, length=1.0, cells=cells, ignition_zone=[0.0, 0.1], left="absorbing", right="absorbing",
        step_size=0.2 / cells, regions=[{"x": [0.5, 1.0], "pressure": 0.1, "temperature": 0.8}],
    )  # fmt: skip
    return tube, tube.save()


def density_error(centres: Any, density: Any, time: float) -> float:
    """Return the mean error of the density against the exact solution."""
    found = riemann_problem(Flow(1.0, 0.0, 1.0), Flow(0.125, 0.0, 0.1), gamma=_GAMMA)
    exact = found.state((centres - 0.5) / time)[0]
    return float(np.abs(density - exact).mean())


class _Sod:
    """Sod's problem in pyro."""

    def __init__(self, cells: int, rows: int) -> None:
        self._cells, self._rows = cells, rows
        self.reset()

    def reset(self) -> None:
        """Rebuild the problem in its initial state."""
        self._pyro = load_solver()("compressible")
        inputs = {
            "mesh.nx": self._cells, "mesh.ny": self._rows, "mesh.xmin": 0.0, "mesh.xmax": 1.0, "mesh.ymin": 0.0,
            "mesh.ymax": self._rows / self._cells, "mesh.xlboundary": "outflow", "mesh.xrboundary": "outflow",
            "mesh.ylboundary": "periodic", "mesh.yrboundary": "periodic", "driver.tmax": _END, "driver.cfl": 0.8,
            "driver.max_steps": 100_000, "eos.gamma": _GAMMA, "compressible.riemann": "HLLC",
        }  # fmt: skip
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            self._pyro.initialize_problem("sod", inputs_dict=inputs)

    def run(self) -> int:
        """Run to the end; return the number of steps."""
        while not self._pyro.sim.finished():
            self._pyro.single_step()
        return int(self._pyro.sim.n)

    @property
    def time(self) -> float:
        """Return the time of the present state."""
        return float(self._pyro.sim.cc_data.t)

    def density(self) -> Any:
        """Return the density of the middle row."""
        return np.asarray(self._pyro.get_var("density").v())[:, self._rows // 2]


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Suppress pyro's output."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield


def load_solver() -> Any:
    """Return pyro's simulation class; `SystemExit` if pyro is not installed."""
    os.environ.setdefault("MPLBACKEND", "Agg")
    try:
        return import_module("pyro.pyro_sim").Pyro
    except ImportError as error:
        raise SystemExit(f"pyro cannot be used ({error}): run `make bench-peers`, which installs it") from error
