"""`python -m benchmarks.shipped [NAME ...]`: run time and memory of the shipped experiments, in docs/reference/cost.md.

Each experiment runs in its own process, one after the other, and again if it compiled kernels. CPU time includes the start of
the program, half a second. With names, only the rows of these experiments are measured again.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from time import process_time

import granular_env as ge
from granular_env.components.component import Component
from granular_env.components.support.jit import cache_folder
from granular_env.experiments import load_experiment, shipped_experiments
from granular_env.experiments.preparation import prepare_experiment
from granular_env.output_files import size_text

from .facts import machine_facts

PAGE = Path(__file__).resolve().parent.parent / "docs" / "reference" / "cost.md"
TABLE = re.compile(r"(?<=<!-- measured -->\n).*(?=<!-- end -->)", re.DOTALL)
ROW = re.compile(r"^\| `(\S+)` \|.*$", re.MULTILINE)
HEADINGS = "| experiment | simulated | ticks | bodies | CPU time | memory | log |\n|---|--:|--:|---|--:|--:|--:|"
# Runs of over 15 minutes, which are measured only by name.
LONG = ("gato-shie-2010/notch-1-inch-fine", "gato-shie-2010/notch-1-inch-finest")


def main(names: Sequence[str]) -> None:
    """Measure the experiments, all short ones without names, and write their rows."""
    shipped = shipped_experiments()
    for name in names or [one for one in shipped if one not in LONG]:
        line = table_row(name, measure_experiment(name))
        print(line, flush=True)
        text = PAGE.read_text("utf-8")
        rows = {found[1]: found[0] for found in ROW.finditer(text)} | {name: line}
        lines = [rows.get(one) or table_row(one, ["not measured", "", ""]) for one in shipped]
        table = "\n".join([f"Measured on {' · '.join(machine_facts().splitlines())}.", "", HEADINGS, *lines, ""])
        PAGE.write_text(TABLE.sub(lambda _, table=table: table, text), "utf-8")


def table_row(name: str, cost: Sequence[str]) -> str:
    """Return the line of an experiment: its size as written, and its cost."""
    ready = prepare_experiment(load_experiment(name), has_trial_step=False)
    duration, ticks = ready.experiment.duration, ready.ticks
    return f"| {' | '.join([f'`{name}`', f'{duration:g} s', f'{ticks:,}', body_counts(ready.component), *cost])} |"


def body_counts(component: Component) -> str:
    """Return the counts of grains, nodes, cells: the first axes of the state."""
    counts = {v.axes[0]: v.shape[0] for v in component.variables.values() if v.state and v.axes}
    return ", ".join(f"{count:,} {axis}s".replace("automatons", "automata") for axis, count in counts.items()) or "1 body"


def measure_experiment(name: str) -> list[str]:
    """Return the CPU time, the peak memory and the size of the log of a run."""
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "run.mcap"
        seconds, memory, has_compiled = run_process(name, log)
        if has_compiled:
            seconds, memory, _ = run_process(name, log)
        return [f"{float(f'{seconds:.2g}'):g} s", size_text(memory), size_text(log.stat().st_size)]


def run_process(name: str, log: Path) -> tuple[float, int, bool]:
    """Run an experiment; return its CPU time [s], its peak memory [bytes], and whether it compiled kernels."""
    before = cached_kernels()
    code = f"from benchmarks import shipped; shipped.report_run({name!r}, {str(log)!r})"
    found = subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.PIPE, text=True).stdout.split()
    return float(found[0]), 1024 * int(found[1]), cached_kernels() != before


def report_run(name: str, log: str) -> None:
    """Run an experiment in this process; print the CPU time [s] and the peak memory [KiB] of the process."""
    ge.run(name, log=log, overwrite=True)
    # The peak in `resource` would include that of the process that started this one.
    peak = re.search(r"VmHWM:\s+(\d+)", Path("/proc/self/status").read_text())
    print(process_time(), peak[1] if peak else 0)


def cached_kernels() -> set[Path]:
    """Return the files of the compiled kernels."""
    folder = cache_folder()
    return set(folder.rglob("*")) if folder else set()


if __name__ == "__main__":
    main(sys.argv[1:])
