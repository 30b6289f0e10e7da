"""Which way imports point, what a component may know, and what a quick command must not load."""

import ast
import dataclasses
import graphlib
import re
import subprocess
import sys
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import grimp
import pytest

from granular_env.components import catalogue
from granular_env.components.component import Component
from granular_env.domains import DOMAINS

ROOT = Path(__file__).resolve().parent.parent
PUBLIC = (
    "Chain",
    "Component",
    "GranularError",
    "Material",
    "Profile",
    "Snapshot",
    "Variable",
    "make",
    "open_log",
    "record",
    "run",
    "verify",
)
HEAVY = ("gymnasium", "matplotlib", "numba", "rerun", "scipy", "xarray")


def python(code: str) -> str:
    result = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    return result.stdout


@cache
def tree_of(path: Path) -> ast.Module:
    """Return a file's syntax tree, parsed once for all tests; nobody changes it."""
    return ast.parse(path.read_text())


def test_the_import_contracts_hold():
    code = "import sys; from importlinter.cli import lint_imports; sys.exit(lint_imports(no_cache=True))"
    result = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert result.returncode == 0, result.stdout
    assert f"Contracts: {len(contracts())} kept, 0 broken." in result.stdout


def contracts() -> list[dict[str, Any]]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]


def parts_of(folder: Path) -> set[str]:
    """The packages and modules in a folder."""
    packages = {path.parent.name for path in folder.glob("*/__init__.py")}
    return packages | {path.stem for path in folder.glob("*.py")} - {"__init__", "__main__"}


def test_every_module_has_its_place_in_the_layers():
    layers = {one["containers"][0]: {*re.findall(r"\w+", " ".join(one["layers"]))} for one in contracts() if "layers" in one}
    # A room and the table of domains import each other: another contract keeps them apart.
    assert layers["granular_env"] == parts_of(ROOT / "granular_env") - {"domains"}
    assert layers["granular_env.components"] == parts_of(ROOT / "components")


def test_every_generic_room_is_kept_apart_from_the_domains():
    rooms = next(one["source_modules"] for one in contracts() if one["name"].startswith("Generic rooms"))
    assert {name.removeprefix("granular_env.") for name in rooms} == parts_of(ROOT / "granular_env") - {"domains"}


@pytest.mark.parametrize("name", catalogue.names())
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
        assert (offers.load(field.name) is None) == (getattr(offers, field.name) is None)
    assert domain in catalogue.names()


def test_only_components_and_domains_import_a_particular_component():
    """Whatever the catalogue holds: a generic room asks the catalogue, so that it serves every component alike."""
    graph = grimp.build_graph("granular_env", cache_dir=None)
    homes = {catalogue.component_class(name).__module__.split(".")[2] for name in catalogue.own_names()}
    assert {"chain", "discs", "oscillator"} <= homes
    for home in homes:
        system = f"granular_env.components.{home}"
        for module in {system, *graph.find_descendants(system)}:
            for importer in graph.find_modules_that_directly_import(module):
                assert importer.startswith(("granular_env.components.", "granular_env.domains.")), (
                    f"{importer} imports {module}"
                )


# -- circles ---------------------------------------------------------------------------------------------------------


def modules() -> dict[str, Path]:
    """All modules of the package by name; `components/` is a part of it."""
    parts = [("granular_env.components", ROOT / "components"), ("granular_env", ROOT / "granular_env")]
    found = {}
    for package, folder in parts:
        for path in sorted(folder.rglob("*.py")):
            inner = path.relative_to(folder).with_suffix("").parts
            if package != "granular_env" or inner[0] != "components":
                found[".".join([package, *inner]).removesuffix(".__init__")] = path
    return found


def imported_modules(name: str, path: Path, known: dict[str, Path]) -> set[str]:
    """The package's own modules that a module imports, at once or in its functions; not those for type checkers alone."""
    tree = tree_of(path)
    blocks = [node for node in ast.walk(tree) if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"]
    for_types = {id(node) for block in blocks for node in ast.walk(block)}
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and id(node) not in for_types:
            package = name.split(".") if path.name == "__init__.py" else name.split(".")[:-1]
            base = package[: len(package) - node.level + 1] if node.level else []
            origin = ".".join([*base, *([node.module] if node.module else [])])
            found |= {f"{origin}.{one.name}" if f"{origin}.{one.name}" in known else origin for one in node.names}
        elif isinstance(node, ast.Import):
            found |= {one.name for one in node.names}
    return found & known.keys() - {name}


def test_imports_make_no_circle_not_even_late_ones():
    known = modules()
    graph = {name: imported_modules(name, path, known) for name, path in known.items()}
    # Late ones are among them: the command line imports whatever is slow in its functions.
    assert sum(map(len, graph.values())) > 1500 and "granular_env.recording" in graph["granular_env.cli.logs"]
    graphlib.TopologicalSorter(graph).prepare()
