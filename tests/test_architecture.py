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
from support import scheduling

from granular_env.components import catalogue
from granular_env.components.chain.laws import LAWS
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


def imports(path: Path) -> list[ast.Import | ast.ImportFrom]:
    return [node for node in ast.walk(tree_of(path)) if isinstance(node, ast.Import | ast.ImportFrom)]


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


def absolute_imports(path: Path) -> list[str]:
    """Return the modules that a file imports by their whole name."""
    found = []
    for node in imports(path):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif node.level == 0:
            found.append(node.module or "")
    return found


def imports_any_of(path: Path, packages: set[str]) -> bool:
    return any(name.partition(".")[0] in packages for name in absolute_imports(path))


def test_components_import_each_other_relatively():
    files = sorted((ROOT / "components").rglob("*.py"))
    assert len(files) > 200
    assert not [path for path in files if imports_any_of(path, {"components", "granular_env"})]


def test_nobody_imports_components_by_its_folder():
    # A file is parsed only where the name stands as it does in an import: all of them would take seconds.
    named = re.compile(r"(?:from|import|,)\s+components\b")
    for folder in ("granular_env", "tests", "examples", "benchmarks"):
        for path in (ROOT / folder).rglob("*.py"):
            assert not (named.search(path.read_text()) and imports_any_of(path, {"components"})), path


def test_absolute_imports_are_found(tmp_path):
    path = tmp_path / "module.py"
    path.write_text("import os, components.chain\nfrom components import errors\nfrom .components import grid\n")
    assert absolute_imports(path) == ["os", "components.chain", "components"] and imports_any_of(path, {"components"})


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


def test_only_the_domains_name_a_physical_system():
    """The import contracts see imports; this sees names in strings too, but for those of the table."""
    systems = [*catalogue.names(), *DOMAINS]
    named = re.compile(
        rf"(domains|components)[./]({'|'.join(systems)})\b|from \.+(domains|components) import .*\b({'|'.join(systems)})\b"
    )
    package = ROOT / "granular_env"
    found = {
        str(path.relative_to(package))
        for path in [*package.rglob("*.py"), *package.rglob("*.pyi")]
        if "components" not in path.parts and named.search(path.read_text())
    }
    own = {name for name in found if name.split("/")[0] == "domains" and len(name.split("/")) > 2}
    # The table of domains, and the public names.
    assert found - own == {"domains/__init__.py", "__init__.pyi"}
    for name in own:
        others = {match[2] for match in named.finditer((package / name).read_text()) if match[1] == "domains"}
        assert others <= {name.split("/")[1]}, name


# The first system is the one whose words slip in.
CHAIN_WORD = re.compile(r"chains?|grains?|pistons?|nesterenko", re.IGNORECASE)
# "Such as" something; quoted names, keys and calls; an element of an array or of a list of what there may be.
EXAMPLE = re.compile(
    r"[Ss]uch as.*|granular-env run \S+|``?[^`]*``?|\"[\w./-]*\"|'[\w./-]*'|\w+\.\w+|\bgrain = \d+|\w+=|"
    r"\((ge\.\w+\()?chain\b|\(time, grain\)|\(grains, nodes, cells\)"
)


def slipped_words(text: str) -> list[str]:
    """The words of the chain in a line that give no example."""
    return [word for word in re.findall(r"[A-Za-z]+", EXAMPLE.sub("", text)) if CHAIN_WORD.fullmatch(word)]


def test_generic_rooms_speak_of_the_chain_in_examples_alone():
    assert slipped_words("The grains of the chain.") == ["grains", "chain"] and slipped_words("_GRAINS_ROW = 105") == ["GRAINS"]
    assert not slipped_words('such as {"component.grains": 5}')
    package = ROOT / "granular_env"
    rooms = [path for path in package.rglob("*.py") if path.relative_to(package).parts[0] not in ("components", "domains")]
    assert len(rooms) > 150
    found = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
        for path in rooms
        for number, line in enumerate(path.read_text().splitlines(), start=1)
        if slipped_words(line) and "itertools" not in line
    ]
    assert not found, "\n".join(found)


@pytest.mark.parametrize("domain", DOMAINS)
def test_everything_that_a_domain_offers_is_there(domain):
    offers = DOMAINS[domain]
    for field in dataclasses.fields(offers):
        assert (offers.load(field.name) is None) == (getattr(offers, field.name) is None)
    assert domain in catalogue.names()


@pytest.mark.parametrize("law", [law.__name__ for law in LAWS.values()])
def test_code_names_a_contact_law_in_its_file_the_table_and_the_parameters_alone(law):
    """Laws with the spring of another one take its functions, not its name."""
    folder = ROOT / "components" / "chain"
    found = {
        str(path.relative_to(folder))
        for path in folder.rglob("*.py")
        for node in ast.walk(tree_of(path))
        if law in (getattr(node, "id", ""), getattr(node, "attr", ""), getattr(node, "name", ""))
    }
    assert {"laws/__init__.py"} < found and len(found - {"laws/__init__.py", "parameters.py"}) == 1, found


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


# -- circles and docstrings -------------------------------------------------------------------------------------------


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


# Private names of packages, and of Python, for which there is no public one.
FOREIGN = {
    "_cache": "numba",
    "_compiler": "numba",
    "_definitions": "numba",
    "_rebuild": "numba",
    "_reduce": "numba",
    "_unique_ids": "numba's marker of a kernel, in the key of its cache",
    "_exit": "os",
    "_getframe": "sys",
    "_np_random_seed": "gymnasium",
}
# Public by their documentation: methods and attributes of every namedtuple.
NAMEDTUPLE = {"_asdict", "_field_defaults", "_fields", "_make", "_replace"}


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__") and name not in NAMEDTUPLE


def private_names(tree: ast.Module) -> set[str]:
    """The private names that a module defines: functions, classes, variables, and attributes of its classes' instances."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and is_own(node.value):
            found.add(node.attr)
    return {name for name in found if is_private(name)}


def is_own(value: ast.expr) -> bool:
    """Whether that is `self`, `cls` or `super()`, whose private members a method may use."""
    of_base = isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and value.func.id == "super"
    return of_base or (isinstance(value, ast.Name) and value.id in ("self", "cls"))


def classes_in(tree: ast.Module) -> list[ast.ClassDef]:
    return [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]


def foreign_privates(tree: ast.Module, homes: dict[str, list[ast.Module]]) -> list[tuple[int, str]]:
    """Line and name of each private member that a module uses and neither it nor a base of its classes defines."""
    own, seen, bases = private_names(tree), set(), classes_in(tree)
    while bases:
        for base in bases.pop().bases:
            name = ast.unparse(base).partition("[")[0].rpartition(".")[2]
            for home in homes.get(name, []) if name not in seen else []:
                own |= private_names(home)
                bases += [one for one in classes_in(home) if one.name == name]
            seen.add(name)
    read = [
        (node.lineno, node.attr)
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and is_private(node.attr) and not is_own(node.value) and node.attr not in own
    ]
    imported = [
        (node.lineno, alias.name)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if is_private(alias.name)
    ]
    return sorted(read + imported)


def test_no_module_uses_the_private_members_of_another():
    """But for those of base classes: whatever is used from outside has a public name, so that each class can change inside."""
    trees = {path: tree_of(path) for path in modules().values()}
    homes: dict[str, list[ast.Module]] = {}
    for tree in trees.values():
        for one in classes_in(tree):
            homes.setdefault(one.name, []).append(tree)
    found = [
        (name, f"{path.relative_to(ROOT)}:{line} uses {name}")
        for path, tree in trees.items()
        for line, name in foreign_privates(tree, homes)
    ]
    assert not [text for name, text in found if name not in FOREIGN]
    assert {name for name, _ in found} == FOREIGN.keys()


def test_the_rule_for_private_members_finds_them():
    base = ast.parse("class Base:\n    def _inner(self):\n        self._kept = 1")
    text = "from a import _b\nclass Own(Base):\n    def f(self, other):\n        self._any\n"
    text += "        other._inner()\n        other._far"
    assert foreign_privates(ast.parse(text), {"Base": [base]}) == [(1, "_b"), (6, "_far")]
    assert foreign_privates(ast.parse(text), {}) == [(1, "_b"), (5, "_inner"), (6, "_far")]


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


def test_docstrings_have_a_subject():
    """Functions begin with an imperative (ruff's D401 checks the rest), modules and classes with a noun."""
    headless = re.compile(r"(Of|What|Whether|Its|How|Where|Which|Who|When|From|By)\b")
    found = [
        f"{path.relative_to(ROOT)}: {text.splitlines()[0]}"
        for path in modules().values()
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
        and headless.match(text := ast.get_docstring(node) or "")
    ]
    assert not found


def test_hardly_any_function_is_named_by_a_participle():
    """A name is what a function does or gives; `told` or `warmed` says neither. Adjectives before a noun are no such names."""
    irregular = "told|written|made|given|held|drawn|seen|shown|built|kept|found|taken|driven|sent|sought|left|gone|met|lost"
    participle = re.compile(rf"_?(\w*[a-z]{{2}}ed|{irregular})")
    trees = [tree_of(path) for path in modules().values()]
    names = [node.name for tree in trees for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    found = [name for name in names if "_" not in name.strip("_") and participle.fullmatch(name)]
    assert len(names) > 3000 and len(found) <= 0.015 * len(names), found


def test_files_that_are_scheduled_by_name_exist():
    """The order of test files in `make test`; see `support.scheduling`."""
    names = {path.name for path in (ROOT / "tests").glob("test_*.py")}
    assert set(scheduling.LONG) <= names and len(set(scheduling.LONG)) == len(scheduling.LONG)
    for kind in (scheduling.CHAIN, scheduling.BODIES):
        for prefix in kind.pattern.removeprefix("test_(").removesuffix(")").split("|"):
            assert any(name.startswith(f"test_{prefix}") for name in names), prefix
    own, other = scheduling.CHAIN, scheduling.BODIES
    order = [f"tests/test_{name}.py" for name in ("chain_adjoint", "chain_bits", "envs", "run", "cli", "progress", "grid")]
    assert sorted(reversed(order), key=lambda path: scheduling.rank(path, own, other)) == order
