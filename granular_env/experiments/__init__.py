"""Experiments: TOML files that define a component, its start and inputs, and the recorded output.

`experiment.py` defines the content of a file, `inputs.py` converts inputs to profiles, `stop_rules.py` ends a run early, and
`preparation.py` validates everything against the component before anything is written. The experiments of the papers
are in the folders next to these modules.
"""

from .experiment import Experiment, load_experiment, shipped_experiments

__all__ = ["Experiment", "load_experiment", "shipped_experiments"]
