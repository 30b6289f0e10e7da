"""Sweeps on Ray: bitwise equal to one process, on a local cluster and on two nodes, one of which is killed.

All processes started here have a mark in their environment, by which the tests end them.
"""

import os
import secrets
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("ray")
psutil = pytest.importorskip("psutil")

import granular_env as ge  # noqa: E402
from granular_env.sweep import open_sweep, run_sweep  # noqa: E402

pytestmark = pytest.mark.extra

ROOT = Path(__file__).resolve().parents[1]
RAY = [sys.executable, "-m", "ray.scripts.scripts", "start"]
PLAN = """
version = 1
name = "struck"
experiment = "nesterenko-1983/3.1-one-grain"
log_every = 50
[set]
duration = 2e-4
[grid]
"component.grains" = [3, 60]
"start.velocity.0" = { from = 0.5, to = 1.0, count = COUNT }
[measure]
peak = "max velocity[3]"                 # there is none in the short chains: their tasks fail
speed = { measurement = "waves_at", take = "speed", grain = 1, above = 0.1 }
"""


class Processes:
    """The processes started by a test, identified by a mark in the inherited environment."""

    def __init__(self) -> None:
        self.mark = f"GRANULAR_ENV_TEST_{secrets.token_hex(8)}"
        self.environment = {
            **os.environ,
            self.mark: "1",
            "PYTHONPATH": str(ROOT),
            "RAY_USAGE_STATS_ENABLED": "0",
            "RAY_AUTH_MODE": "token",
            "RAY_AUTH_TOKEN": secrets.token_hex(32),
        }
        self.environment.pop("RAY_ADDRESS", None)

    def start(
        self, command: list[str], cwd: Path | None = None, output: int = subprocess.PIPE, **more: str
    ) -> subprocess.Popen:
        pipes = {"stdout": output, "stderr": output, "stdin": subprocess.DEVNULL, "text": True}
        return subprocess.Popen(command, cwd=cwd, env={**self.environment, **more}, start_new_session=True, **pipes)

    def sweep(self, folder: Path, *arguments: str, **more: str) -> subprocess.Popen:
        command = [sys.executable, "-m", "granular_env", "sweep", "plan.toml", "--out", "ray", "--engine", "ray", *arguments]
        return self.start(command, cwd=folder, **more)

    def left(self) -> Iterator[psutil.Process]:
        for process in psutil.process_iter():
            try:
                if process.pid != os.getpid() and self.mark in process.environ() and process.status() != "zombie":
                    yield process
            except psutil.Error:
                continue

    def end(self) -> None:
        for _ in range(100):
            found = list(self.left())
            for process in found:
                kill(process)
            if not found:
                return
            time.sleep(0.1)


@pytest.fixture
def started():
    processes = Processes()
    yield processes
    processes.end()


def kill(process: psutil.Process) -> None:
    try:
        process.kill()
    except psutil.NoSuchProcess:
        pass


def gone(processes: Processes, seconds: float = 30.0) -> bool:
    limit = time.monotonic() + seconds
    while time.monotonic() < limit:
        if not list(processes.left()):
            return True
        time.sleep(0.2)
    return False


def written(folder: Path, count: int) -> Path:
    (folder / "plan.toml").write_text(PLAN.replace("COUNT", str(count)))
    return folder / "plan.toml"


def same_table(folder: Path) -> bool:
    run_sweep(folder / "plan.toml", folder / "serial", engine="serial")
    return (folder / "serial" / "table.csv").read_bytes() == (folder / "ray" / "table.csv").read_bytes()


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def test_a_cluster_of_our_own_gives_the_bits_of_one_process_and_is_gone_afterwards(tmp_path, started):
    written(tmp_path, 60)
    for name in ("RAY_AUTH_MODE", "RAY_AUTH_TOKEN"):
        del started.environment[name]
    home = tmp_path / "home"
    home.mkdir()
    cache = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    program = started.sweep(tmp_path, "--workers", "2", HOME=str(home), XDG_CACHE_HOME=cache)
    told, errors = program.communicate(timeout=300)
    assert program.returncode == 1, errors
    assert told.startswith("120 tasks: 60 done, 60 failed\n")
    assert same_table(tmp_path)
    assert gone(started)
    # No token is left in the home folder.
    assert not (home / ".ray").exists()
    # A task that fails before its first step leaves a log without steps, so there is nothing to compare.
    expected = {"done": "identical", "failed": "nothing was compared"}
    table = open_sweep(tmp_path / "ray").table
    logs = [(name, outcome) for name, outcome in zip(table["log"], table["outcome"], strict=True) if isinstance(name, str)]
    assert {outcome for _, outcome in logs} == {"done", "failed"}
    assert all(ge.verify(tmp_path / "ray" / name).outcome == expected[outcome] for name, outcome in logs)


def test_an_address_without_a_cluster_is_named(tmp_path):
    written(tmp_path, 2)
    for address in (f"127.0.0.1:{free_port()}", "nowhere", "http://127.0.0.1:1", "127.0.0.1:", "127.0.0.1:99999", ":6379"):
        with pytest.raises(ge.SweepError, match="address: got .*no Ray cluster answers at this address"):
            run_sweep(tmp_path / "plan.toml", tmp_path / "ray", engine="ray", address=address)


class Cluster:
    """A cluster of two nodes on this machine, with one core each."""

    def __init__(self, processes: Processes, folder: str) -> None:
        self.port = free_port()
        common = ["--num-cpus", "1", "--disable-usage-stats", "--include-log-monitor=false", "--block"]
        common += ["--object-store-memory", "100000000"]
        head = ["--head", f"--port={self.port}", "--include-dashboard=false", f"--temp-dir={folder}"]
        self._processes = processes
        self._write_start_state([*head, *common])
        self._wait(lambda: socket.create_connection(("127.0.0.1", self.port), 1.0).close())
        self.second = self._write_start_state([f"--address=127.0.0.1:{self.port}", *common])
        self._wait(lambda: self.has_nodes(2))

    def _write_start_state(self, arguments: list[str]) -> subprocess.Popen:
        command = [*RAY, *arguments, f"--dashboard-agent-listen-port={free_port()}"]
        return self._processes.start(command, output=subprocess.DEVNULL)

    def _wait(self, tried) -> None:
        limit = time.monotonic() + 90.0
        while True:
            try:
                return tried()
            except (OSError, AssertionError):
                assert time.monotonic() < limit, "the cluster does not start"
                time.sleep(0.2)

    def has_nodes(self, count: int) -> None:
        code = f"import ray; ray.init(address='127.0.0.1:{self.port}', logging_level='ERROR', log_to_driver=False)\n"
        code += "print(sum(node['Alive'] for node in ray.nodes()))"
        asked = self._processes.start([sys.executable, "-c", code])
        assert asked.communicate(timeout=90)[0].strip() == str(count)

    def processes_of(self, node: subprocess.Popen) -> list[psutil.Process]:
        return [process for process in self._processes.left() if os.getsid(process.pid) == node.pid]


@pytest.fixture
def cluster(started):
    folder = tempfile.mkdtemp(prefix="ray")  # a short path, because it contains sockets
    yield Cluster(started, folder)
    started.end()
    shutil.rmtree(folder, ignore_errors=True)


@pytest.mark.slow
def test_a_node_that_is_killed_costs_only_its_running_tasks(tmp_path, started, cluster):
    written(tmp_path, 600)
    program = started.sweep(tmp_path, "--address", f"127.0.0.1:{cluster.port}")
    journal = tmp_path / "ray" / "results.jsonl"

    def busy() -> bool:
        return any("compute_on_node" in " ".join(process.cmdline()) for process in cluster.processes_of(cluster.second))

    limit = time.monotonic() + 120.0
    while not (journal.exists() and journal.stat().st_size and busy()):
        assert time.monotonic() < limit and program.poll() is None, program.communicate()
        time.sleep(0.02)
    before = journal.read_bytes().count(b"\n")
    assert before < 1200
    for process in cluster.processes_of(cluster.second):
        kill(process)
    told, errors = program.communicate(timeout=400)
    assert told.startswith("1200 tasks: 600 done, 600 failed\n"), errors
    assert same_table(tmp_path)
    # Each task is in the journal once, so completed tasks were not repeated.
    assert journal.read_bytes().count(b"\n") == 1200
