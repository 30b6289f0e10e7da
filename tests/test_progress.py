"""Progress bars: what is seen at each width, for any title, in notebooks and without a terminal."""

import io
import itertools
import re
import subprocess
import sys
import types
from concurrent.futures import ThreadPoolExecutor

import pytest
from support.terminal_tools import ROOT, run_in_terminal, seen_lines

from granular_env import progress
from granular_env.terminal_text import printable

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


TITLES = ["nesterenko-1983/3.4-piston", "a/very/long/path/" + 20 * "folder/" + "log.mcap", HOSTILE]
WIDTHS = [40, 80, 120]


@pytest.fixture(scope="module")
def outputs() -> dict[tuple[str, int], tuple[int, str]]:
    """Return the status and the output for each title and width; several run at once, as they mostly sleep."""
    cases = list(itertools.product(TITLES, WIDTHS))
    with ThreadPoolExecutor(4) as pool:
        found = pool.map(lambda case: run_in_terminal(["-c", SCRIPT, case[0]], case[1]), cases)
        return dict(zip(cases, found, strict=True))


@pytest.mark.parametrize("title", TITLES)
@pytest.mark.parametrize("width", WIDTHS)
def test_bar_percentage_and_time_left_are_seen_at_every_width(width, title, outputs):
    status, written = outputs[title, width]
    assert status == 0, written
    last = [line for line in seen_lines(written) if "50 %" in line][-1]
    assert len(last) <= width
    assert "━" in last
    assert re.search(r"\d:\d\d:\d\d left", last)
    if width >= 80:
        assert "t = 0.005567 s" in last
        assert ("nesterenko-1983/3.4-piston" in last) == ("3.4-piston" in title)
    if width == 120 and "3.4-piston" in title:
        assert "3,726 ticks/s  residual +4.2e-08" in last


def test_a_title_is_neither_markup_nor_obeyed_by_the_terminal():
    status, written = run_in_terminal(["-c", SCRIPT, HOSTILE], 200)
    assert status == 0
    assert r"x[/b] [m/s] \x1b[2Jgone \x9b31m \u202e" in seen_lines(written)[-1]
    assert "\x1b[2Jgone" not in written


def test_printable_text_keeps_letters_and_escapes_controls():
    assert printable("µ-chain [m/s] 3.4") == "µ-chain [m/s] 3.4"
    assert printable("\x1b]0;t\x07\n\udcff\u202e") == r"\x1b]0;t\x07\n\udcff\u202e"


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


def test_several_bars_stand_under_each_other():
    script = """
import time
from granular_env.progress import ProgressBars
with ProgressBars(keep=True) as bars:
    first, second = bars.add("first", 4), bars.add("second", 4)
    for _ in range(4):
        first.advance(1, "best 3")
        second.advance(0.5)
        time.sleep(0.15)
"""
    status, written = run_in_terminal(["-c", script], 80)
    assert status == 0
    last = seen_lines(written)[-2:]
    assert last[0].startswith("first") and "100 %" in last[0] and last[0].rstrip().endswith("best 3")
    assert last[1].startswith("second") and "50 %" in last[1]


def test_an_unknown_total_shows_a_bar_without_percentage():
    script = "import time; from granular_env.progress import progress_bar\nwith progress_bar('t', None) as b:\n  time.sleep(.3)"
    status, written = run_in_terminal(["-c", script], 80)
    assert status == 0
    assert "%" not in written and "━" in written


def test_a_notebook_sees_one_line_of_text_and_no_warning(monkeypatch, recwarn):
    class ZMQInteractiveShell:
        pass

    written = io.StringIO()
    monkeypatch.setitem(sys.modules, "IPython", types.SimpleNamespace(get_ipython=ZMQInteractiveShell))
    monkeypatch.setattr(sys, "stderr", written)
    monkeypatch.setattr(progress, "_NOTEBOOK_SECONDS", 0.0)
    with progress.progress_bar("run", 4.0) as bar:
        bar.update(1.0, "t = 1 s")
        bar.update(3.0, "t = 3 s")
    lines = written.getvalue().split("\r")
    assert any(re.match(r"run   75 %  0:00:00 left  t = 3 s", line) for line in lines)
    assert lines[-1] == "" and lines[-2].strip() == ""
    assert not [warning for warning in recwarn if "ipywidgets" in str(warning.message)]


def test_an_experiment_of_any_name_runs_in_a_terminal(tmp_path):
    arguments = ["-m", "granular_env", "run", "oscillator/pushed", "--no-log", "--set", 'name="x[/b] [m/s] \\u001b[2J"']
    status, written = run_in_terminal([*arguments, "--set", "duration=2000"], 120, cwd=tmp_path)
    assert status == 0, written
    assert "Traceback" not in written and "\x1b[2J" not in written
    assert any(r"x[/b] [m/s] \x1b[2J" in line and " left" in line for line in seen_lines(written))
