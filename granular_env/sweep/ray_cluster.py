"""The engine "ray": computes tasks on a running Ray cluster, given by its address, or on a temporary one on this machine.

Ray distributes the tasks, and reports workers and nodes that end. Nodes that join during the sweep are used. Results and logs
are sent back to this process, so the nodes need no access to the results' folder.
"""

from __future__ import annotations

import os
import secrets
import socket
import sys
import tempfile
from collections.abc import Collection
from contextlib import ExitStack, redirect_stdout
from pathlib import Path
from time import monotonic
from typing import Any

from granular_env.components.errors import SweepError, one_line
from granular_env.components.support.threads import thread_count
from granular_env.optional_packages import import_optional
from granular_env.output_files import replace_file

from .engines import LOOK_SECONDS, ONE_THREAD, Engine, TaskLostError
from .worker import Job, Result, Task, compute_task, log_path, write_inputs

_CONNECT_SECONDS = 5.0
_QUIET = {"RAY_USAGE_STATS_ENABLED": "0", "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0", "RAY_DEDUP_LOGS": "0"}


class RayCluster(Engine):
    """An engine that computes tasks on a Ray cluster."""

    def __init__(self, job: Job, folder: Path, workers: int | None, address: str | None) -> None:
        options = _connection_options(address, workers or thread_count())
        self._ray = ray = import_optional("ray", "the engine 'ray'")
        self._folder, self._most, self._cores, self._looked = folder, workers, 1, -LOOK_SECONDS
        with ExitStack() as held:
            held.enter_context(redirect_stdout(sys.stderr))  # Ray prints a message when a node ends
            held.callback(ray.shutdown)
            try:
                ray.init(**options, log_to_driver=False, logging_level="ERROR")
            except Exception as error:  # Ray raises errors of many types
                raise SweepError(
                    f"Ray does not start, or the cluster rejects programs from this machine: {_last_line(error)}",
                    hint="check the address with `ray status`, the versions of Ray, and the token (RAY_AUTH_MODE=token)",
                ) from error
            self._job, self._remote = ray.put(job), ray.remote(max_retries=0, num_cpus=1)(compute_on_node)
            self._held = held.pop_all()

    @property
    def capacity(self) -> int:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Largest number of submitted tasks: one more than the cluster's cores, so that no core waits for this program."""
        if monotonic() - self._looked >= LOOK_SECONDS:
            cores, self._looked = max(1, int(self._ray.cluster_resources().get("CPU", 1))), monotonic()
            self._cores = min(cores, self._most or cores)
        return self._cores + 1

    def submit(self, task: Task) -> Any:
        """Start the computation of a task on a node."""
        return self._remote.remote(self._job, task)

    def wait(self, handles: Collection[Any]) -> Collection[Any]:
        """Wait at most two seconds for finished tasks; return their handles. Later, nodes that have joined get tasks."""
        return self._ray.wait(list(handles), timeout=LOOK_SECONDS)[0]

    def result(self, handle: Any) -> Result:
        """Return the result of a task, and store its log in the results' folder."""
        errors = self._ray.exceptions
        try:
            found, log = self._ray.get(handle)
        except errors.RayTaskError as error:
            own = isinstance(error.cause, SweepError)
            raise SweepError(str(error.cause) if own else f"a node cannot compute tasks: {_last_line(error)}") from error
        except errors.RayError as error:
            raise TaskLostError(f"Ray reports {type(error).__name__}") from error
        if log is not None:
            with replace_file(log_path(self._folder, found.hash), SweepError) as part:
                part.write_bytes(log)
        return found

    def close(self) -> None:
        """Disconnect from the cluster; end it if it is temporary."""
        self._held.close()


def compute_on_node(job: Job, task: Task) -> tuple[Result, bytes | None]:
    """Compute a task in a worker of the cluster; return its result and its log."""
    os.environ.update(ONE_THREAD)
    # Use a folder for this task only: Ray ends its workers with a signal, so a longer-lived folder would remain on the node.
    with tempfile.TemporaryDirectory(prefix="granular-env-sweep-") as name:
        write_inputs(job, Path(name))
        found = compute_task(job, task, Path(name))
        log = log_path(Path(name), task.hash)
        return found, log.read_bytes() if log.exists() else None


def _connection_options(address: str | None, cores: int) -> dict[str, Any]:
    """Return the options of `ray.init`; `SweepError` if nothing answers at the address (Ray would retry for minutes)."""
    os.environ.update({name: os.environ.get(name, value) for name, value in _QUIET.items()})
    given = address or os.environ.get("RAY_ADDRESS")
    if not given:
        if "RAY_AUTH_MODE" not in os.environ and "ray" not in sys.modules:
            # The token keeps others out of the temporary cluster. Ray reads it once; otherwise it would write it to a file.
            os.environ |= {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN": secrets.token_hex(32)}
        return {"address": "local", "num_cpus": cores, "include_dashboard": False}
    try:
        host, port = str(given).rsplit(":", 1)
        socket.create_connection((host, int(port)), _CONNECT_SECONDS).close()
    except (OSError, ValueError, OverflowError) as error:
        raise SweepError(
            f"got {one_line(given)}, but no Ray cluster answers at this address: {getattr(error, 'strerror', None) or error}",
            expected="HOST:PORT, such as 10.0.0.1:6379",
            hint="start a cluster with `ray start --head --port 6379`, or give the right address",
            at="address",
        ) from None
    return {"address": given}


def _last_line(error: Exception) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return one_line(lines[-1], 300) if lines else ""
