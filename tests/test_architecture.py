"""Directions of imports, permitted imports of components, and packages that quick commands must not load."""

import dataclasses
import graphlib
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import grimp
import pytest

from granular_env.components import catalogue
from granular_env.components.component import Component
from granular_env.domains import DOMAINS

ROOT = Path(__file__).resolve().parent.parent
PUBLIC = "Chain Component GranularError Material Profile Snapshot Variable make open_log record run verify".split()
HEAVY = ("gymnasium", "matplotlib", "numba", "rerun", "scipy", "xarray")


def python(code: str) -> str:
    result = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_the_import_contracts_hold():
    code = "import sys; from importlinter.cli import lint_imports; sys.exit(lint_imports(no_cache=True))"
    result = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert result.returncode == 0, result.stdout
    assert f"Contracts: {len(contracts())} kept, 0 broken." in result.stdout


def contracts() -> list[dict[str, Any]]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]


def parts_of(folder: Path) -> set[str]:
    """Return the packages and modules in a folder."""
    packages = {path.parent.name for path in folder.glob("*/__init__.py")}
    return packages | {path.stem for path in folder.glob("*.py")} - {"__init__", "__main__"}


def test_every_module_has_its_place_in_the_layers():
    layers = {one["containers"][0]: {*re.findall(r"\w+", " ".join(one["layers"]))} for one in contracts() if "layers" in one}
    # The generic packages and the table of domains import each other; another contract separates them.
    assert layers["granular_env"] == parts_of(ROOT / "granular_env") - {"domains"}
    assert layers["granular_env.components"] == parts_of(ROOT / "components")


def test_every_generic_room_is_kept_apart_from_the_domains():
    rooms = next(one["source_modules"] for one in contracts() if one["name"].startswith("Generic rooms"))
    assert {name.removeprefix("granular_env.") for name in rooms} == parts_of(ROOT / "granular_env") - {"domains"}


@pytest.mark.parametrize("name", catalogue.component_names())
def test_every_catalogue_name_leads_to_a_component_of_that_name(name):
    found = catalogue.component_class(name)
    assert issubclass(found, Component) and found.name == name


def test_importing_the_package_or_asking_for_help_loads_nothing_heavy():
    code = (
        "import sys, contextlib, io\nimport granular_env\nfrom granular_env.cli import main\n"
        "with contextlib.redirect_stdout(io.StringIO()) as text:\n    main(['--help'])\n"
        "assert 'COMMAND' in text.getvalue()\n"
        f"print([name for name in {HEAVY} if name in sys.modules])"
    )
    assert python(code).strip() == "[]"


def test_public_names_stay_what_they_are_whatever_is_imported():
    code = (
        "import contextlib, pkgutil, importlib, types\nimport granular_env as ge\n"
        f"names = {PUBLIC}\n"
        "before = [getattr(ge, name) for name in names]\n"
        "for found in pkgutil.walk_packages(ge.__path__, 'granular_env.'):\n"
        "    if not found.name.endswith('__main__'):\n"
        "        with contextlib.suppress(ge.MissingExtraError):\n            importlib.import_module(found.name)\n"
        "print([name for name, one in zip(names, before) if getattr(ge, name) is not one or isinstance(one, types.ModuleType)])"
    )
    assert python(code).strip() == "[]"


def test_components_step_without_a_gym_a_log_or_a_viewer():
    code = (
        "import sys\nfrom granular_env.components.catalogue import make\nmake('chain', grains=3).step()\n"
        "print([name for name in ('gymnasium', 'mcap', 'rerun', 'matplotlib', 'rich') if name in sys.modules])"
    )
    assert python(code).strip() == "[]"


@pytest.mark.parametrize("domain", DOMAINS)
def test_everything_that_a_domain_offers_is_there(domain):
    offers = DOMAINS[domain]
    for field in dataclasses.fields(offers):
        assert (offers.load_attribute(field.name) is None) == (getattr(offers, field.name) is None)
    assert domain in catalogue.component_names()


def test_only_components_and_domains_import_a_particular_component():
    """For all components: a generic package uses the catalogue, so that it serves every component alike."""
    graph = grimp.build_graph("granular_env", cache_dir=None)
    homes = {catalogue.component_class(name).__module__.split(".")[2] for name in catalogue.built_in_names()}
    assert {"chain", "discs", "oscillator"} <= homes
    for home in homes:
        system = f"granular_env.components.{home}"
        for module in {system, *graph.find_descendants(system)}:
            for importer in graph.find_modules_that_directly_import(module):
                assert importer.startswith(("granular_env.components.", "granular_env.domains.")), (
                    f"{importer} imports {module}"
                )


def test_imports_make_no_circle_not_even_late_ones():
    graph = grimp.build_graph("granular_env", exclude_type_checking_imports=True, cache_dir=None)
    imported = {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    # The command line imports the recording package inside functions.
    assert "granular_env.recording" in imported["granular_env.cli.logs"]
    graphlib.TopologicalSorter(imported).prepare()
