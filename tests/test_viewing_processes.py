"""Rerun's processes: only on 127.0.0.1, without output and usage data, and ended with the parent process."""

from __future__ import annotations

import contextlib
import ctypes.util
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from support import browser

from granular_env.components.catalogue import make
from granular_env.components.errors import GranularError
from granular_env.recording import open_log, record
from granular_env.viewing import screenshot
from granular_env.viewing.rerun import viewer
from granular_env.viewing.rerun.process import RerunProcess

pytest.importorskip("rerun", reason="the extra `view` is not installed")


def has_vulkan():
    """Return whether the libraries and, if the environment lists drivers, a driver exist; an empty list hides all drivers."""
    named = os.environ.get("VK_DRIVER_FILES", os.environ.get("VK_ICD_FILENAMES"))
    drivers = named is None or any(Path(name).is_file() for name in named.split(os.pathsep) if name)
    return drivers and all(ctypes.util.find_library(name) for name in ("vulkan", "EGL", "xkbcommon-x11"))


HEADLESS = pytest.mark.skipif(not has_vulkan(), reason="headless rerun needs system packages: make system-packages")
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="/proc tells which processes there are")


@pytest.fixture(scope="module")
def log_path(tmp_path_factory):
    path = tmp_path_factory.mktemp("logs") / "chain.mcap"
    chain = make("chain", grains=60, left="piston")
    with record(chain, path, every=2e-6, experiment={"name": "piston", "duration": 1e-4}):
        chain.step(1e-4, left_velocity=5.0)
    return path


@contextlib.contextmanager
def served(path):
    """Serve a log in the web viewer, as `view` does."""
    with open_log(path) as log:
        data = viewer.scene_bytes(log)
    with RerunProcess(data=data, web=True) as process:
        process.wait_for_ports()
        yield process


def test_the_web_viewer_listens_on_this_machine_only(log_path):
    with served(log_path) as process:
        for port in (process.web_port, process.port):
            # All 127.x addresses are this machine; a server on all interfaces would answer here, one on 127.0.0.1 does not.
            with pytest.raises(OSError), socket.create_connection(("127.0.0.2", port), timeout=5.0):
                pass
    assert process.process.poll() is not None


@pytest.mark.skipif(browser.find_browser() is None, reason="no Chromium here: make system-packages")
def test_the_web_viewer_shows_the_layout_and_plays_in_a_real_browser(log_path, tmp_path):
    """The chain's pane has the full width and its dark background; the line at the present time in the x-t diagram moves."""
    with served(log_path) as process, browser.Browser() as chromium:
        chromium.call("Emulation.setDeviceMetricsOverride", width=900, height=600, deviceScaleFactor=1, mobile=False)
        light = {"name": "prefers-color-scheme", "value": "light"}
        chromium.call("Emulation.setEmulatedMedia", features=[light])
        chromium.call("Page.navigate", url=process.page_url)
        rows = set()
        for _ in range(60):
            time.sleep(1.0)
            chromium.take_screenshot(tmp_path / "page.png", whole=False)
            if now := row_of_now(tmp_path / "page.png"):
                rows.add(now)
            if len(rows) > 1:
                break
        assert len(rows) > 1, "the layout did not appear, or does not play"


def row_of_now(picture):
    """Return the row of the orange line across the x-t diagram, 0 if the chain's pane does not have the full width."""
    from matplotlib.image import imread

    pixels = np.rint(255 * imread(picture)[..., :3]).astype(int)
    height, width, _ = pixels.shape
    chain = pixels[int(0.1 * height) : int(0.3 * height)]
    pane = (np.abs(chain - [13, 16, 17]).max(axis=2) <= 2).mean()
    curve = (chain.min(axis=2) > 120).any(axis=0)[int(0.05 * width) : int(0.95 * width)].mean()
    if pane < 0.6 or curve < 0.9:
        return 0
    orange = (np.abs(pixels[:, : width // 3] - [230, 159, 0]).max(axis=2) <= 30).sum(axis=1)
    return int(orange.argmax()) if orange.max() > 0.15 * width else 0


# -- the end --------------------------------------------------------------------------------------------------------------


def children(pid):
    """Return a process and its descendants, from /proc."""
    parents = {}
    for entry in Path("/proc").iterdir():
        with contextlib.suppress(OSError, ValueError):
            fields = (entry / "stat").read_text().rpartition(")")[2].split()
            if fields[0] != "Z":
                parents[int(entry.name)] = int(fields[1])
    found = [pid]
    for known in found:
        found += [child for child, parent in parents.items() if parent == known]
    return found


def alive(pid):
    try:
        return (Path("/proc") / str(pid) / "stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.fixture
def viewing(log_path, tmp_path):
    """Start `granular-env view LOG --web` in a separate process that already serves; return it and its temporary folder."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    environment = {**os.environ, "TMPDIR": str(folder), "HOME": str(tmp_path), "XDG_CONFIG_HOME": "", "XDG_DATA_HOME": ""}
    environment.pop("CI", None)
    command = [sys.executable, "-m", "granular_env", "view", str(log_path), "--web"]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        line = process.stdout.readline()
        assert line.startswith("rerun's web viewer: http://127.0.0.1:"), line + process.stdout.read()
        yield process, folder
        process.kill()


@LINUX
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP", "SIGKILL", "SIGINT"])
def test_whatever_ends_the_command_ends_the_server_and_leaves_no_file(viewing, name):
    process, folder = viewing
    family = children(process.pid)
    assert len(family) == 2
    process.send_signal(getattr(signal, name))
    assert process.wait(30.0) == (0 if name == "SIGINT" else -getattr(signal, name))
    deadline = time.monotonic() + 30.0
    while any(map(alive, family)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(map(alive, family))
    assert list(folder.iterdir()) == []


@LINUX
def test_rerun_prints_nothing_and_keeps_no_usage_data(viewing, tmp_path):
    process, _ = viewing
    process.send_signal(signal.SIGINT)
    assert process.stdout.read() == ""
    assert not [path for path in tmp_path.rglob("*") if "analytics" in path.name]


# -- pictures -------------------------------------------------------------------------------------------------------------


@HEADLESS
def test_a_screenshot_is_taken_without_a_screen(log_path, tmp_path):
    from matplotlib.image import imread

    with open_log(log_path) as log:
        picture = imread(screenshot(log, tmp_path / "scene.png", size=(800, 600)))
    assert picture.shape[:2] == (600, 800) and len(np.unique(picture.reshape(-1, picture.shape[2]), axis=0)) > 100


def test_a_viewer_that_does_not_start_names_the_packages_it_needs(log_path, tmp_path, monkeypatch):
    monkeypatch.setattr("granular_env.viewing.rerun.process._find_rerun_program", lambda: "/bin/false")
    with (
        open_log(log_path) as log,
        pytest.raises(GranularError, match=r"ended with status 1.*make system-packages.*mesa-vulkan-drivers"),
    ):
        screenshot(log, tmp_path / "picture.png")
