"""Completion in the shell: what each word may become, and that bash, zsh and fish do it when a person presses Tab."""

import os
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest
from support.terminal_tools import Terminal

from granular_env.atlas import names as papers
from granular_env.cli import main
from granular_env.cli.program import program
from granular_env.components import catalogue
from granular_env.domains import environments
from granular_env.package_contents import shipped_files

ROOT = Path(__file__).resolve().parents[1]
KINDS = {
    "run": ["experiments"],
    "sweep": ["plans of sweeps"],
    "study": ["studies"],
    "check": ["experiments", "plans of sweeps", "studies"],
    "describe": ["components", "experiments", "plans of sweeps", "studies", "environments"],
    "new": ["components", "experiments", "plans of sweeps", "studies"],
}


def completed(*words: str, monkeypatch, capsys) -> list[tuple[str, str]]:
    """Return the kind and the text of what bash would be told for the last of these words."""
    monkeypatch.setenv("_GRANULAR_ENV_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", "\n".join(["granular-env", *words]))
    monkeypatch.setenv("COMP_CWORD", str(len(words)))
    assert main([]) == 0
    return [(kind, text) for kind, _, text in (line.partition(",") for line in capsys.readouterr().out.splitlines())]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["run", "discs/broken-row", "--set", "component.br"], ["component.breaking_strain="]),
        (
            ["run", "discs/broken-row", "--set", "input.force.p"],
            [f"input.force.p{key}=" for key in ("rofile", "eak", "attern")],
        ),
        (["sweep", "discs-breaking", "--set", "input.force.pe"], ["input.force.peak="]),
        (["describe", "chain", "--set", "grav"], ["gravity="]),
        (["run", "no-such-experiment", "--set", "comp"], []),
        (["run", "discs/broken-row", "--set", "duration="], []),
    ],
)
def test_keys_that_can_be_set(words, expected, monkeypatch, capsys):
    found = completed(*words, monkeypatch=monkeypatch, capsys=capsys)
    assert [one for one in found if one[1]] == [("plain", key) for key in expected]


@pytest.mark.parametrize("command", KINDS)
def test_names_of_what_is_shipped(command, monkeypatch, capsys):
    known = {"components": catalogue.names, "environments": environments}
    names = [name for kind in KINDS[command] for name in known.get(kind, partial(shipped_files, kind))()]
    assert completed(command, "", monkeypatch=monkeypatch, capsys=capsys) == [("plain", name) for name in names]
    begun = names[-1][:3]
    found = completed(command, begun, monkeypatch=monkeypatch, capsys=capsys)
    assert found == [("plain", name) for name in names if name.startswith(begun)] != []


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["atlas", ""], [("plain", name) for name in papers()]),
        (["run", "my-"], [("file", "my-")]),  # no shipped experiment begins so: it is a file
        (["replay", "lo"], [("file", "lo")]),
        (["run", "x", "--log", "lo"], [("file", "lo")]),
        (["sweep", "x", "-o", "sw"], [("dir", "sw")]),
        (["sweep", "x", "--engine", "r"], [("plain", "ray")]),
        (["completion", ""], [("plain", shell) for shell in ("bash", "zsh", "fish")]),
        (["run", "x", "--ov"], [("plain", "--overwrite")]),
        (["rec"], [("plain", "recover")]),
    ],
)
def test_what_a_word_may_become(words, expected, monkeypatch, capsys):
    assert completed(*words, monkeypatch=monkeypatch, capsys=capsys) == expected


def test_commands_and_their_options(monkeypatch, capsys):
    assert [text for _, text in completed("", monkeypatch=monkeypatch, capsys=capsys)] == list(program.commands)
    for name, command in program.commands.items():
        found = [text for _, text in completed(name, "--", monkeypatch=monkeypatch, capsys=capsys)]
        assert set(found) == {
            option for one in command.params if one.param_type_name == "option" for option in one.opts if option[:2] == "--"
        } | {"--help"}


def test_completion_imports_nothing_heavy():
    code = (
        "import sys\nfrom granular_env.cli import main\nmain([])\n"
        "print([name for name in ('numpy', 'numba', 'scipy', 'gymnasium', 'pydantic', 'rich', 'mcap') if name in sys.modules])"
    )
    words = {"_GRANULAR_ENV_COMPLETE": "bash_complete", "COMP_WORDS": "granular-env\nrun\nnest", "COMP_CWORD": "2"}
    ended = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, env={**os.environ, **words}, capture_output=True, text=True, check=True
    )
    assert "plain,nesterenko-1983/3.4-piston" in ended.stdout
    assert ended.stdout.splitlines()[-1] == "[]"


SHELLS = {
    "bash": (["bash", "--norc", "-i"], 'eval "$(granular-env completion bash)"'),
    "zsh": (["zsh", "-f", "-i"], 'autoload -Uz compinit; compinit -u; eval "$(granular-env completion zsh)"'),
    "fish": (["fish", "--no-config", "-i"], "granular-env completion fish | source"),
}


@pytest.mark.parametrize("shell", SHELLS)
def test_tab_completes_in_a_shell(shell, tmp_path):
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    arguments, switch_on = SHELLS[shell]
    script = tmp_path / "granular-env"
    script.write_text(f'#!/bin/sh\nPYTHONPATH="{ROOT}" exec "{sys.executable}" -m granular_env "$@"\n')
    script.chmod(0o755)
    (tmp_path / "work").mkdir()
    (tmp_path / "work" / "my-pulse.toml").write_text("")
    home = {"PATH": f"{tmp_path}:{os.environ['PATH']}", "HOME": str(tmp_path)}
    with Terminal(arguments, tmp_path / "work", home) as terminal:
        terminal.type(f"{switch_on}; echo rea''dy\n")
        terminal.wait_for("ready")
        for typed, seen in (
            ("granular-env reco\t", "recover"),
            ("granular-env describe osci\t", "oscillator"),
            ("granular-env run discs/b\t", "discs/broken-row"),
            ("granular-env run my\t", "my-pulse.toml"),
            ("granular-env check --allow\t", "--allow-large"),
        ):
            terminal.type(typed)
            terminal.wait_for(seen)
            terminal.type("\x15\n")  # Ctrl-U empties the line
