"""The generated tables of the site have a row for each parameter, variable, command and key."""

import importlib
import re
import sys
from pathlib import Path

import pytest
from pydantic import TypeAdapter

from granular_env.cli.command import Status
from granular_env.cli.program import COMMANDS
from granular_env.components import catalogue
from granular_env.control.study import Study
from granular_env.experiments import Experiment, shipped_experiments
from granular_env.experiments.templates import make_example
from granular_env.sweep.plan import Plan

DOCS = Path(__file__).resolve().parent.parent / "docs"
sys.path.append(str(DOCS))
site_tables = importlib.import_module("site_tables")
LINE = re.compile(r"^<!-- tables: (\w+) ?(\S*) -->$", re.MULTILINE)
LINES = {line for page in DOCS.rglob("*.md") for line in LINE.findall(page.read_text("utf-8"))}


def rows(kind: str, name: str = "") -> list[str]:
    """Return the first cells of the tables."""
    return re.findall(r"^\| (?:`|<code>)(.*?)(?:`|</code>) \|", site_tables.text_of(kind, name), re.MULTILINE)


@pytest.mark.parametrize("line", sorted(LINES), ids=" ".join)
def test_every_line_of_a_page_gives_tables(line: tuple[str, str]) -> None:
    assert "|---" in site_tables.text_of(*line)


@pytest.mark.parametrize("name", catalogue.built_in_names())
def test_a_component_has_a_row_for_each_parameter_and_variable(name: str) -> None:
    model, component = catalogue.component_class(name).Parameters, make_example(name, {})
    assert {*model.model_fields} <= {*rows("parameters", f"{model.__module__}.{model.__name__}")}
    shown = [one.name for one in component.variables.values() if one.causality in ("input", "output")]
    assert rows("variables", name) == [
        *sorted(shown, key=lambda one: component.variables[one].causality),
        *component.event_kinds,
    ]


def test_commands_have_a_row_for_each_argument_and_option() -> None:
    options = [option for command in COMMANDS for option in command.params]
    found = rows("commands")
    assert len(found) == len(options)
    for option, row in zip(options, found, strict=True):
        assert option.opts[-1].upper() in row.upper()
    assert all(f"| {status:d} |" in site_tables.text_of("statuses", "") for status in Status)


@pytest.mark.parametrize("document", [Experiment, Plan, Study])
def test_keys_of_a_document_have_a_meaning_and_a_valid_example(document: type) -> None:
    shown = site_tables.text_of("keys", f"{document.__module__}.{document.__name__}")
    for _, model in site_tables.toml_tables(document):
        for key, field in site_tables.own_keys(model).items():
            assert field.description is None or f"| `{key}` |" in shown
            for example in field.examples or []:
                TypeAdapter(field.annotation).validate_python(example)
    cells = [[cell.strip() for cell in line.split("|")[1:-1]] for line in shown.splitlines() if line.startswith("| `")]
    assert [row for row in cells if not all((row[0], row[1], row[3], row[4]))] == []


@pytest.mark.parametrize("line", [("parameters", "granular_env.Nothing"), ("variables", "chian"), ("nothing", "")])
def test_an_unknown_name_is_refused(line: tuple[str, str]) -> None:
    with pytest.raises(ValueError, match=f"tables of .*{line[1] or line[0]}"):
        site_tables.text_of(*line)


def test_every_shipped_experiment_has_its_cost() -> None:
    text = (DOCS / "reference" / "cost.md").read_text("utf-8")
    assert re.findall(r"^\| `(\S+/\S+)` \|", text, re.MULTILINE) == shipped_experiments(), (
        "run: python -m benchmarks.shipped NEW"
    )
