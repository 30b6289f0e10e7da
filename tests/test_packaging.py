"""Wheel, source distribution and editable install: all three hold the components and the experiment files."""

import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
ASIDE = shutil.ignore_patterns(
    ".git", ".venv", "build", "dist", "site", "logs", "*.egg-info", "__pycache__", ".*_cache", ".hypothesis"
)
DATA = {".py", ".pyi", ".toml", ".csv", ".typed", ".json", ".html", ".css"}


def build(kind: str, tree: Path, out: Path) -> Path:
    """Build with the backend's hook, without network and isolated environment."""
    out.mkdir(exist_ok=True)
    hook = f"from setuptools import build_meta; print(build_meta.build_{kind}({str(out)!r}))"
    result = subprocess.run([sys.executable, "-c", hook], cwd=tree, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    return out / result.stdout.splitlines()[-1]


def python(code: str, *places: Path, cwd: Path) -> str:
    """Run code in a process with access to the libraries and `places`, but not to the repository or PYTHONPATH."""
    prelude = f"import sys, site; sys.path[:] = [p for p in sys.path if p != {str(ROOT)!r}]\n"
    prelude += "sys.meta_path[:] = [f for f in sys.meta_path if 'editable' not in getattr(f, '__name__', '').lower()]\n"
    prelude += "[sys.modules.pop(name) for name in list(sys.modules) if name.startswith('__editable__')]\n"
    prelude += "".join(f"sys.path.insert(0, {str(place)!r}); site.addsitedir({str(place)!r})\n" for place in places)
    result = subprocess.run([sys.executable, "-I", "-c", prelude + code], cwd=cwd, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    return result.stdout.strip()


def expected_files() -> set[str]:
    """Return all modules and data files of the package, components by their import path."""
    own = {path for path in (ROOT / "granular_env").rglob("*") if "components" not in path.relative_to(ROOT).parts}
    names = {str(path.relative_to(ROOT)) for path in own if path.suffix in DATA}
    names |= {f"granular_env/{path.relative_to(ROOT)}" for path in (ROOT / "components").rglob("*") if path.suffix in DATA}
    return names


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    copy = tmp_path_factory.mktemp("tree") / "granular-env"
    shutil.copytree(ROOT, copy, symlinks=True, ignore=ASIDE)
    return copy


@pytest.fixture(scope="module")
def wheel(tree, tmp_path_factory):
    return build("wheel", tree, tmp_path_factory.mktemp("wheel"))


def test_components_is_one_symlink():
    link = ROOT / "granular_env" / "components"
    assert link.is_symlink() and link.readlink() == Path("../components")


def test_the_wheel_holds_every_module_and_data_file(wheel):
    packed = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    assert packed == expected_files()


def test_the_source_distribution_builds_the_same_wheel(tree, wheel, tmp_path):
    with tarfile.open(build("sdist", tree, tmp_path / "sdist")) as archive:
        # The filter exists since Python 3.11.4; the archive is trusted.
        archive.extractall(tmp_path, **({"filter": "data"} if hasattr(tarfile, "data_filter") else {}))
    [source] = tmp_path.glob("granular_env-*")
    again = build("wheel", source, tmp_path / "again")
    assert sorted(zipfile.ZipFile(again).namelist()) == sorted(zipfile.ZipFile(wheel).namelist())


def test_an_installed_wheel_steps_a_component_and_finds_its_experiments(wheel, tmp_path):
    place = tmp_path / "site"
    zipfile.ZipFile(wheel).extractall(place)
    code = (
        "import granular_env as ge; oscillator = ge.make('oscillator'); oscillator.step(0.02)\n"
        "from granular_env.experiments import shipped_experiments\n"
        "print(ge.__file__, oscillator.tick, 'nesterenko-1983/3.4-piston' in shipped_experiments())"
    )
    assert python(code, place, cwd=tmp_path) == f"{place}/granular_env/__init__.py 2 True"


def test_an_editable_install_follows_the_tree(tree, tmp_path):
    place = tmp_path / "site"
    zipfile.ZipFile(build("editable", tree, tmp_path / "editable")).extractall(place)
    code = "import granular_env.components.oscillator as module; print(module.__file__)"
    assert python(code, place, cwd=tmp_path) == f"{tree}/granular_env/components/oscillator.py"


def test_the_wheel_declares_the_command_and_the_extras(wheel):
    archive = zipfile.ZipFile(wheel)
    [entry_points] = [name for name in archive.namelist() if name.endswith("entry_points.txt")]
    [metadata] = [name for name in archive.namelist() if name.endswith("METADATA")]
    assert "granular-env = granular_env.cli:main" in archive.read(entry_points).decode()
    text = archive.read(metadata).decode()
    assert all(f"Provides-Extra: {extra}\n" in text for extra in ("view", "data", "test", "docs", "dev"))


def test_every_direct_dependency_is_pinned_without_an_address():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    wanted = [*project["dependencies"], *(line for lines in project["optional-dependencies"].values() for line in lines)]
    pins = [line for line in (ROOT / "constraints.txt").read_text().splitlines() if not line.startswith("#")]
    pinned = {line.partition("==")[0].lower().replace("_", "-") for line in pins}
    names = {line.split(">")[0].split("[")[0] for line in wanted} - {"granular-env"}
    assert names - pinned == {"setuptools"}  # a build tool that is not pinned
    assert not [line for line in pins if "/" in line or "@" in line or "==" not in line]
