"""Sweeps: one experiment at many values of its keys, in local processes or on a Ray cluster, into one table.

A plan is a TOML file (`plan.py`): an experiment, a grid or samples of its keys (`parameter_values.py`), and the measures of
each run (`measures.py`). `tasks.py` makes tasks of it, each with a hash of everything that decides its result; `worker.py`
computes one; `engines.py` and `ray_cluster.py` say where; `store.py` keeps the results, and `table.py` makes a table of them.

    sweep = ge.run_sweep("solitary-wave-speed", "sweeps/speed")
    sweep.table                     # pandas
"""

from .plan import load_plan
from .runner import check_sweep, run_sweep
from .table import Sweep, open_sweep

__all__ = ["Sweep", "check_sweep", "load_plan", "open_sweep", "run_sweep"]
