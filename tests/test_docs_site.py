"""The documentation as a site: it builds without a warning, typesets its formulas, finds names, and lists every public one."""

import importlib
import importlib.util
import json
import re
import subprocess
import sys
from pathlib import Path
from types import FunctionType
from typing import Any, get_args
from xml.etree import ElementTree

import pytest
from pydantic import BaseModel
from support import browser

import granular_env as ge
from granular_env import envs, recording, sweep, viewing
from granular_env.components import catalogue
from granular_env.components.stepping import Observer
from granular_env.components.support.validation import Choices
from granular_env.domains import chain

ROOT = Path(__file__).resolve().parent.parent
TEXTS = {".md", ".py", ".toml", ".yml", ".cff", ".css", ".js", ""}
CONFLICT = re.compile(r"^(<<<<<<< |=======$|>>>>>>> )", re.MULTILINE)
PUBLIC_PACKAGES = (ge, envs, recording, sweep, viewing, chain, chain.control, chain.measurement)
ENTRY = re.compile(r"^::: (\S+)$", re.MULTILINE)


def reference_entries() -> set[str]:
    return {entry for page in (ROOT / "docs" / "reference").glob("*.md") for entry in ENTRY.findall(page.read_text())}


def tracked_texts() -> list[Path]:
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode != 0:
        pytest.skip("this is no git checkout")
    paths = [ROOT / line for line in listed.stdout.splitlines()]
    return [path for path in paths if path.suffix in TEXTS and path.is_file()]


def test_no_file_holds_markers_of_a_merge_conflict():
    assert [str(path) for path in tracked_texts() if CONFLICT.search(path.read_text(errors="replace"))] == []


def parameter_classes(model: type[BaseModel]) -> set[type[BaseModel]]:
    """A model of parameters, and whatever its fields may hold: parts, and the tables that a name chooses."""
    found = {model}
    for field in model.model_fields.values():
        kinds = {one for one in (field.annotation, *get_args(field.annotation)) if isinstance(one, type)}
        inner = kinds.union(*(mark.choices.values() for mark in field.metadata if isinstance(mark, Choices)))
        found.update(*(parameter_classes(kind) for kind in inner - found if issubclass(kind, BaseModel)))
    return found


def public_objects() -> set[str]:
    """Where everything is defined that a user names: public names, components, and what their parameters may be."""
    components = [catalogue.component_class(name) for name in catalogue.own_names()]
    things = {Observer, *components}.union(*(parameter_classes(one.Parameters) for one in components))
    things |= {getattr(package, name) for package in PUBLIC_PACKAGES for name in package.__all__}
    return {where_defined(one) for one in things if isinstance(one, type | FunctionType)}


def where_defined(thing: Any) -> str:
    return f"{getattr(thing, '__module__', '')}.{getattr(thing, '__qualname__', '')}"


def test_every_public_name_is_in_the_reference():
    entries, found = reference_entries(), public_objects()
    assert len(found) > 150 and {"granular_env.components.chain.laws.hertz.Hertz", "granular_env.envs.task.Task"} <= found
    # An entry may be a module, or a package that shows what it exports.
    packages = [package for package in PUBLIC_PACKAGES if package.__name__ in entries]
    shown = {where_defined(getattr(package, name)) for package in packages for name in package.__all__}
    assert {name for name in found - shown if not {name, name.rpartition(".")[0]} & entries} == set()


def test_parameters_and_variables_have_tables_in_the_reference(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "docs")
    import hooks

    radius = "| `radius` | m | `0.01` | radius of each disc |"
    assert radius in hooks.tables_of("granular_env.components.discs.DiscsParameters")
    variables = hooks.tables_of("granular_env.components.discs.Discs")
    assert "| `force` | N | (8, 2) | force on each disc |" in variables and "| `link_broken` |" in variables
    assert hooks.tables_of("granular_env.components.component.Component") == ""


def test_every_entry_of_the_reference_exists():
    for entry in reference_entries():
        module, _, name = entry.rpartition(".")
        parent = importlib.import_module(module)
        assert hasattr(parent, name) or importlib.util.find_spec(entry) is not None, entry


def test_every_drawn_picture_has_a_twin_for_dark_pages():
    images = ROOT / "docs" / "images"
    screenshots = {"viewer", "viewer-cracks", "viewer-tube", "report"}
    drawn = [path for path in images.rglob("*.png") if path.stem not in screenshots and not path.stem.endswith("-dark")]
    assert len(drawn) > 15
    assert [path.name for path in drawn if not path.with_stem(f"{path.stem}-dark").exists()] == []


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    pytest.importorskip("mkdocstrings", reason="the site needs the extra 'docs'")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "-d", str(folder)]
    built = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr
    return folder


@pytest.mark.parametrize("word", ["open_log", "to_xarray", "VectorEnv", "Material", "licence"])
def test_the_search_finds_names(site, word):
    index = json.loads((site / "search" / "search_index.json").read_text())
    separator = re.compile(index["config"]["separator"])
    texts = (re.sub("<[^>]*>", " ", entry["title"] + " " + entry["text"]) for entry in index["docs"])
    terms = {term.lower() for text in texts for term in separator.split(text)}
    assert any(term.endswith(word.lower()) for term in terms)
    if word != "VectorEnv":
        assert word.lower() in terms


# The worker of the search takes a while to start, so the key is pressed again and again.
SEARCH = """
new Promise((done) => {
  const field = document.querySelector("[data-md-component=search-query]");
  field.focus();
  field.value = "WORD";
  const began = Date.now();
  const look = () => {
    field.dispatchEvent(new KeyboardEvent("keyup", { bubbles: true }));
    const found = [...document.querySelectorAll(".md-search-result__item")].map((item) => item.textContent);
    found.some((text) => text.includes("WORD")) || Date.now() - began > 10000 ? done(found) : setTimeout(look, 200);
  };
  look();
})
"""


def test_the_search_works_from_a_folder(site):
    if browser.found() is None:
        pytest.skip("no Chromium here")
    with browser.Browser() as opened:
        opened.open(site / "index.html")
        for word in ("open_log", "to_xarray", "ComponentVectorEnv"):
            assert any(word in item for item in opened.evaluate(SEARCH.replace("WORD", word))), word


def test_the_site_ships_no_scripts_of_python(site):
    assert [path.name for path in site.rglob("*.py")] == []


def test_formulas_are_typeset_and_no_code_is_cut_off(site):
    if browser.found() is None:
        pytest.skip("no Chromium here")
    with browser.Browser() as opened:
        for name in ("theory.html", "laws/elastic-plastic.html", "reference/runs.html"):
            for width in (1280, 390):
                opened.open(site / name, width=width)
                marked = opened.evaluate("document.querySelectorAll('.arithmatex').length")
                assert opened.evaluate("document.querySelectorAll('.arithmatex .katex').length") == marked
                assert opened.evaluate("document.querySelectorAll('.katex-error').length") == 0
                cut = "[...document.querySelectorAll('pre > code')].filter(c => c.scrollWidth > c.clientWidth + 1).length"
                assert opened.evaluate(cut) == 0, (name, width)
                assert opened.evaluate("document.documentElement.scrollWidth") <= width
                assert [address for address in opened.requests() if address.startswith("http")] == []
                assert opened.complaints() == []
        opened.open(site / "theory.html")
        displayed = (ROOT / "docs" / "theory.md").read_text().count("$$") // 2
        assert displayed > 0
        assert opened.evaluate("document.querySelectorAll('.katex-display').length") == displayed


def test_the_picture_of_the_architecture_is_that_of_the_import_contracts(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "docs")
    import architecture

    assert architecture.PICTURE.read_text() == architecture.picture(), "run python docs/architecture.py"
    shown = ElementTree.parse(architecture.PICTURE).getroot().iter(f"{architecture.SVG}text")
    names = {text.text for text in shown if text.get("class") == "name"}
    assert {"cli", "recording", "domains/chain", "contract", "chain"} <= names
