"""Engines: where tasks are computed. Two of them, local processes and Ray, and this process itself, with one interface."""

from __future__ import annotations

from pathlib import Path

from granular_env.components.errors import ParameterError, nearest, one_line
from granular_env.components.support.validation import positive_number, whole_number

from ..worker import Job
from .engine import Engine, compute_all
from .processes import Processes
from .ray_cluster import RayCluster

__all__ = ["Engine", "compute_all", "open_engine"]


def open_engine(name: str, job: Job, folder: Path, workers: int | None = None, address: str | None = None) -> Engine:
    """Return the engine of a name.

    Args:
        name: "processes", "serial" or "ray".
        job: the part that the tasks share.
        folder: of the results.
        workers: how many tasks at a time; None for as many as there are cores.
        address: HOST:PORT of a Ray cluster; None for one of our own, or that of RAY_ADDRESS.

    Raises:
        ParameterError: an unknown engine, or an option that does not fit it.
        SweepError: the cluster cannot be used.
        MissingExtraError: Ray is not installed.
    """
    if name not in (names := ("processes", "serial", "ray")):
        raise ParameterError(f"got {one_line(name)}", hint=nearest(str(name), names), at="engine")
    if job.time_limit is not None:
        positive_number("time_limit", job.time_limit)
    if workers is not None:
        whole_number("workers", workers, 1, 4096)
    for option, given, fitting in (("time_limit", job.time_limit, "processes"), ("address", address, "ray")):
        if given is not None and name not in (fitting, "ray"):
            hint = f"take engine={fitting!r} (--engine {fitting})"
            raise ParameterError(f"the engine {name!r} does not take it", hint=hint, at=option)
    if name == "serial":
        return Engine(job, folder)
    return Processes(job, folder, workers) if name == "processes" else RayCluster(job, folder, workers, address)
