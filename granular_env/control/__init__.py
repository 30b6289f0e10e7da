"""Studies: methods search for the best drive or policy of a task, each with the same budget of simulated control steps.

`study.py` defines the content of a study's file and `problem.py` its task; `drive.py` converts a few numbers to an action for
every control step; `methods/` has one method per file; `search.py` counts their evaluations; `runner.py` runs every method with
every seed; `results.py` and `figure.py` present the results. Shipped studies are in `studies/`.
"""
