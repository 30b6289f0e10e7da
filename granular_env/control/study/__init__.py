"""Studies: TOML files that let methods search for the best drive or policy of a task, at an equal budget of physics.

`study.py` says what a file may hold, `methods/` holds one method a file, `evaluator.py` counts what they ask of the physics
and answers again what was answered before a kill, `trial_record.py` is what is kept of that, `runner.py` is the loop,
`result_files.py`, `figures.py` and `report.py` tell how it went.
"""

from .study import Study, load_study, shipped_studies

__all__ = ["Study", "load_study", "shipped_studies"]
