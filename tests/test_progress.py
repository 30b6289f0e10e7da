"""Progress bars in a terminal and without one, for any title."""

import io
import re
import subprocess
import sys

import pytest
from support.terminal_tools import ROOT, run_in_terminal, seen_lines

from granular_env import progress

HOSTILE = "x[/b] [m/s] \x1b[2Jgone \x9b31m \u202e"

# Half of the work is done at once, then the bar is watched for a moment.
SCRIPT = """
import sys, time
from granular_env.progress import progress_bar
with progress_bar(sys.argv[1], 200.0) as bar:
    for done in (20, 40, 60, 80, 100):
        time.sleep(0.1)
        bar.update(done, "t = 0.005567 s", "3,726 ticks/s", "residual +4.2e-08")
    time.sleep(0.6)
"""


@pytest.mark.parametrize(("title", "width"), [("nesterenko-1983/3.4-piston", 80), (HOSTILE, 120)])
def test_bar_percentage_and_figures_are_seen(title, width):
    status, written = run_in_terminal(["-c", SCRIPT, title], width)
    assert status == 0, written
    last = [line for line in seen_lines(written) if "50 %" in line][-1]
    assert len(last) <= width and "━" in last and re.search(r"\d:\d\d:\d\d", last) and "t = 0.005567 s" in last
    assert "\x1b[2Jgone" not in written


def test_without_a_terminal_nothing_is_written():
    ended = subprocess.run([sys.executable, "-c", SCRIPT, "title"], cwd=ROOT, capture_output=True, text=True)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "", "")


def test_a_bar_that_is_not_shown_asks_for_no_figures(monkeypatch):
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    with progress.progress_bar("title", 2, show=False) as bar:
        assert not bar.is_due()
        bar.update(1, "figure")
        bar.advance(1)
    assert sys.stderr.getvalue() == ""


def test_an_unknown_total_shows_a_bar_without_percentage():
    script = "import time; from granular_env.progress import progress_bar\nwith progress_bar('t', None) as b:\n  time.sleep(.3)"
    status, written = run_in_terminal(["-c", script], 80)
    assert status == 0
    assert "%" not in written and "━" in written


def test_an_experiment_of_any_name_runs_in_a_terminal(tmp_path):
    arguments = ["-m", "granular_env", "run", "oscillator/pushed", "--no-log", "--set", 'name="x[/b] [m/s] \\u001b[2J"']
    status, written = run_in_terminal([*arguments, "--set", "duration=2000"], 120, cwd=tmp_path)
    assert status == 0, written
    assert "Traceback" not in written and "\x1b[2J" not in written
    assert any(r"x[/b] [m/s] \x1b[2J" in line for line in seen_lines(written))
