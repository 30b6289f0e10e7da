"""Studies: methods search for the best drive or policy of a task, at an equal budget of physics.

`study.py` is the content of a study's file, `problem.py` its task, `drive.py` turns a few numbers into an action for every
control step, `methods/` holds one method a file, `search.py` counts their evaluations, `runner.py` runs every method
with every seed, and `results.py` and `figure.py` show how it went. The studies that come with the package are in `studies/`.
"""
