"""Experiments: TOML files that say which component runs, from what start, with which inputs, and what is kept of it.

`schema.py` says what a file may hold, `load.py` finds and reads it, `inputs.py` turns its inputs into
profiles, `stops.py` ends a run early, `prepare.py` holds all of it against the component before anything is written.
The experiments of the papers lie in the folders beside.
"""

from .load import load_experiment, shipped_experiments
from .schema import Experiment

__all__ = ["Experiment", "load_experiment", "shipped_experiments"]
