"""The command line: output, exit status, and no tracebacks."""

import json
import os
import re
import shutil
import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path
from types import SimpleNamespace

import pytest

from granular_env.cli import main
from granular_env.components import catalogue
from granular_env.components.catalogue import make
from granular_env.components.oscillator import Oscillator
from granular_env.experiments import shipped_experiments
from granular_env.recording import open_log, record, verify
from granular_env.run_loop import run


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def log(folder, capsys):
    assert main(["run", "oscillator/pushed", "--log", "a.mcap", "--quiet"]) == 0
    assert capsys.readouterr().out == "a.mcap\n"
    return "a.mcap"


def test_list_names_everything(capsys):
    assert main(["list"]) == 0
    text = capsys.readouterr().out
    assert main(["list", "--json"]) == 0
    known = json.loads(capsys.readouterr().out)
    assert list(known["experiments"]) == shipped_experiments()
    assert {"chain", "oscillator"} <= set(known["components"])
    for name, line in {**known["components"], **known["experiments"]}.items():
        assert name in text
        assert line in text
        assert len(line) > 20


@pytest.mark.parametrize(
    ("word", "kinds", "name"),
    [
        ("psakhie", {"components", "experiments"}, "psakhie-2003/lamb-grid"),
        ("Plans", {"plans of sweeps"}, "tapered-chains"),
        ("fifth root", {"plans of sweeps"}, "solitary-wave-speed"),
    ],
)
def test_list_is_narrowed_by_a_word(word, kinds, name, capsys):
    found = parsed(capsys, "list", word)
    assert found.keys() == kinds and any(name in entries for entries in found.values())
    assert main(["list", word]) == 0
    assert name in capsys.readouterr().out


def test_describe_a_component(capsys):
    assert main(["describe", "chain", "--set", "grains=7", "--set", "left=piston"]) == 0
    text = capsys.readouterr().out
    assert re.search(r"left_velocity +m/s +number", text)
    assert re.search(r"velocity +m/s +\(7,\)", text)
    assert re.search(r"overlap +m +\(8,\)", text)
    assert re.search(r"grains +1 +required +number of grains", text)


def test_describe_has_a_row_for_each_key_of_a_table_within_a_table(capsys):
    assert main(["describe", "shell"]) == 0
    text = capsys.readouterr().out
    assert len(re.findall(r"^  notch +1 +none +a slot", text, flags=re.MULTILINE)) == 2  # for a plate and for a tube
    for row in (
        r"notch.depth +m +0.0006 +depth below",
        r"notch.columns +1 +\d+ +smallest number of columns",
        r"notch.position +m +automatic",
        r"stress +Pa +none",
    ):
        assert re.search(f"^  {row}", text, flags=re.MULTILINE), row
    assert re.search(r'^  integration.surface +1 +"column" .*column.*cell', text, flags=re.MULTILINE)
    assert main(["describe", "shell", "--json"]) == 0
    body = next(one for one in json.loads(capsys.readouterr().out)["parameters"] if one["name"] == "body")
    notch = next(one for one in body["choices"]["tube"]["parameters"] if one["name"] == "notch")
    assert notch["default"] == "none"
    assert {"name": "width", "unit": "m", "default": "0.0005", "description": "width of the slot"} in notch["parameters"]


def test_describe_and_new_compile_nothing(tmp_path):
    """Slow: compiling the kernels of both parts and of the coupling takes half a minute."""
    for command in ("describe", "new"):
        done = subprocess.run(
            [sys.executable, "-m", "granular_env", command, "coupled"], capture_output=True, text=True, timeout=120,
            env={**os.environ, "GRANULAR_ENV_CACHE": str(tmp_path), "GRANULAR_ENV_QUIET": "0"},
        )  # fmt: skip
        assert done.returncode == 0 and "automata" in done.stdout
        assert "compiling" not in done.stderr and not list(tmp_path.rglob("*.kernel"))


@pytest.mark.parametrize("template", [*catalogue.component_names(), "measured/hammer", "nesterenko-1983/3.1-one-grain"])
def test_new_writes_a_file_that_is_valid(template, folder, capsys):
    assert main(["new", template, "-o", "sub/mine.toml"]) == 0
    capsys.readouterr()
    assert main(["check", "sub/mine.toml"]) == 0
    assert capsys.readouterr().out.startswith("valid: ")
    assert main(["new", template, "-o", "sub/mine.toml"]) == 2
    assert "exists" in capsys.readouterr().err
    assert main(["new", template, "-o", "sub/mine.toml", "--force"]) == 0


def test_new_of_an_experiment_whose_data_file_is_gone_writes_nothing(folder, capsys):
    assert main(["new", "measured/hammer", "-o", "mine.toml"]) == 0
    Path("hammer.csv").unlink()
    assert main(["new", "mine.toml", "-o", "other/x.toml"]) == 2
    assert "hammer.csv: the CSV file cannot be read" in capsys.readouterr().err
    assert [path.name for path in folder.iterdir()] == ["mine.toml"]


def test_run_ends_by_telling_where_the_log_is(folder, capsys):
    assert main(["run", "oscillator/pushed"]) == 0
    assert main(["run", "oscillator/pushed", "--set", "component.mass=2"]) == 0
    text = capsys.readouterr().out
    first, second = "logs/oscillator-pushed-1.mcap", "logs/oscillator-pushed-2.mcap"
    assert f"log: {first}" in text
    assert f"replay {second} --verify" in text
    assert "1000 ticks, to 10 s" in text
    assert "energy residual" in text
    assert verify(first).identical
    with open_log(second) as log:
        assert log.metadata["parameters"]["mass"] == 2.0


def test_a_log_is_replaced_only_on_request(log, capsys):
    assert main(["run", "oscillator/pushed", "--log", log]) == 2
    assert "exists" in capsys.readouterr().err
    assert main(["run", "oscillator/pushed", "--log", log, "--overwrite"]) == 0


def test_verify_tells_a_difference_by_its_status(log, capsys, monkeypatch):
    from granular_env.components.oscillator import Oscillator

    advance = Oscillator._advance_state

    def pushed(self, ticks):
        self._block["velocity"][...] += 1e-9
        return advance(self, ticks)

    monkeypatch.setattr(Oscillator, "_advance_state", pushed)
    assert main(["replay", log, "--verify"]) == 1
    text = capsys.readouterr().out
    assert "different" in text
    assert "position" in text or "velocity" in text


def test_a_branch_with_other_inputs(log, capsys):
    table = 'input.force={ profile = "constant", value = 2 }'
    assert main(["branch", log, "--at", "5", "--set", table, "--log", "b.mcap", "--until", "12"]) == 0
    assert "b.mcap" in capsys.readouterr().out
    with open_log("b.mcap") as child, open_log(log) as parent:
        assert child.duration == pytest.approx(7.0, rel=1e-12)
        assert child.get("position", 5.0) == parent.get("position", 5.0)
        assert child.get("position", 9.0) != parent.get("position", 9.0)
    assert verify("b.mcap").identical


def test_a_branch_with_the_same_inputs_has_the_parents_bits(log, capsys):
    assert main(["branch", log, "--at", "0.5", "--quiet"]) == 0
    path = capsys.readouterr().out.strip()
    assert path == "logs/a-branch-1.mcap"
    with open_log(path) as child, open_log(log) as parent:
        times, values = child.series("position")
        assert len(times) == 191
        assert [parent.get("position", time) for time in times] == values.tolist()


def test_recover_check_and_report(log, folder, capsys):
    cut = Path(log).read_bytes()
    Path("cut.mcap").write_bytes(cut[: len(cut) - 200])
    assert main(["check", log]) == 0
    assert main(["check", "cut.mcap"]) == 1
    assert "recover" in capsys.readouterr().out
    assert main(["recover", "cut.mcap", "-o", "whole.mcap"]) == 0
    assert re.search(r"^lost: .+ \(\d+ bytes\)$", capsys.readouterr().out, re.MULTILINE)
    assert main(["check", "whole.mcap"]) == 0
    assert main(["report", log, "--out", "page"]) == 0
    assert "written: page" in capsys.readouterr().out
    assert [*Path("page").glob("*.html")]


def test_a_log_is_told_apart_from_an_experiment(log, capsys):
    for command in ("describe", "run"):
        assert main([command, log]) == 2
        told = f"granular-env {command}: a.mcap: this is a log; try `granular-env check` or `granular-env report`\n"
        assert capsys.readouterr().err == told


OPENING = [
    ["check", "a.mcap"],
    ["branch", "a.mcap", "--at", "5", "--log", "b.mcap"],
    ["recover", "a.mcap", "-o", "whole.mcap"],
    ["export", "a.mcap", "--to", "csv"],
    ["compare", "a.mcap", "a.mcap", "--json"],
]


@pytest.mark.parametrize("arguments", OPENING, ids=lambda arguments: " ".join(arguments))
def test_every_command_that_opens_a_log_can_lift_the_caps(arguments, log, folder, capsys, monkeypatch):
    from granular_env.recording import container

    monkeypatch.setattr(container, "_CHUNK_BYTES", 10)
    monkeypatch.setattr(container, "total_memory", lambda: 0)
    assert main(arguments) == 2
    told = capsys.readouterr().err
    assert "pass allow_large=True (--allow-large) if you trust" in told
    assert [path.name for path in folder.iterdir()] == [log]
    assert main([*arguments, "--allow-large"]) == 0


# -- faults ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run", "nesterenko-1983/3.4-pistn"], "did you mean 'nesterenko-1983/3.4-piston'?"),
        (["run", "oscillator/pushed", "--set", "mass=2"], "did you mean 'component.mass'?"),
        (["run", "nesterenko-1983/3.4-piston", "--set", "component.left=free"], "left_velocity needs left = 'piston'"),
        (["run", "oscillator/pushed", "--set", "input.forse=1"], "input.forse: unknown; did you mean 'force'?"),
        (["run", "."], ".: it is a folder, expected a TOML file"),
        (["run", "protection"], "protection: it is a study; run it with: granular-env study protection"),
        (["list", "psahkie"], "nothing in the list contains 'psahkie'; did you mean 'psakhie-2003'?"),
        (["new", "oscilator"], "did you mean 'oscillator'?"),
        (["replay", "nothing.mcap", "--verify"], "nothing.mcap"),
    ],
)
def test_faults_are_one_message_and_status_2(arguments, said, folder, capsys):
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith(f"granular-env {arguments[0]}: ")
    assert said in captured.err
    assert "Traceback" not in captured.err
    assert [*folder.iterdir()] == []


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--at", "99"], "99 s"),
        (["--at", "5", "--set", "input.forse=1"], "did you mean 'force'?"),
        (["--at", "5", "--set", "component.mass=1"], "inputs only"),
        (["--at", "5", "--until", "4"], "until"),
    ],
)
def test_a_wrong_branch_writes_nothing(arguments, said, log, folder, capsys):
    assert main(["branch", log, *arguments]) == 2
    assert said in capsys.readouterr().err
    assert [path.name for path in folder.iterdir()] == [log]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run", "x", "--log", "a", "--no-log"], "--log and --no-log exclude each other; give one of them."),
        (["branch", "x.mcap", "--at", "soon"], "Invalid value for '--at': got 'soon', expected a time such as 100us or 1e-4"),
    ],
)
def test_options_that_do_not_fit_are_named(arguments, said, folder, capsys):
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert said in captured.err
    assert [*folder.iterdir()] == []


def test_without_a_command_there_is_help(capsys):
    assert main([]) == 0
    text = capsys.readouterr().out
    assert "Usage: granular-env" in text
    for status in ("0 done", "1 a verification", "2 an error", "70 an internal error", "130 ended by"):
        assert status in " ".join(text.split())


def test_a_fault_of_the_program_is_no_difference(monkeypatch, capsys):
    from granular_env.cli.program import program

    def broken(**options):
        raise AttributeError("no such thing")

    monkeypatch.setattr(program.commands["replay"], "callback", broken)
    assert main(["replay", "a.mcap", "--verify"]) == 70
    told = capsys.readouterr().err
    assert "AttributeError: no such thing" in told and "please report it" in told


# -- output for programs and terminals--------------------------------------------------------------------------------


def parsed(capsys, *arguments: str, status: int = 0):
    assert main([*arguments, "--json"]) == status
    return json.loads(capsys.readouterr().out)


def test_results_for_programs(log, folder, capsys):
    facts = parsed(capsys, "run", "oscillator/pushed", "--log", "b.mcap")
    assert (facts["log"], facts["tick"], facts["time"], facts["interrupted"]) == ("b.mcap", 1000, 10.0, False)
    assert abs(facts["balances"]["energy"]["energy_residual"]) < 1e-3
    assert parsed(capsys, "check", "oscillator/pushed")["ticks"] == 1000
    assert parsed(capsys, "replay", "b.mcap")["tick"] == 1000
    verified = parsed(capsys, "replay", "b.mcap", "--verify")
    assert (verified["outcome"], verified["complete"], verified["ticks"], verified["variable"]) == (
        "identical",
        True,
        1000,
        None,
    )
    Path("cut.mcap").write_bytes(Path("b.mcap").read_bytes()[:-1])
    assert parsed(capsys, "replay", "cut.mcap", "--verify", status=3)["outcome"] == "incomplete"
    assert parsed(capsys, "check", "tapered-chains")["tasks"] == 15
    assert parsed(capsys, "check", log)["complete"] is True
    chain = parsed(capsys, "describe", "chain")
    assert {"grains", "radius"} <= {one["name"] for one in chain["parameters"]}
    assert {"name": "velocity", "unit": "m/s", "shape": [4]}.items() <= next(
        one for one in chain["outputs"] if one["name"] == "velocity"
    ).items()
    assert parsed(capsys, "describe", "oscillator/pushed")["component"]["type"] == "oscillator"
    Path("plan.toml").write_text(
        'version = 1\nexperiment = "oscillator/pushed"\n[grid]\n"component.mass" = [1.0, -1.0]\n'
        '[measure]\nend = "final position"\n'
    )
    swept = parsed(capsys, "sweep", "plan.toml", "--engine", "serial", status=1)
    assert (swept["done"], swept["failed"], list(swept["errors"])) == (1, 1, ["1"])


def test_commands_that_write_name_their_files_as_json(log, folder, capsys):
    text = parsed(capsys, "new", "oscillator/pushed")["text"]
    facts = parsed(capsys, "new", "oscillator/pushed", "-o", "a.toml")
    assert facts == {"written": "a.toml", "files": ["a.toml"], "command": "granular-env run a.toml"}
    assert Path("a.toml").read_text() == text.replace("oscillator/pushed", "a")
    facts = parsed(capsys, "branch", log, "--at", "5000 ms", "-o", "b.mcap")
    assert (facts["log"], facts["time"]) == ("b.mcap", 10.0)
    Path("cut.mcap").write_bytes(Path(log).read_bytes()[:-1])
    facts = parsed(capsys, "recover", "cut.mcap", "-o", "whole.mcap")
    assert (facts["written"], facts["ticks"]) == ("whole.mcap", 1000) and facts["bytes_lost"] == 0
    assert parsed(capsys, "view", log, "--foxglove-layout", "a.json") == {"written": "a.json"}
    assert parsed(capsys, "report", log, "-o", "page") == {"written": "page/report.html", "folder": "page"}
    assert "protection" in parsed(capsys, "study", "--list")["studies"]


def test_a_run_says_that_no_stop_rule_was_met(folder, capsys):
    rule = 'stop=[{ variable = "position", above = "1 km" }]'
    assert main(["run", "oscillator/pushed", "--no-log", "--set", rule]) == 0
    assert "no stop rule was met: position above 1000\n" in capsys.readouterr().out
    assert parsed(capsys, "run", "oscillator/pushed", "--no-log", "--set", rule)["unmet_stops"] == ["position above 1000"]


def test_a_log_that_cannot_fit_is_refused(folder, capsys, monkeypatch):
    monkeypatch.setattr(shutil, "disk_usage", lambda path: SimpleNamespace(free=1000))
    for command in ("run", "check"):
        assert main([command, "oscillator/pushed"]) == 2
        assert "has 1 kB of free space; check the duration, or record less often" in capsys.readouterr().err
    assert [*folder.iterdir()] == []
    rule = 'stop=[{ variable = "position", above = 1e9 }]'
    assert main(["check", "oscillator/pushed", "--set", rule]) == 0


def test_a_logs_experiment_is_written_as_a_file(folder, capsys):
    stop = 'stop=[{ variable = "position", above = 1e9 }]'
    inputs = 'input.force={ profile = "sum", profiles = [{ profile = "constant", value = 2 }] }'
    changed = ["--set", "component.mass=2", "--set", "start.position=0.5", "--set", stop, "--set", inputs]
    assert main(["run", "oscillator/pushed", *changed, "--log", "a.mcap", "--quiet"]) == 0
    assert main(["new", "a.mcap", "-o", "mine.toml"]) == 0
    assert main(["run", "mine.toml", "--log", "b.mcap", "--quiet"]) == 0
    with open_log("a.mcap") as first, open_log("b.mcap") as second:
        assert second.metadata["experiment"] == {**first.metadata["experiment"], "name": "mine"}
        assert first.series("position")[1].tobytes() == second.series("position")[1].tobytes()
    with record(make("oscillator"), "script.mcap"):
        pass
    capsys.readouterr()
    assert main(["new", "script.mcap"]) == 2
    assert "contains no experiment" in capsys.readouterr().err


def test_names_out_of_files_are_not_obeyed_by_the_terminal(folder, capsys):
    toml = Path("x.toml")
    assert main(["new", "oscillator/pushed", "-o", str(toml)]) == 0
    toml.write_text(re.sub(r'name = ".*"', r'name = "x\\u001b[2J"', toml.read_text(), count=1))
    capsys.readouterr()
    assert main(["check", "x.toml"]) == 0
    text = capsys.readouterr().out
    assert r"valid: x\x1b[2J, component oscillator" in text and "\x1b" not in text
    assert main(["run", "no\x1b[2Jthing"]) == 2
    assert "\x1b" not in capsys.readouterr().err


def test_a_run_that_would_take_long_is_told_of_by_check(capsys):
    assert main(["check", "oscillator/pushed"]) == 0
    assert "note:" not in capsys.readouterr().out
    assert main(["check", "nesterenko-1983/3.4-piston", "--set", "duration=0.1"]) == 0
    text = capsys.readouterr().out
    assert re.search(r"^note: the run takes about \S+ (s|min|h|days) on this machine, and records up to \d+ MB", text)
    assert "in 200000 ticks of 5e-07 s" in text


# -- events -----------------------------------------------------------------------------------------------------------


def test_events_say_what_broke_and_which_limit_was_passed(folder, capsys):
    assert main(["run", "discs/broken-row", "--log", "row.mcap"]) == 0
    assert "1 event: 1 link_broken; granular-env events row.mcap lists them" in capsys.readouterr().out
    assert main(["events", "row.mcap"]) == 0
    head, row, count, meaning = capsys.readouterr().out.splitlines()
    assert head.split() == ["time", "[s]", "event", "index", "value", "limit", "element", "position", "[m]"]
    assert row.split()[5:-2] == ["discs", "4", "and", "5"]
    time, kind, index, value, limit = row.split()[:5]
    assert (kind, index, limit) == ("link_broken", "4", "0.01") and 0.0 < float(time) < 0.1 and float(value) > 0.01
    assert count == "1 event: 1 link_broken" and "breaking strain" in meaning
    with open_log("row.mcap") as log:
        (event,) = log.events()
        assert float(time) == pytest.approx(event.tick * log.step_size)
    assert main(["events", "row.mcap", "--index", "4", "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["events"]
    assert (found["kind"], found["index"], found["tick"]) == ("link_broken", 4, event.tick)
    assert main(["events", "row.mcap", "--index", "0"]) == 0
    assert "none of that kind or index" in capsys.readouterr().out
    assert main(["events", "row.mcap", "--kind", "link_brokn"]) == 2
    assert "did you mean 'link_broken'?" in capsys.readouterr().err
    assert main(["run", "oscillator/pushed", "--log", "quiet.mcap"]) == 0
    assert "event" not in capsys.readouterr().out
    assert main(["events", "quiet.mcap"]) == 0
    assert "declares no kind of event" in capsys.readouterr().out


def test_a_branch_tells_its_own_events_from_those_before_it(folder, capsys):
    assert main(["run", "discs/broken-row", "--log", "row.mcap", "--quiet"]) == 0
    with open_log("row.mcap") as log:
        time = log.events()[0].tick * log.step_size
    capsys.readouterr()
    assert main(["branch", "row.mcap", "--at", str(1.1 * time), "--log", "late.mcap"]) == 0
    told = capsys.readouterr().out
    summary = re.search(r"no event in this log; 1 before it begins at \S+ s: 1 link_broken", told)[0]
    assert f"{summary}; granular-env events late.mcap lists them" in told
    for options in ([], ["--all"], ["--index", "4"]):
        assert main(["events", "late.mcap", *options]) == 0
        _, row, count, _ = capsys.readouterr().out.splitlines()
        assert float(row.split()[0]) == pytest.approx(time) and row.split()[1] == "link_broken" and count == summary
    assert main(["events", "late.mcap", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["events"] == [] and [event["index"] for event in facts["earlier_events"]] == [4]
    assert main(["replay", "late.mcap", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["events"] == {} and facts["earlier_events"] == {"link_broken": 1}


def test_describe_tells_of_an_environment(capsys):
    assert main(["describe", "Splitting-v1", "--set", "columns=4"]) == 0
    text = capsys.readouterr().out
    assert re.search(r"observation size +19", text) and re.search(r"observation limits +-10 to 10", text)
    assert re.search(r"force\[-1,0\] +1.5 N", text) and re.search(r"target +2", text) and "End of the episode" in text
    assert main(["describe", "granular_env/Splitting-v1", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["action_size"] == 2 and facts["deadline"] == 60 and facts["component"] == "discs"


@pytest.mark.parametrize(
    ("command", "option"),
    [
        (
            ["run", "discs/broken-row", "--log", "x.mcap"],
            "log 'x.mcap': it exists; choose another name, or pass overwrite=True (--overwrite)",
        ),
        (["branch", "x.mcap", "--at", "5"], "--at: got 5 s, but the log extends from 0 s"),
        (["sweep", "discs-breaking", "--workers", "0"], "--workers: got 0, expected a whole number from 1 to 4096"),
    ],
)
def test_a_fault_of_an_argument_names_the_option_that_was_typed(command, option, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    run("discs/broken-row", log="x.mcap", overrides={"duration": 2e-4})
    assert main(command) == 2
    assert f"granular-env {command[0]}: {option}" in capsys.readouterr().err


# -- components of other packages -----------------------------------------------------------------------------------------


class Pendulum(Oscillator):
    """A component of another package."""

    name = "pendulum"


def test_a_log_of_another_package_is_run_again_with_its_component_alone(folder, capsys, monkeypatch):
    point = EntryPoint("pendulum", f"{__name__}:Pendulum", catalogue.ENTRY_POINT_GROUP)
    monkeypatch.setattr(catalogue, "_plugin_entry_points", lambda: [point])
    pendulum = Pendulum()
    with record(pendulum, "a.mcap"):
        pendulum.reset(position=0.01)
        pendulum.step(100 * pendulum.step_size)
    for command in (["replay", "--verify"], ["replay"], ["branch", "--at", "0", "--log", "b.mcap"], ["events", "--nearest"]):
        assert main([*command, "a.mcap"]) == 2
        assert "pass its class, components={'pendulum': ...} (--component pendulum)" in capsys.readouterr().err
        assert main([*command, "a.mcap", "--component", "pendulum"]) == 0
        capsys.readouterr()
    assert main(["replay", "a.mcap", "--component", "pendulm"]) == 2
    assert "did you mean 'pendulum'" in capsys.readouterr().err
