"""What people name is opened with care: regular files of a bounded size only."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from granular_env.components.csv_history import read_bounded
from granular_env.components.errors import ExperimentError, ParameterError
from granular_env.experiments import load_experiment
from granular_env.experiments.preparation import prepare

PUSHED = """name = "pushed"
duration = 0.1

[component]
type = "oscillator"

[input.force]
profile = "csv"
path = {path!r}
time_column = "time"
value_column = "force"
time_unit = "s"
value_unit = "N"
"""


def test_an_endless_device_is_no_csv_file(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(PUSHED.format(path="/dev/zero"))
    with pytest.raises(ExperimentError, match="/dev/zero: it is a device, a pipe or a socket, expected a file"):
        prepare(load_experiment(tmp_path / "a.toml"))


def test_a_pipe_and_a_folder_are_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for name, what in (("pipe", "a pipe"), (".", "a folder")):
        with pytest.raises(ParameterError, match=what):
            read_bounded(tmp_path / name, 10, "")


def test_no_more_than_the_cap_is_read(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"x" * 11)
    assert read_bounded(tmp_path / "a", 11, "") == b"x" * 11
    with pytest.raises(ParameterError, match="more than 10 bytes; thin it out"):
        read_bounded(tmp_path / "a", 10, "thin it out")
