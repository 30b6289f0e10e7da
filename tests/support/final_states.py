"""Hashes of the final states of shipped experiments: a table for comparing two versions of the package.

`python tests/support/final_states.py [--duration SECONDS] [NAME ...] > FILE` runs them and prints the table;
`python tests/support/final_states.py --compare BEFORE AFTER` compares two of these files.

The script uses only stable names of the package and reads the state by variable name, so that it also runs with an older
version: `PYTHONPATH=OTHER_TREE python tests/support/final_states.py`.
"""

from __future__ import annotations

import argparse
import hashlib
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import granular_env as ge
from granular_env.experiments import Experiment, load_experiment, shipped_experiments

COLUMNS = ("experiment", "variable", "tick", "sha256")


def shorten_experiment(experiment: Experiment, duration: float | None) -> Experiment:
    """Return the experiment, limited to about `duration` [s]."""
    if duration is None or experiment.duration <= duration:
        return experiment
    step = ge.make(experiment.component.type, **experiment.component.parameters).step_size
    document = {**experiment.to_dict(), "duration": max(round(duration / step), 1) * step}
    return load_experiment(document, folder=experiment.folder)


def final_state(name: str, duration: float | None = None) -> Iterator[tuple[str, str, str, str]]:
    """Run a shipped experiment and yield a row of the table for each variable of its final state."""
    component = ge.run(shorten_experiment(load_experiment(name), duration)).component
    for variable in component.variables.values():
        if variable.state:
            values = np.ascontiguousarray(component.get(variable.name), dtype="<f8")
            yield name, variable.name, str(component.tick), hashlib.sha256(values.tobytes()).hexdigest()


def read_table(path: Path) -> dict[tuple[str, str], tuple[str, ...]]:
    """Return tick and hash from a table file by experiment and variable."""
    rows = (line.split("\t") for line in path.read_text().splitlines()[1:])
    return {(name, variable): tuple(rest) for name, variable, *rest in rows}


def compare_tables(before: Path, after: Path) -> bool:
    """Compare each row of an earlier table with a later table and print the result; return whether all rows are equal."""
    earlier, later = read_table(before), read_table(after)
    verdicts = {key: "same bits" if later.get(key) == row else "DIFFERS" for key, row in earlier.items()}
    for (name, variable), verdict in verdicts.items():
        print(f"{name}\t{variable}\t{earlier[name, variable][0]}\t{verdict}")
    same, new = list(verdicts.values()).count("same bits"), len(later.keys() - earlier.keys())
    print(f"{same} of {len(verdicts)} rows the same, {new} new")
    return "DIFFERS" not in verdicts.values()


def main() -> int:
    """Print the table, or compare two tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", help="shipped experiments; default: all")
    parser.add_argument("--duration", type=float, help="run each for about so long at most [s]")
    parser.add_argument("--compare", nargs=2, type=Path, metavar=("BEFORE", "AFTER"), help="two tables instead of a run")
    given = parser.parse_args()
    if given.compare:
        return 0 if compare_tables(*given.compare) else 1
    warnings.simplefilter("ignore")
    print(*COLUMNS, sep="\t")
    for name in given.names or shipped_experiments():
        for row in final_state(name, given.duration):
            print(*row, sep="\t")
            sys.stdout.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main())
