"""Comparison of two logs: the first difference, settings, exit status, and the page."""

from __future__ import annotations

import json
import re
import subprocess
import sys

import numpy as np
import pytest

import granular_env as ge
from granular_env.cli import main
from granular_env.components.errors import ParameterError
from granular_env.recording import comparison
from granular_env.recording.comparison import compare_logs

STEP = 5e-7


def record_chain(path, grains=8, every=1e-6, duration=6e-5, speed=5.0, variables=None):
    chain = ge.Chain(grains=grains, left="piston", step_size=STEP)
    with ge.record(chain, path, every=every, variables=variables):
        chain.step(duration, left_velocity=speed)
    return path


@pytest.fixture(scope="module")
def parent(tmp_path_factory):
    return record_chain(tmp_path_factory.mktemp("logs") / "parent.mcap")


@pytest.fixture(scope="module")
def branch(parent):
    """Return the path of a branch with another input from 20 us on."""
    path = parent.with_name("branch.mcap")
    assert main(["branch", str(parent), "--at", "2e-5", "--set", "input.left_velocity=8", "--log", str(path), "--quiet"]) == 0
    return path


def compare(first, second):
    with ge.open_log(first) as log, ge.open_log(second) as other:
        return compare_logs(log, other)


def test_a_branch_differs_from_its_parent_first_in_its_input(parent, branch, monkeypatch):
    """The blocks of a few numbers cut frames and records of the logs in other places than their writer did."""
    monkeypatch.setattr(comparison, "_BLOCK", 20)
    found = compare(parent, branch)
    assert found.outcome == "different" and found.relation == "B is a branch of A from 2e-05 s on."
    first = found.differences[0]
    assert (first.kind, first.name, first.index, first.values) == ("input", "left_velocity", (), (5.0, 8.0))
    assert first.time == pytest.approx(2e-5) and found.frames == 41
    assert found.settings == [] and found.not_compared == []
    with ge.open_log(parent) as log, ge.open_log(branch) as other:
        (times, before), (_, after) = (one.series("velocity") for one in (log, other))
        before, times = before[20:], times[20:]
    [velocity] = [one for one in found.differences if one.name == "velocity"]
    frame, place = np.argwhere(before != after)[0]
    assert (velocity.time, velocity.index) == (times[frame], (place,))
    assert velocity.values == (before[frame, place], after[frame, place])
    assert velocity.largest == np.abs(after - before).max() and velocity.unit == "m/s"
    assert np.abs(after - before)[:, *velocity.largest_index].max() == velocity.largest


def test_equal_logs_are_identical(parent):
    same = parent.with_name("same.mcap")
    with ge.open_log(parent) as log:
        log.branch(2e-5).run(same).close()
    found = compare(parent, same)
    assert found.outcome == "identical" and found.differences == []
    assert found.message.endswith("at 41 common times from 2e-05 s to 6e-05 s, and the events")
    assert main(["compare", str(parent), str(same), "--json"]) == 0


def test_a_difference_in_the_last_bit_is_found(parent, tmp_path):
    other = record_chain(tmp_path / "other.mcap", speed=float(np.nextafter(5.0, 6.0)))
    first = compare(parent, other).differences[0]
    assert first.kind == "input" and first.values == (5.0, float(np.nextafter(5.0, 6.0)))
    assert "5.0 and 5.000000000000001 m/s" in str(first)


def test_settings_and_shapes_that_differ_are_listed(parent, tmp_path):
    found = compare(parent, record_chain(tmp_path / "longer.mcap", grains=9))
    names = {name: values for name, *values in found.settings}
    assert names["parameters.grains"] == [8, 9]
    assert "velocity" in found.not_compared and "kinetic_energy" in found.compared


@pytest.mark.parametrize("forced", [[[0.0, 0.0]], []])
def test_inputs_of_another_shape_are_named(tmp_path, capsys, forced):
    paths = [tmp_path / f"{name}.mcap" for name in ("two", "other")]
    for path, nodes in zip(paths, ([[0.0, 0.0], [0.04, 0.0]], forced), strict=True):
        body = ge.make("grid", forced_nodes=nodes)
        with ge.record(body, path, every=body.step_size):
            body.step(3.0 * body.step_size)
    for pair in (paths, paths[::-1]):
        assert compare(*pair).not_compared == ["force"]
        assert main(["compare", *map(str, pair), "--out", str(tmp_path / "page")]) == 0
        assert "step sizes differ: force." in " ".join(capsys.readouterr().out.split())
    assert "step sizes differ: force." in (tmp_path / "page" / "compare.html").read_text()


def test_events_that_differ_are_found(tmp_path):
    paths = [tmp_path / f"{name}.mcap" for name in ("weak", "strong")]
    for path, strain in zip(paths, ("0.01", "0.5"), strict=True):
        command = ["run", "discs/broken-row", "--set", f"component.breaking_strain={strain}", "--set", "duration=0.02"]
        assert main([*command, "--log", str(path), "--quiet"]) == 0
    found = compare(*paths)
    [events] = [one for one in found.differences if one.kind == "events"]
    with ge.open_log(paths[0]) as log:
        assert events.time == log.events()[0].tick * log.step_size
        assert events.values == (len(log.events()), 0)
    with ge.open_log(paths[0]) as log, ge.open_log(paths[1]) as other:
        ge.viewing.compare(log, other, tmp_path / "page")
    page = (tmp_path / "page" / "compare.html").read_text()
    assert page.count(">B, t = ") == 3 and "parameters.breaking_strain" in page
    assert {"pictures.png", "linked.png"} <= {one.name for one in (tmp_path / "page").iterdir()}


def test_the_page_shows_both_logs_in_the_same_axes(parent, branch, tmp_path, capsys):
    folder = tmp_path / "page"
    assert main(["compare", str(parent), str(branch), "--out", str(folder), "--format", "svg"]) == 1
    printed = capsys.readouterr().out
    assert "first difference: input left_velocity at 2e-05 s: 5.0 and 8.0 m/s" in printed
    assert f"written: {folder / 'compare.html'}" in printed
    page = (folder / "compare.html").read_text()
    headings = re.findall(r"<h2[^>]*>([^<]*)</h2>", page)
    assert headings[:2] == ["First differences", "Inputs"] and {"Velocity", "Outputs"} <= set(headings)
    texts = re.findall(r"<text[^>]*>([^<]*)</text>", page)
    assert {"A: left velocity", "B: left velocity", "A: kinetic energy", "B: kinetic energy"} <= set(texts)
    assert (folder / "velocity.svg").exists() and "<script" not in page


def test_logs_without_a_common_time_are_not_compared(parent, tmp_path, capsys):
    early, late = record_chain(tmp_path / "early.mcap", duration=2e-5), tmp_path / "late.mcap"
    with ge.open_log(parent) as log:
        log.branch(4e-5).run(late).close()
    assert main(["compare", str(early), str(late), "--out", str(tmp_path / "page")]) == 3
    assert "nothing was compared: the logs have no output with a common time" in capsys.readouterr().out


def test_other_components_are_refused_before_anything_is_written(parent, tmp_path, capsys):
    path = tmp_path / "oscillator.mcap"
    assert main(["run", "oscillator/pushed", "--log", str(path), "--quiet"]) == 0
    assert main(["compare", str(parent), str(path), "--out", str(tmp_path / "page")]) == 2
    assert "got 'chain' and 'oscillator', expected two logs of one component" in capsys.readouterr().err
    assert not (tmp_path / "page").exists()
    with ge.open_log(parent) as log, pytest.raises(ParameterError, match="expected one of png, svg, pdf"):
        ge.viewing.compare(log, log, tmp_path / "page", file_format="bmp")


def test_json_needs_no_matplotlib(parent, branch, tmp_path):
    program = "import sys; sys.modules['matplotlib'] = None; from granular_env.cli import main; sys.exit(main(sys.argv[1:]))"
    command = [sys.executable, "-c", program, "compare", str(parent), str(branch), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 1, done.stderr
    found = json.loads(done.stdout)
    assert found["outcome"] == "different" and found["written"] is None
    assert found["differences"][0]["name"] == "left_velocity" and list(tmp_path.iterdir()) == []
