"""Progress bars in a terminal and without one, for any title."""

import re
import subprocess
import sys

import pytest
from support.terminal_tools import ROOT, run_in_terminal, visible_lines

HOSTILE = "x[/b] [m/s] \x1b[2Jgone \x9b31m \u202e"

# Half of the work is done immediately, then the bar is observed for a moment.
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
    last = [line for line in visible_lines(written) if "50 %" in line][-1]
    assert len(last) <= width and "━" in last and re.search(r"\d:\d\d:\d\d", last) and "t = 0.005567 s" in last
    assert "\x1b[2Jgone" not in written


def test_without_a_terminal_nothing_is_written():
    ended = subprocess.run([sys.executable, "-c", SCRIPT, "title"], cwd=ROOT, capture_output=True, text=True)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "", "")
