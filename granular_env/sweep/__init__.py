"""Sweeps: one experiment at many values of its keys, in local processes or on a Ray cluster, with one table of results.

A plan is a TOML file (`plan.py`): an experiment, a grid or samples of its keys (`parameter_values.py`), and the measures of
each run (`measures.py`). `tasks.py` makes the tasks, each with a hash of everything that determines its result; `worker.py`
computes a task; `engines.py` and `ray_cluster.py` distribute tasks; `store.py` stores results; `table.py` tabulates them.

    sweep = ge.run_sweep("solitary-wave-speed", "sweeps/speed")
    sweep.table                     # pandas
"""

from .plan import load_plan
from .runner import check_sweep, run_sweep
from .table import Sweep, open_sweep

__all__ = ["Sweep", "check_sweep", "load_plan", "open_sweep", "run_sweep"]
