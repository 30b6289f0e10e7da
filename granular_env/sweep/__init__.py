"""Sweeps: one experiment at many values of its keys, in local processes or on a Ray cluster, into one table.

A plan is a TOML file (`plan.py`): an experiment, a grid or samples of its keys (`parameter_values.py`), what is measured of
each run (`measures.py`). `planned_runs.py` makes tasks of it, each with a hash of everything that decides its result;
`worker.py` runs one; `engines/` say where; `store.py` keeps what is known on disk from moment to moment, `table.py` makes a
table of it.

    sweep = ge.run_sweep("solitary-wave-speed", "sweeps/speed")
    sweep.table                     # pandas
    sweep.dataset                   # xarray, a dimension for each key of the grid
"""

from .plan import load_plan, shipped_plans
from .runner import check_sweep, run_sweep
from .table import Sweep, open_sweep

__all__ = ["Sweep", "check_sweep", "load_plan", "open_sweep", "run_sweep", "shipped_plans"]
