"""The documentation site: a build without warnings, typeset formulas, resolved names, and all public names."""

import importlib
import importlib.util
import re
import subprocess
import sys
from pathlib import Path
from types import FunctionType
from typing import Any, get_args

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
PUBLIC_PACKAGES = (ge, envs, recording, sweep, viewing, chain, chain.control, chain.measurement)
ENTRY = re.compile(r"^::: (\S+)$", re.MULTILINE)


def reference_entries() -> set[str]:
    return {entry for page in (ROOT / "docs" / "reference").glob("*.md") for entry in ENTRY.findall(page.read_text())}


def parameter_classes(model: type[BaseModel]) -> set[type[BaseModel]]:
    """Yield a parameter model and the models that its fields may hold: parts, and tables chosen by a name."""
    found = {model}
    for field in model.model_fields.values():
        kinds = {one for one in (field.annotation, *get_args(field.annotation)) if isinstance(one, type)}
        inner = kinds.union(*(mark.choices.values() for mark in field.metadata if isinstance(mark, Choices)))
        found.update(*(parameter_classes(kind) for kind in inner - found if issubclass(kind, BaseModel)))
    return found


def public_objects() -> set[str]:
    """Return the definitions of all user-visible names: public names, components, and parameter types."""
    components = [catalogue.component_class(name) for name in catalogue.built_in_names()]
    things = {Observer, *components}.union(*(parameter_classes(one.Parameters) for one in components))
    things |= {getattr(package, name) for package in PUBLIC_PACKAGES for name in package.__all__}
    return {where_defined(one) for one in things if isinstance(one, type | FunctionType)}


def where_defined(thing: Any) -> str:
    return f"{getattr(thing, '__module__', '')}.{getattr(thing, '__qualname__', '')}"


def test_every_public_name_is_in_the_reference():
    entries, found = reference_entries(), public_objects()
    assert len(found) > 150 and {"granular_env.components.chain.laws.hertz.Hertz", "granular_env.envs.task.Task"} <= found
    # An entry is a module, or a package with its exports.
    packages = [package for package in PUBLIC_PACKAGES if package.__name__ in entries]
    shown = {where_defined(getattr(package, name)) for package in packages for name in package.__all__}
    assert {name for name in found - shown if not {name, name.rpartition(".")[0]} & entries} == set()


def test_every_entry_of_the_reference_exists():
    for entry in reference_entries():
        module, _, name = entry.rpartition(".")
        parent = importlib.import_module(module)
        assert hasattr(parent, name) or importlib.util.find_spec(entry) is not None, entry


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    pytest.importorskip("mkdocstrings", reason="the site needs the extra 'docs'")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "-d", str(folder)]
    built = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr
    return folder


def test_the_site_ships_no_scripts_of_python(site):
    assert [path.name for path in site.rglob("*.py")] == []


def test_formulas_are_typeset_and_no_code_is_cut_off(site):
    if browser.find_browser() is None:
        pytest.skip("no Chromium here")
    with browser.Browser() as opened:
        for name in ("theory.html", "laws.html", "reference/runs.html"):
            for width in (1280, 390):
                opened.open_page(site / name, width=width)
                marked = opened.evaluate_script("document.querySelectorAll('.arithmatex').length")
                assert opened.evaluate_script("document.querySelectorAll('.arithmatex .katex').length") == marked
                assert opened.evaluate_script("document.querySelectorAll('.katex-error').length") == 0
                cut = "[...document.querySelectorAll('pre > code')].filter(c => c.scrollWidth > c.clientWidth + 1).length"
                assert opened.evaluate_script(cut) == 0, (name, width)
                assert opened.evaluate_script("document.documentElement.scrollWidth") <= width
                assert [address for address in opened.requested_addresses() if address.startswith("http")] == []
                assert opened.console_errors() == []
        opened.open_page(site / "theory.html")
        displayed = (ROOT / "docs" / "theory.md").read_text().count("$$") // 2
        assert displayed > 0
        assert opened.evaluate_script("document.querySelectorAll('.katex-display').length") == displayed
