"""Engines, where tasks are computed: in this process, in local ones, on a Ray cluster. All of them call `Computer.compute`.

An engine is a generator of results, in any order; closing it ends whatever it started.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from granular_env.components.errors import Fault, Option, ParameterError, nearest, one_line
from granular_env.components.support.validation import positive_number, whole_number

from ..worker import Job, Order, Result

ENGINES = ("processes", "serial", "ray")


def results(
    engine: str, job: Job, orders: Sequence[Order], folder: Path, workers: int | None, address: str | None
) -> Iterator[list[Result]]:
    """Yield the results of all orders, computed by the engine of that name."""
    if engine == "serial":
        from .serial import in_series

        return in_series(job, orders, folder)
    if engine == "processes":
        from .processes import in_processes

        return in_processes(job, orders, folder, workers)
    from .on_ray import on_ray

    return on_ray(job, orders, folder, workers, address)


def check(engine: str, workers: int | None, address: str | None, time_limit: float | None) -> None:
    """Raise `ParameterError` for an unknown engine, or for options that do not fit the engine."""
    if engine not in ENGINES:
        raise ParameterError(f"got {one_line(engine)}", hint=nearest(str(engine), ENGINES), at="engine")
    if time_limit is not None:
        positive_number("time_limit", time_limit)
        if engine == "serial":
            hint = ("take ", Option("engine", "processes"), ", whose tasks can be ended")
            raise ParameterError(Fault(("time_limit",), "the engine 'serial' has no time limit", hint=hint))
    if workers is not None:
        whole_number("workers", workers, 1, 4096)
    if address is not None and not isinstance(address, str):
        raise ParameterError(f"got {one_line(address)}", expected="a text such as '10.0.0.1:6379'", at="address")
    if address is not None and engine != "ray":
        hint = ("take ", Option("engine", "ray"), " with it")
        raise ParameterError(Fault(("address",), f"{one_line(address)} is of a Ray cluster", hint=hint))
    if engine == "ray":
        from .on_ray import check_cluster

        check_cluster(address)
