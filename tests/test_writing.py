"""Files named by users are written completely or not at all: on a full disk, over a device, over existing files."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from granular_env.cli import main
from granular_env.components.errors import GranularError, LogError, ParameterError
from granular_env.output_files import replace_file, write_files
from granular_env.recording import open_log, verify

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def log(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("logs") / "a.mcap"
    assert main(["run", "oscillator/pushed", "--log", str(path), "--quiet"]) == 0
    return path


def test_a_file_is_replaced_when_the_new_one_is_whole(tmp_path):
    target = tmp_path / "new" / "a.txt"
    for content in ("one", "two"):
        with replace_file(target) as part:
            part.write_text(content)
            assert not target.exists() or target.read_text() == "one"
        assert target.read_text() == content
    assert os.listdir(target.parent) == ["a.txt"]


def test_a_failure_leaves_what_stood_there_and_nothing_else(tmp_path):
    (tmp_path / "a.txt").write_text("old")
    with (
        pytest.raises(LogError, match=r"a\.txt' cannot be written: No space left"),
        replace_file(tmp_path / "a.txt", LogError) as part,
    ):
        part.write_text("half of i")
        raise OSError(28, "No space left on device")
    with pytest.raises(ZeroDivisionError), replace_file(tmp_path / "a.txt"):
        raise ZeroDivisionError
    assert os.listdir(tmp_path) == ["a.txt"]
    assert (tmp_path / "a.txt").read_text() == "old"


def test_several_files_are_written_or_none(tmp_path):
    (tmp_path / "taken").write_text("a file, no folder")
    with pytest.raises(GranularError, match="taken/b"):
        write_files({tmp_path / "a": b"1", tmp_path / "taken" / "b": b"2"})
    assert os.listdir(tmp_path) == ["taken"]
    write_files({tmp_path / "a": b"1", tmp_path / "b": b"2"})
    assert (tmp_path / "b").read_bytes() == b"2"


def test_a_link_stays_one(tmp_path):
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to("real")
    write_files({tmp_path / "link": b"new"})
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text() == "new"


def writers(log: Path, target: str) -> list[list[str]]:
    """Return all commands that write one file named by the user."""
    return [
        ["new", "measured/hammer", "-o", target, "--force"],
        ["recover", str(log), "-o", target, "--overwrite"],
        ["view", str(log), "--save", target],
        ["view", str(log), "--screenshot", target],
    ]


@pytest.mark.parametrize("number", range(4))
@pytest.mark.parametrize("what", ["folder", "pipe"])
def test_nothing_is_written_over_a_folder_or_a_pipe(log, tmp_path, capsys, number, what):
    pytest.importorskip("rerun")
    target = tmp_path / "target.png"
    target.mkdir() if what == "folder" else os.mkfifo(target)
    assert main(writers(log, str(target))[number]) == 2
    assert f"is a {'folder' if what == 'folder' else 'device, a pipe or a socket'}" in capsys.readouterr().err
    assert target.is_dir() or target.is_fifo()
    assert set(os.listdir(tmp_path)) <= {"target.png", "hammer.csv"}


def test_a_report_takes_no_file_for_a_folder(log, tmp_path, capsys):
    pytest.importorskip("matplotlib")
    (tmp_path / "page").write_text("taken")
    assert main(["report", str(log), "-o", str(tmp_path / "page")]) == 2
    assert "is a file" in capsys.readouterr().err
    (tmp_path / "page").unlink()
    (tmp_path / "page" / "report.html").mkdir(parents=True)
    assert main(["report", str(log), "-o", str(tmp_path / "page")]) == 2
    assert "report.html' is a folder" in capsys.readouterr().err
    assert os.listdir(tmp_path / "page") == ["report.html"]


# Limit the file size [bytes] to simulate a full disk.
LIMITED = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]),) * 2)
from granular_env.cli import main
sys.exit(main(sys.argv[2:]))
"""


def limited(room: int, arguments: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", LIMITED, str(room), *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=120,
    )


@pytest.mark.parametrize(
    ("room", "arguments", "package"),
    [
        (100, ["new", "measured/hammer", "-o", "out/x.toml"], "numpy"),
        (2000, ["recover", "LOG", "-o", "out/x.mcap"], "numpy"),
        (5000, ["view", "LOG", "--save", "out/x.rrd"], "rerun"),
        (5000, ["report", "LOG", "-o", "out"], "matplotlib"),
    ],
    ids=lambda value: value[0] if isinstance(value, list) else "",
)
def test_a_full_disk_is_told_and_nothing_is_left(log, tmp_path, room, arguments, package):
    pytest.importorskip("resource")
    pytest.importorskip(package)
    (tmp_path / "out").mkdir()
    arguments = [str(log) if word == "LOG" else word for word in arguments]
    ended = limited(room, arguments, tmp_path)
    assert ended.returncode == 2, ended.stderr
    told = ended.stderr.splitlines()[-1]
    assert told.startswith(f"granular-env {arguments[0]}: ")
    assert "cannot be written" in told
    assert "out" in told
    assert "Traceback" not in ended.stderr
    assert os.listdir(tmp_path / "out") == []


def test_what_a_full_disk_leaves_of_a_run_can_be_read_and_recovered(tmp_path):
    pytest.importorskip("resource")
    command = ["run", "oscillator/pushed", "--log", "a.mcap", "--hash-every", "1", "--set", "duration=2000", "--quiet"]
    ended = limited(1_000_000, command, tmp_path)
    assert ended.returncode == 2, ended.stderr
    assert "a.mcap' cannot be written any more: File too large; free some space" in ended.stderr
    assert "Traceback" not in ended.stderr
    with open_log(tmp_path / "a.mcap") as log:
        facts = log.metadata
        assert not log.complete and not facts["complete"]
        assert facts["component"] == "oscillator" and facts["experiment"]["name"] == "oscillator/pushed"
        assert facts["experiment"]["duration"] == 2000.0 and facts["parameters"]["mass"] == 1.0
        assert facts["report"] == {} and "truncated" in facts["damage"]
        kept = log.end_tick
    assert main(["recover", str(tmp_path / "a.mcap"), "-o", str(tmp_path / "whole.mcap")]) == 0
    with open_log(tmp_path / "whole.mcap") as whole:
        assert whole.complete and whole.end_tick == kept > 0
        assert whole.incidents[-1]["incident"] == "recovered"
    assert verify(tmp_path / "whole.mcap").identical


def test_a_device_is_left_alone(tmp_path):
    with pytest.raises(ParameterError, match="/dev/null' is a device"):
        write_files({Path("/dev/null"): b"x"})
