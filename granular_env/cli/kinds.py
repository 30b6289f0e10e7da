"""The kind of document that a name or a file is: an experiment, a sweep's plan, or a study."""

from __future__ import annotations

import shlex
from pathlib import Path

from granular_env.components.errors import ExperimentError


def is_experiment(name: str) -> bool:
    """Return whether it is a shipped experiment, or a file of one."""
    from granular_env.documents import read
    from granular_env.experiments import shipped_experiments

    return "component" in read(Path(name)) if Path(name).is_file() else name in shipped_experiments()


def is_plan(name: str) -> bool:
    """Return whether it is a shipped plan of a sweep, or a file of one."""
    from granular_env.documents import read
    from granular_env.sweep import plan

    return plan.is_plan(read(Path(name))) if Path(name).is_file() else name in plan.shipped_plans()


def is_study(name: str) -> bool:
    """Return whether it is a shipped study, or a file of one."""
    from granular_env.control import study
    from granular_env.documents import read

    return study.is_study(read(Path(name))) if Path(name).is_file() else name in study.shipped_studies()


_KINDS = {"run": ("an experiment", is_experiment), "sweep": ("a sweep's plan", is_plan), "study": ("a study", is_study)}


def refuse_other_kinds(name: str, command: str) -> None:
    """Refuse a document that another command runs, with the name of that command.

    Raises:
        ExperimentError: it is one.
    """
    if Path(name).is_file() and Path(name).suffix != ".toml":
        return  # whoever loads it says what it is
    for other, (kind, holds) in _KINDS.items():
        if other != command and holds(name):
            raise ExperimentError(f"it is {kind}", hint=f"run it with: granular-env {other} {shlex.quote(name)}", source=name)
