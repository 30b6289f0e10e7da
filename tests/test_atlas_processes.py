"""The atlas' processes and its folder: what ends with what, and who may write where."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from support.atlas_toys import experiment, toy
from support.terminal_tools import run_in_terminal, seen_lines

import granular_env as ge
from granular_env import atlas
from granular_env.atlas import context, finished_runs
from granular_env.atlas.context import Context
from granular_env.atlas.folder import open_folder
from granular_env.atlas.model import Entry, Findings
from granular_env.components.errors import GranularError

# Two entries that compute for a minute each, one in each of two processes.
SCRIPT = """
import sys
sys.path[:0] = [{tests!r}]
from endless import endless
from support.atlas_toys import toy
from support.terminal_tools import run_in_terminal, seen_lines
from granular_env import atlas
from granular_env.atlas import papers
from granular_env.atlas.model import Entry
from granular_env.cli import main

paper = toy(fails=False)
paper.entries[:] = [Entry(name, "1", "Endless", "Text.", endless) for name in ("first", "second")]
atlas.paper = papers.paper = lambda name: paper
if __name__ == "__main__":
    sys.exit(main(["atlas", "toy-2000", "--out", sys.argv[1], "--processes", sys.argv[2], "--quiet"]))
"""
ENDLESS = """
import os
from support.atlas_toys import experiment
from granular_env.atlas.model import Findings

def endless(context):
    # Another run in each process: they would wait for each other's.
    context.run(experiment(64, 5e9 + os.getpid()) | {"duration": 6000.0, "record": {"every": 1.0, "variables": ["velocity"]}})
    return Findings()
"""


@pytest.fixture(scope="module")
def compiled():
    """Compile what the endless runs need, so that the processes answer a signal and do not compile first."""
    ge.run(experiment(64, 5e9) | {"duration": 1e-4, "record": {"every": 1e-4, "variables": ["velocity"]}})


@pytest.fixture
def start(tmp_path, compiled):
    """Start the command on an endless paper, and wait until each process has begun its log."""
    (tmp_path / "script.py").write_text(SCRIPT.format(tests=str(Path(__file__).parent)))
    (tmp_path / "endless.py").write_text(ENDLESS)
    started = []

    def starting(processes):
        out = tmp_path / "out"
        program = subprocess.Popen(
            [sys.executable, str(tmp_path / "script.py"), str(out), str(processes)],
            env={**os.environ, "PYTHONPATH": f"{tmp_path}{os.pathsep}{Path(__file__).parent}"},
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
        )  # fmt: skip
        started.append(program)
        wait_until(lambda: len(parts(out)) == processes or program.poll() is not None, 300.0)
        assert program.poll() is None, program.communicate()
        children = psutil.Process(program.pid).children(recursive=True)
        assert len(children) >= processes if processes > 1 else not children
        return program, children, out

    yield starting
    for program in started:
        program.kill()
        program.communicate()


def parts(out):
    return list((out / "logs").glob(".*.part"))


def wait_until(holds, seconds):
    end = time.monotonic() + seconds
    while not holds() and time.monotonic() < end:
        time.sleep(0.05)
    return holds()


@pytest.mark.parametrize(
    "name", [*(pytest.param(one, marks=pytest.mark.slow) for one in ("SIGTERM", "SIGHUP")), "SIGKILL", "SIGINT"]
)
def test_no_process_outlives_the_command(start, name):
    program, children, out = start(2)
    program.send_signal(getattr(signal, name))
    # Whoever reads its output comes to the end of it: nobody keeps the pipe open.
    told, errors = program.communicate(timeout=60)
    assert wait_until(lambda: not any(child.is_running() for child in children), 60.0)
    if name == "SIGINT":
        assert program.returncode == 130 and parts(out) == []
        assert "Traceback" not in errors
    else:
        assert program.returncode == -getattr(signal, name)
        with open_folder(out):  # the next atlas there
            assert parts(out) == []


def test_an_interrupt_ends_a_single_process_as_well(start):
    program, _, out = start(1)
    program.send_signal(signal.SIGINT)
    program.communicate(timeout=60)
    assert program.returncode == 130 and parts(out) == []


def test_one_process_computes_in_a_folder_at_a_time(start):
    program, _, out = start(1)
    (half,) = parts(out)
    with pytest.raises(GranularError, match="another process computes an atlas there; wait for it, or choose another folder"):
        atlas.compute(toy(fails=False), out)
    assert half.exists() and program.poll() is None
    program.kill()
    program.communicate()
    done = atlas.compute(toy(fails=False), out)
    assert parts(out) == []
    atlas.write(done, out)
    assert json.loads((out / "atlas.json").read_text())["logs"]


def test_logs_stay_while_another_process_computes(tmp_path):
    done = atlas.compute(toy(fails=False), tmp_path, only=["struck"])
    atlas.write(done, tmp_path)
    before = set((tmp_path / "logs").iterdir())
    other = atlas.compute(toy(fails=False), tmp_path, {"N": 6}, only=["struck"])
    with open_folder(tmp_path):
        atlas.write(other, tmp_path)
        assert before < set((tmp_path / "logs").iterdir())


@pytest.mark.parametrize(
    "content", ["[" * 100_000, '{"a":' * 100_000, "nonsense", "[1]", '{"logs": 5}', "{}", '"\\ud800', "\x00"]
)
def test_what_is_no_atlas_is_refused_before_anything_is_computed(tmp_path, content):
    computed = []

    def spy(context):
        computed.append(context)
        return Findings()

    paper = toy(fails=False)
    paper.entries[:] = [Entry("spy", "1", "Spy", "Text.", spy)]
    (tmp_path / "atlas.json").write_text(content)
    with pytest.raises(GranularError, match="is not the data of an atlas.*remove it, or choose another folder"):
        atlas.compute(paper, tmp_path)
    assert not computed and (tmp_path / "atlas.json").read_text() == content


def test_a_stranger_s_data_that_came_meanwhile_is_kept(tmp_path):
    done = atlas.compute(toy(fails=False), tmp_path, only=["struck"])
    (tmp_path / "atlas.json").write_text("[" * 100_000)
    with pytest.raises(GranularError, match="is not the data of an atlas"):
        atlas.write(done, tmp_path)
    assert (tmp_path / "atlas.json").read_text() == "[" * 100_000 and not (tmp_path / "index.html").exists()


# -- going on --------------------------------------------------------------------------------------------------------


def runs_of(folder, monkeypatch, names):
    """Compute the entries of the toy of these names, and return how many runs were made for them."""
    made = []
    with monkeypatch.context() as patch:
        patch.setattr(context, "run", lambda *args, **options: made.append(1) or ge.run(*args, **options))
        done = atlas.compute(toy(), folder, only=names)
    return len(made), done


def test_a_page_that_was_ended_goes_on_with_the_runs_that_are_left(tmp_path, monkeypatch):
    first, done = runs_of(tmp_path, monkeypatch, ["struck"])
    again, other = runs_of(tmp_path, monkeypatch, ["struck", "again"])
    assert (first, again) == (1, 0)
    assert other.done[0].findings.items[0].values == done.done[0].findings.items[0].values
    [log] = (tmp_path / "logs").iterdir()
    log.write_bytes(log.read_bytes()[:100])
    assert runs_of(tmp_path, monkeypatch, ["struck"])[0] == 1  # A log that cannot be read is made anew,
    monkeypatch.setattr(finished_runs, "_program", lambda: "another")
    assert runs_of(tmp_path, monkeypatch, ["struck"])[0] == 1  # and so is one of another program.


def test_logs_of_a_page_that_was_ended_go_when_the_next_one_does_not_want_them(tmp_path, monkeypatch):
    done = runs_of(tmp_path, monkeypatch, ["struck", "failing"])[1]
    (tmp_path / "logs" / "old.mcap").write_bytes(b"of a page that was ended, and is not wanted any more")
    runs = finished_runs.FinishedRuns(tmp_path)
    for name in ("old.mcap", "../precious.mcap"):
        runs.add(name)
    atlas.write(done, tmp_path)
    [left] = (tmp_path / "logs").iterdir()
    assert runs.names() == {left.name}
    assert runs_of(tmp_path, monkeypatch, ["struck"])[0] == 0


# -- progress --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("processes", [1, 2])
def test_an_entry_tells_of_its_begin_of_each_run_and_of_its_end(tmp_path, processes):
    told = []
    atlas.compute(toy(), tmp_path, processes=processes, notify=lambda entry, share: told.append((entry.name, share)))
    shares = {name: [share for other, share in told if other == name] for name, _ in told}
    assert set(shares) == {entry.name for entry in toy().entries}
    # On a slow machine a run tells of its parts too.
    assert shares["struck"] == sorted(shares["struck"]) and {0.0, 0.5, 1.0} <= set(shares["struck"])
    assert shares["strange"] == [0.0, 1.0]


def test_a_context_counts_the_runs_of_an_entry(tmp_path):
    from support.atlas_toys import experiment

    one, seen = Context(tmp_path, {}), []
    one.begin(seen.append)
    for _ in range(2):
        one.run(experiment(4, 5e9))
    one.watch(experiment(4, 5e9), 1e-6, recorded=False)
    assert seen == [1, 2, 3] and len(one.log_names()) == 1
    one.begin(seen.append)
    assert one.log_names() == []


def test_a_long_run_tells_how_far_it_is(tmp_path, monkeypatch):
    monkeypatch.setattr(context, "_TELL_SECONDS", 0.0)
    one, seen = Context(tmp_path, {}), []
    one.begin(seen.append)
    one.run(experiment(64, 5e9) | {"duration": 1e-2, "record": {"every": 1e-3, "variables": ["velocity"]}})
    assert seen == sorted(seen) and seen[-1] == 1 and any(0.0 < share < 1.0 for share in seen)


def test_a_run_that_begins_faster_than_it_goes_on_tells_the_part_of_its_time(tmp_path, monkeypatch):
    parts = [context.work_done(part, (0.6, 0.1)) for part in (0.0, 0.3, 0.6, 0.8, 1.0)]
    assert parts == pytest.approx([0.0, 0.05, 0.1, 0.55, 1.0])
    assert context.work_done(0.4, (0.0, 0.0)) == pytest.approx(0.4)
    monkeypatch.setattr(context, "_TELL_SECONDS", 0.0)
    one, seen = Context(tmp_path, {}), []
    one.begin(seen.append)
    # All of it is such a beginning, and costs nothing.
    one.run(experiment(64, 5e9) | {"duration": 1e-2, "record": {"every": 1e-3, "variables": ["velocity"]}}, start=(1.0, 0.0))
    assert 0.0 in seen and not any(0.0 < share < 1.0 for share in seen) and seen[-1] == 1


@pytest.mark.slow
def test_the_bar_goes_by_the_work_and_names_what_is_computed_at_80_columns(tmp_path):
    code = (
        "import sys\nfrom granular_env.cli import main\n"
        f"main(['atlas', 'nesterenko-1983', '--out', {str(tmp_path)!r}, '--only', '3.4-energy', '--only', '3.4-piston'])"
    )
    status, written = run_in_terminal(["-c", code], 80)
    lines = [line for line in seen_lines(written) if re.search(r"\d %", line)]
    assert status == 0 and all(len(line) <= 80 for line in lines), written
    parts = {int(re.search(r"(\d+) %", line)[1]) for line in lines}
    # Neither entry is done before the last moment: what is seen between is the work of their runs.
    assert len([part for part in parts if 5 < part < 95]) >= 3, parts
    # Which of the two is being computed at a look depends on the machine; each look names it with its own share.
    assert any(re.search(r"3\.4-(energy|piston) [1-9]\d? %", line) for line in lines), lines
    assert "left" in lines[-1]


TWINS = """
import sys
sys.path[:0] = [{tests!r}]
from pathlib import Path
from support.atlas_toys import experiment
from granular_env.atlas.context import Context
from granular_env.atlas.finished_runs import FinishedRuns

folder, runs = Path(sys.argv[1]), []
context = Context(folder / "logs", {{}}, finished=FinishedRuns(folder))
record = context._record_run
context._record_run = lambda *arguments: runs.append(1) or record(*arguments)
print("ready", flush=True)
sys.stdin.readline()
long = experiment(64, 5e9) | {{"duration": 1.0, "record": {{"every": 0.1, "variables": ["velocity"]}}}}
print(context.run(long).end_tick, len(runs), flush=True)
"""


def test_a_run_that_two_processes_want_is_done_once(tmp_path, compiled):
    script = TWINS.format(tests=str(Path(__file__).parent))
    with open_folder(tmp_path):
        command = [sys.executable, "-c", script, str(tmp_path)]
        twins = [subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) for _ in range(2)]
        assert [one.stdout.readline() for one in twins] == ["ready\n"] * 2
        for one in twins:
            one.stdin.write("go\n")
            one.stdin.flush()
        said = sorted(one.communicate(timeout=120)[0].split()[-1] for one in twins)
    assert said == ["0", "1"]
    assert len(list((tmp_path / "logs").iterdir())) == 1
