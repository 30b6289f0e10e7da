"""Experiments: TOML files that say which component runs, from what start, with which inputs, and what is kept of it.

`experiment.py` has the content of a file, `inputs.py` turns its inputs into profiles, `stop_rules.py` ends a run early,
`preparation.py` holds all of it against the component before anything is written. The experiments of the papers
lie in the folders next to these modules.
"""

from .experiment import Experiment, load_experiment, shipped_experiments

__all__ = ["Experiment", "load_experiment", "shipped_experiments"]
