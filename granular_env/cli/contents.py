"""Commands for the package's contents: `list`, `describe`, and `new`, which copies an item as a template."""

from __future__ import annotations

import os
import shlex
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from granular_env.cli.command import command, print_json, print_lists
from granular_env.cli.kinds import KINDS, document_kind
from granular_env.cli.options import ANY_KIND, FILE, Overrides, json_option, set_option
from granular_env.components.errors import ParameterError
from granular_env.terminal_text import printable_text


@command("list")
@click.argument("word", required=False, help="Show only entries whose kind, name or description contains this word.")
@json_option()
def list_shipped(word: str | None, as_json: bool) -> int:
    """List the components, experiments, plans and studies that come with the package."""
    from granular_env.documents.files import nearest_name_hint
    from granular_env.package_contents import shipped_names, shipped_overview

    wanted, found = (word or "").casefold(), dict[str, dict[str, str]]()
    for kind, entries in shipped_overview().items():
        fitting = {name: line for name, line in entries.items() if wanted in f"{kind} {name} {line}".casefold()}
        found |= {kind: fitting} if fitting else {}
    if not found:
        names = [part for name in shipped_names() for part in (name, name.partition("/")[0])]
        raise ParameterError(f"nothing in the list contains {word!r}", hint=nearest_name_hint(wanted, names))
    closing = "Details: granular-env describe NAME. To run: granular-env run EXPERIMENT, sweep PLAN or study STUDY."
    print_lists(found, as_json, closing)
    return 0


@command("describe")
@click.argument(
    "name", help="A name from `granular-env list`, an environment such as Relief-v1, or a TOML file.", type=ANY_KIND
)
@json_option()
@set_option(help="A parameter of a component, or an argument of an environment, such as grains=5.")
def describe(name: str, as_json: bool, overrides: Overrides) -> int:
    """Print a component's variables, an environment's spaces, or the file of an experiment, a plan or a study."""
    from granular_env.components import catalogue
    from granular_env.domains import find_environment_name, load_environments

    given = _nested_overrides(overrides)
    if name in catalogue.component_names():
        if not overrides:
            _interpret_kernels()
        from granular_env import descriptions

        facts = descriptions.component_facts if as_json else descriptions.describe_component
        found = facts(name, given)
    elif (environment := find_environment_name(name)) is not None:
        from granular_env.envs import description

        facts = description.environment_facts if as_json else description.describe_environment
        found = facts(environment, given)
    else:
        import tomllib

        from granular_env.experiments.templates import experiment_template

        text = _document_text(name)[0] or experiment_template(name, others=load_environments())
        found = tomllib.loads(text) if as_json else "\n".join(map(printable_text, text.splitlines()))
    print(found) if isinstance(found, str) else print_json(found)
    return 0


def _interpret_kernels() -> None:
    """Make numba run this process's functions as plain Python, so that an example component is built without compilation."""
    if "numba" not in sys.modules:
        os.environ["NUMBA_DISABLE_JIT"] = "1"


def _nested_overrides(overrides: Overrides) -> dict[str, Any]:
    """Return overrides as nested mappings; a parameter may have the prefix `component.`, as in an experiment file."""
    from granular_env.documents.overrides import set_key

    given: dict[str, Any] = {}
    for override in overrides:
        key = override.key[1:] if override.key[0] == "component" and len(override.key) > 1 else override.key
        set_key(given, replace(override, key=key))
    return given


@command("new")
@click.argument("template", help="An experiment, plan, study or component, or a log with an experiment.", type=ANY_KIND)
@click.option("-o", "--out", metavar="FILE", type=FILE, help="The TOML file to write (default: print it).")
@click.option("--force", is_flag=True, help="Replace the file if it exists.")
@json_option()
def new(template: str, out: str | None, force: bool, as_json: bool) -> int:
    """Write a template file of an experiment, a plan of a sweep or a study, with the data files that it names."""
    _interpret_kernels()
    from granular_env.documents import is_log
    from granular_env.experiments import templates

    text, runner = _document_text(template)
    if is_log(template):
        text, runner = templates.logged_experiment(template, out and Path(out).stem), "run"
    if out is None:
        text = text or templates.experiment_template(template)
        print_json({"written": None, "text": text}) if as_json else print(text, end="")
        return 0
    written, run_it = templates.write_template(template, Path(out), force, text), f"granular-env {runner} {shlex.quote(out)}"
    if as_json:
        print_json({"written": out, "files": written, "command": run_it})
    else:
        print("\n".join([*(f"written: {path}" for path in written), f"run it with: {run_it}"]))
    return 0


def _document_text(name: str) -> tuple[str, str]:
    """Return the text of the plan or study `name` ("" if it is neither), and the command that runs a file of its kind."""
    from granular_env.documents import find_file

    kind = document_kind(name)
    if kind in ("plans of sweeps", "studies"):
        return find_file(name, "template", kind).read_text(encoding="utf-8"), KINDS[kind].command
    return "", "run"
