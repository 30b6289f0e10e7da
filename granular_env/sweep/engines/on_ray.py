"""A Ray cluster: one that runs already, by its address, or one on this machine for as long as the sweep lasts.

Ray places bundles of tasks and tells when a worker or a node is gone; what went with it waits again, as with local processes.
Nodes that join in mid-sweep are used. A node needs this package, of the very version that the sweep was begun with.
"""

from __future__ import annotations

import faulthandler
import os
import secrets
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import redirect_stdout
from dataclasses import replace
from pathlib import Path
from time import monotonic, perf_counter
from typing import Any

from granular_env.components.errors import ParameterError, SweepError, one_line
from granular_env.optional_packages import import_optional

from ..batches import TaskBatches
from ..worker import Computer, Job, Order, Result
from .processes import available_cores, over_time

_BUNDLE_SECONDS = 0.5
_CONNECT_SECONDS, _ANSWER_SECONDS = 5.0, 20.0
# Every so often we look how many cores the cluster has [s].
_LOOK_SECONDS = 2.0
_QUIET = {
    "RAY_USAGE_STATS_ENABLED": "0",
    "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0",
    "RAY_DEDUP_LOGS": "0",
}


def check_cluster(address: str | None) -> None:
    """Everything that can be said of Ray and of a cluster without joining it, within a bounded time.

    Raises:
        MissingExtraError: Ray is not installed.
        SweepError: nobody answers at the address, or not as a Ray cluster of this version does.
    """
    os.environ.update({name: os.environ.get(name, value) for name, value in _QUIET.items()})
    place = _place(address)
    if place is None and "RAY_AUTH_MODE" not in os.environ and "ray" not in sys.modules:
        # Nobody else on this machine shall use our cluster. Ray reads this once; left alone it would write a token at home.
        os.environ |= {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN": secrets.token_hex(32)}
    import_optional("ray", "the engine 'ray'")
    if place is None:
        return
    host, port = place
    try:
        socket.create_connection((host, port), _CONNECT_SECONDS).close()
    except OSError as error:
        raise SweepError(
            f"no Ray cluster can be reached at {host}:{port}: {error.strerror or error}",
            hint=f"start one with `ray start --head --port {port}`, or give the right --address HOST:PORT",
        ) from None
    # Ray itself would wait for a long time; a process of its own can be ended.
    asked = [sys.executable, "-m", "ray.scripts.scripts", "health-check", "--address", f"{host}:{port}"]
    try:
        answer = subprocess.run(asked, capture_output=True, text=True, timeout=_ANSWER_SECONDS, stdin=subprocess.DEVNULL)
        fault = "" if answer.returncode == 0 else _last_line(answer.stderr or answer.stdout) or f"status {answer.returncode}"
    except subprocess.TimeoutExpired:
        fault = f"no answer within {_ANSWER_SECONDS:.0f} s"
    if fault:
        raise SweepError(
            f"{host}:{port} does not answer as a Ray cluster of this version does: {fault}",
            hint=(
                "check the address, the versions of Ray on both sides, and the token where the cluster wants one "
                "(RAY_AUTH_MODE=token)"
            ),
        )


def _place(address: str | None) -> tuple[str, int] | None:
    """Host and port; None for a cluster of our own."""
    given = address if address is not None else os.environ.get("RAY_ADDRESS")
    if not given:
        return None
    host, colon, port = given.rpartition(":")
    if not colon or not host or "/" in host or not port.isdecimal() or not 0 < int(port) < 65536:
        raise ParameterError(
            f"got {one_line(given)}", expected="HOST:PORT of a Ray cluster, such as 10.0.0.1:6379", at="address"
        )
    return host, int(port)


def _last_line(text: str) -> str:
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return one_line(lines[-1], 300) if lines else ""


def on_ray(job: Job, orders: Sequence[Order], folder: Path, workers: int | None, address: str | None) -> Iterator[list[Result]]:
    """Yield the results as they come; logs come with them, since a node may have another disk."""
    ray = import_optional("ray", "the engine 'ray'")
    # Ray prints what it has to say of a node that ended; a program's output is no place for it.
    with redirect_stdout(sys.stderr):
        _join(ray, workers, address)
        try:
            shared = ray.put(job)
            remote = ray.remote(max_retries=0, num_cpus=1)(_bundle)
            yield from _watch(ray, remote, shared, orders, folder, workers, job.time_limit)
        finally:
            ray.shutdown()


def _join(ray: Any, workers: int | None, address: str | None) -> None:
    place = _place(address)
    # Ray itself gives a worker one thread for each of its cores.
    options: dict[str, Any] = {"log_to_driver": False, "logging_level": "ERROR"}
    if place is None:
        options |= {"address": "local", "num_cpus": workers or available_cores(), "include_dashboard": False}
    else:
        options["address"] = f"{place[0]}:{place[1]}"
    try:
        ray.init(**options)
    except Exception as error:  # Ray raises many kinds
        raise SweepError(
            f"Ray does not start, or the cluster takes no program from this machine: {_last_line(str(error))}",
            hint="look at its address with `ray status`, or leave the engine out to use this machine's processes",
        ) from error


def _watch(
    ray: Any, remote: Any, shared: Any, orders: Sequence[Order], folder: Path, workers: int | None, limit: float | None
) -> Iterator[list[Result]]:
    cores, looked = 1, -_LOOK_SECONDS
    bundles, running = TaskBatches(orders, cores, 0.0 if limit else _BUNDLE_SECONDS), {}
    while len(bundles) or running:
        if monotonic() - looked >= _LOOK_SECONDS:
            cores, looked = max(1, int(ray.cluster_resources().get("CPU", 1))), monotonic()
            cores = min(cores, workers or cores)
            bundles.workers = cores
        # One more than there are cores, so that none waits for us.
        while len(bundles) and len(running) <= cores:
            bundle = bundles.take()
            running[remote.remote(shared, bundle)] = bundle
        ready, _ = ray.wait(list(running), timeout=_LOOK_SECONDS)
        for reference in ready:
            bundle = running.pop(reference)
            try:
                found, seconds = ray.get(reference)
            except ray.exceptions.RayTaskError as error:
                raise _refusal(error) from error
            except ray.exceptions.RayError as error:
                found, seconds = bundles.requeue(bundle, _reason(error, limit)), 0.0
            else:
                bundles.note_time(len(found), seconds)
            if found:
                yield [_without_log(result, folder) for result in found]


def _refusal(error: Any) -> SweepError:
    """Return the error for a bundle whose code failed: the node lacks the package, or has another version of it."""
    cause = error.cause if isinstance(error.cause, SweepError) else None
    return SweepError(str(cause) if cause is not None else f"a node of the cluster cannot compute: {_last_line(str(error))}")


def _reason(error: Exception, limit: float | None) -> str:
    """Return Ray's message about a lost worker, in one sentence."""
    reasons = {
        "NodeDiedError": "its node ended",
        "WorkerCrashedError": "its process ended" + (f", or it {over_time(limit)}" if limit else ""),
        "OutOfMemoryError": "memory ran out",
    }
    return reasons.get(type(error).__name__, f"{type(error).__name__}")


def _without_log(result: Result, folder: Path) -> Result:
    """Return the result after moving its log into the results' folder."""
    if result.log is None:
        return result
    from granular_env.output_files import replacing

    with replacing(folder / "logs" / f"{result.hash}.mcap", SweepError) as part:
        part.write_bytes(result.log)
    return replace(result, log=None)


# -- on the nodes ---------------------------------------------------------------------------------------------------


def _bundle(job: Job, orders: Sequence[Order]) -> tuple[list[Result], float]:
    """Compute a bundle in a worker of the cluster."""
    # Ray ends its workers with a signal: a folder that outlives the bundle would stay on the node.
    with tempfile.TemporaryDirectory(prefix="granular-env-sweep-") as folder:
        computer = Computer(job, Path(folder))
        for order in orders:
            computer.warm(order, lambda: _end_after(job.time_limit))
        _end_after(job.time_limit)
        began = perf_counter()
        found = [_with_log(computer, order) for order in orders]
        faulthandler.cancel_dump_traceback_later()
        return found, perf_counter() - began


def _end_after(limit: float | None) -> None:
    """End this process after the time limit, even within a kernel."""
    if limit is not None:
        faulthandler.dump_traceback_later(limit, exit=True)


def _with_log(computer: Computer, order: Order) -> Result:
    result, path = computer.compute(order), computer.log_path(order)
    if not path.exists():
        return result
    data = path.read_bytes()
    path.unlink()
    return replace(result, log=data)
