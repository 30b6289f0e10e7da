"""Compiled functions on disk: never stale, never in the way, never silent for long."""

from __future__ import annotations

import enum
import os
import re
import resource
import subprocess
import sys
import tempfile
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from numba.core import config as numba_config
from support.forked import run_forked

from granular_env.components.detonation.kernels import advance, flow
from granular_env.components.errors import ParameterError
from granular_env.components.support.addresses import address
from granular_env.components.support.compilation import kernel_cache
from granular_env.components.support.compilation.cache_folder import cache_base, cache_folder
from granular_env.components.support.compilation.fingerprint import fingerprint
from granular_env.components.support.jit import JIT, entry_point, internal, jit

pytestmark = pytest.mark.skipif(not JIT, reason="nothing is compiled")
ROOT = Path(__file__).resolve().parents[1]


def run(
    code: str, folder: Path, *, cache: Path | None = None, fresh: bool = False, **options: Any
) -> subprocess.CompletedProcess[str]:
    """Run Python there, with a cache of its own beside it.

    Args:
        code: what to run.
        folder: the current one.
        cache: where kernels are kept.
        fresh: whether a new interpreter runs it, which hashes texts in a way of its own; a forked process is sooner there.
        **options: of `subprocess.run`, for a new interpreter.
    """
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(folder), str(ROOT)]), "PYTHONDONTWRITEBYTECODE": "1"}
    environment["GRANULAR_ENV_CACHE"] = str(cache or folder / "cache")
    environment.update(options.pop("environment", {}))
    if fresh or options:
        command = [sys.executable, "-c", code]
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300, **options)
    else:
        with tempfile.TemporaryDirectory() as files:
            done = run_forked(code, folder, environment, Path(files))
    assert done.returncode == 0, done.stderr
    return done


def test_kernels_of_the_package_are_kept_on_disk() -> None:
    """Those with an entry from Python, and those that only kernels call; see `code_libraries`."""
    for kernel in (advance, flow):
        assert fingerprint(kernel).unknown is None
        assert fingerprint(kernel).key == fingerprint(kernel).key is not None


def write(folder: Path, files: dict[str, str]) -> None:
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


# -- never stale --------------------------------------------------------------------------------------------------------

HELPER = "from granular_env.components.support.jit import jit\nK = {k}\n@jit\ndef price(x): return {k} * x\n"
TASK = """
import os
from granular_env.components.support.jit import jit
from granular_env.components.chain.layout import V
{imports}
@jit
def judge(x):
    return {expression}
"""
# What the task imports and refers to, where task and helper lie, in places where research code lies.
LAYOUTS = {
    "folder_constant": ("from folder_constant.helper import K", "K", "folder_constant/task.py", "folder_constant/helper.py"),
    "folder_function": (
        "from folder_function.helper import price", "price(x)", "folder_function/task.py", "folder_function/helper.py",
    ),
    "module_attribute": ("import module_helper as h", "h.K * x", "module_task.py", "module_helper.py"),
    "package": ("from .helper import price", "price(x)", "p/task.py", "p/helper.py"),
    "subpackage": ("from ..helper import price", "price(x)", "q/tasks/task.py", "q/helper.py"),
    "other_package": ("from s.helper import price", "price(x)", "r/task.py", "s/helper.py"),
    "numbas_own_cache": (
        "import numba\nfrom cached_helper import K\n@numba.njit(cache=True)\ndef inner(x): return K * x", "inner(x)",
        "cached_task.py", "cached_helper.py",
    ),
    "through_another": (
        "from middle import price as K\n@jit\ndef outer(x): return K(x)", "outer(x)", "through.py", "far_helper.py",
    ),
}  # fmt: skip


def test_an_edit_of_whatever_a_kernel_refers_to_is_noticed(tmp_path: Path) -> None:
    packages = {f"{name}/__init__.py": "" for name in ("p", "q", "q/tasks", "r", "s")}
    tasks = {where: TASK.format(imports=imports, expression=said) for imports, said, where, _ in LAYOUTS.values()}
    write(tmp_path, packages | tasks | {"middle.py": "from far_helper import price\n"})
    modules = [where.removesuffix(".py").replace("/", ".") for _, _, where, _ in LAYOUTS.values()]
    code = f"import importlib\nprint(*(importlib.import_module(m).judge(1.0) for m in {modules}))"
    for k in (3.0, 4.0, 3.0):
        write(tmp_path, {helper: HELPER.format(k=k) for *_, helper in LAYOUTS.values()})
        assert run(code, tmp_path, fresh=True).stdout.split() == [str(k)] * len(LAYOUTS)


def test_a_value_that_is_in_no_source_is_noticed_over_processes(tmp_path: Path) -> None:
    write(tmp_path, {"task.py": TASK.format(imports="K = float(os.environ['K'])", expression="K * x")})
    said = [run("import task; print(task.judge(1.0))", tmp_path, environment={"K": k}).stdout.strip() for k in "353"]
    assert said == ["3.0", "5.0", "3.0"]
    assert len(list((tmp_path / "cache" / "kernels").glob("task.judge-*.kernel"))) == 2


OBJECTIVE = """
from weights import W
import numpy as np
from granular_env import Chain
from granular_env.components.support.jit import jit
from granular_env.components.chain.layout import V
from granular_env.domains.chain.control import Objective, value_and_grad
@jit
def note(a, step, steps, inputs, constants, sums): sums[0] += W * a[V, 1]
@jit
def value(sums, constants, slopes): slopes[0] = 1.0; return sums[0]
@jit
def pull(a, bar, step, steps, inputs, input_bar, constants, slopes): bar[V, 1] += slopes[0] * W
chain = Chain(grains=6, radius=3e-3, step_size=5e-7)
value, slopes = value_and_grad(Objective(note, value, pull), chain, np.full((20, 2), 50.0), ticks=3)
print(value, slopes["drive"][0, 0])
"""


@pytest.mark.parametrize("made_by", ["jit", "numba.njit(cache=True)"])
def test_an_objective_is_compiled_anew_for_another_weight(made_by: str, tmp_path: Path) -> None:
    """Twice the weight is twice the value and twice the slope, to the last bit. The package's own kernels are not compiled."""
    cache = cache_base()
    said = []
    for weight in ("1.0", "2.0"):
        text = OBJECTIVE.replace("@jit", f"@{made_by}")
        write(tmp_path, {"weights.py": f"W = {weight}\n", "objective.py": f"import numba\n{text}"})
        said.append([float(number) for number in run("import objective", tmp_path, cache=cache).stdout.split()])
    assert said[1] == [2.0 * number for number in said[0]]


def test_like_functions_of_two_processes_stay_apart_in_a_third(tmp_path: Path) -> None:
    """Both are on disk under the same name; a call that is not inlined must go to the right one."""
    text = "K = float(os.environ['K'])\n@jit\ndef last(x):\n    if x < 0.5:\n        return K\n    return last(x - 1.0) + 0.0"
    write(tmp_path, {"task.py": TASK.format(imports=text, expression="last(x) + 0.0")})
    for k in "35":
        run("import task; task.judge(1.0)", tmp_path, environment={"K": k})
    both = (
        "import importlib, os, task; one = task.judge; print(one(1.0)); os.environ['K'] = '5'; importlib.reload(task)\n"
        "print(task.judge(1.0), sum(task.judge.stats.cache_hits.values()))"
    )
    assert run(both, tmp_path, environment={"K": "3"}).stdout.split() == ["3.0", "5.0", "1"]


def test_intermediate_code_is_read_from_disk_into_another_caller(tmp_path: Path) -> None:
    text = "from granular_env.components.support.jit import internal, jit\n@internal\ndef inner(x):\n    return 2.0 * x\n"
    callers = "@jit\ndef first(x):\n    return inner(x)\n@jit\ndef second(x):\n    return inner(x) + 1.0\n"
    write(tmp_path, {"called.py": text + callers})
    run("import called; called.first(1.0)", tmp_path)
    again = run("import called; print(called.second(1.0), sum(called.inner.stats.cache_hits.values()))", tmp_path)
    assert again.stdout.split() == ["3.0", "1"]


class Level(enum.IntEnum):
    """A global of the functions below."""

    LOW = 1


WEIGHT, TABLE, LEVEL = 3.0, np.array([1.0, 2.0]), Level.LOW
SPACE = types.ModuleType("space")
SPACE.WEIGHT, SPACE.inner = 3.0, types.ModuleType("inner")  # type: ignore[attr-defined]
SPACE.inner.WEIGHT = 3.0  # type: ignore[attr-defined]


@jit
def _called(x):  # noqa: ANN001, ANN202
    return WEIGHT * x


CASES: dict[str, tuple[Callable[..., Any], Callable[[pytest.MonkeyPatch], None]]] = {
    "number": (lambda x: WEIGHT * x, lambda patch: patch.setitem(globals(), "WEIGHT", 4.0)),
    "type": (lambda x: WEIGHT * x, lambda patch: patch.setitem(globals(), "WEIGHT", 3)),
    "called": (lambda x: _called(x), lambda patch: patch.setitem(globals(), "WEIGHT", 4.0)),
    "array": (lambda x: TABLE[0] * x, lambda patch: patch.setitem(globals(), "TABLE", np.array([1.0, 3.0]))),
    "array of another kind": (lambda x: TABLE[0] * x, lambda patch: patch.setitem(globals(), "TABLE", np.array([1, 2]))),
    "enum": (lambda x: LEVEL * x, lambda patch: patch.setitem(globals(), "LEVEL", 2)),
    "attribute": (lambda x: SPACE.WEIGHT * x, lambda patch: patch.setattr(SPACE, "WEIGHT", 4.0)),  # type: ignore[attr-defined]
    "inner attribute": (
        lambda x: SPACE.inner.WEIGHT * x,  # type: ignore[attr-defined]
        lambda patch: patch.setattr(SPACE.inner, "WEIGHT", 4.0),  # type: ignore[attr-defined]
    ),
    "builtin": (lambda x: abs(x), lambda patch: patch.setitem(globals(), "abs", jit(lambda x: x))),
    "bounds": (lambda x: x, lambda patch: patch.setattr(numba_config, "BOUNDSCHECK", 1)),
}


@pytest.mark.parametrize("name", CASES)
def test_the_fingerprint_follows_what_machine_code_is_made_from(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    function, change = CASES[name]
    compiled = jit(function)
    before = fingerprint(compiled)
    assert before.key is not None and fingerprint(compiled).key == before.key
    change(monkeypatch)
    assert fingerprint(compiled).key != before.key


def test_kernels_of_either_kind_are_kept_and_told_apart() -> None:
    keys = [fingerprint(make(lambda x: x)).key for make in (jit, internal)]
    assert None not in keys and keys[0] != keys[1]


def test_enclosed_values_defaults_and_constants_tell_functions_apart() -> None:
    def enclose(weight: Any) -> Any:
        return jit(lambda x: weight * x)

    def default(weight: Any) -> Any:
        return jit(eval(f"lambda x, y={weight}: x * y"))

    def constant(weight: Any) -> Any:
        return jit(eval(f"lambda x: x * {weight}"))

    for make in (enclose, default, constant):
        keys = [fingerprint(make(weight)).key for weight in (1.0, 2.0, 1, 1.0)]
        assert len(set(keys)) == 3 and keys[0] == keys[3] and None not in keys


def test_what_has_no_fingerprint_is_compiled_but_not_kept(tmp_path: Path) -> None:
    """A plain function that numba was taught another body for tells nothing about that body."""
    text = """
from numba.extending import overload
def foreign(x): ...
@overload(foreign)
def _(x): return lambda x: {k} * x
"""
    for k in (3.0, 4.0):
        write(tmp_path, {"task.py": TASK.format(imports=text.format(k=k), expression="foreign(x)")})
        assert run("import task; print(task.judge(1.0))", tmp_path).stdout.strip() == str(k)
    assert not list((tmp_path / "cache" / "kernels").glob("task.judge-*"))


@pytest.mark.parametrize("look_up", [entry_point, address])
def test_another_value_of_a_global_in_one_process_is_refused_by_name(
    look_up: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    inner = jit(lambda x: WEIGHT * x)
    outer = jit(lambda x: inner(x) + 1.0)
    look_up(outer, "float64(float64)")
    monkeypatch.setitem(globals(), "WEIGHT", 3.0)  # the same value in another object
    look_up(outer, "float64(float64)")
    monkeypatch.setitem(globals(), "WEIGHT", 5.0)
    with pytest.raises(ParameterError, match="WEIGHT has another value than when"):
        look_up(outer, "float64(float64)")
    with pytest.raises(ParameterError, match="WEIGHT has another value than when"):
        look_up(jit(lambda x: inner(x) + 2.0), "float64(float64)")
    assert look_up(jit(lambda x: WEIGHT * x), "float64(float64)") is not None


INNER = jit(lambda x: WEIGHT * x)
BOTH = (INNER, INNER)
NESTED = (1.0, (INNER,))
ARRAYS = (np.array([1.0, 2.0]),)


def _of_module(space: Any) -> Any:
    return jit(lambda x: space.WEIGHT * x)


KEPT: dict[str, tuple[Callable[[], Any], Callable[[pytest.MonkeyPatch], None]]] = {
    "enclosed module": (lambda: _of_module(SPACE), lambda patch: patch.setattr(SPACE, "WEIGHT", 6.0)),  # type: ignore[attr-defined]
    "tuple of functions": (lambda: jit(lambda x: BOTH[0](x)), lambda patch: patch.setitem(globals(), "WEIGHT", 6.0)),
    "inner tuple": (lambda: jit(lambda x: NESTED[1][0](x)), lambda patch: patch.setitem(globals(), "WEIGHT", 6.0)),
    "array in a tuple": (lambda: jit(lambda x: ARRAYS[0][1] * x), lambda patch: ARRAYS[0].__setitem__(1, ARRAYS[0][1] + 1.0)),
    "function of numba": (lambda: numba.njit(lambda x: WEIGHT * x), lambda patch: patch.setitem(globals(), "WEIGHT", 6.0)),
}


@pytest.mark.parametrize("look_up", [entry_point, address])
@pytest.mark.parametrize("name", KEPT)
def test_what_is_reached_in_another_way_is_refused_too(
    name: str, look_up: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    make, change = KEPT[name]
    function = make()
    look_up(function, "float64(float64)")
    look_up(function, "float64(float64)")
    change(monkeypatch)
    with pytest.raises(ParameterError, match="has another value than when"):
        look_up(function, "float64(float64)")


def test_kernels_of_numbas_own_cache_are_never_stale(tmp_path: Path) -> None:
    """Neither after an edit of what they refer to, nor for a value that is in no source; and they are kept here."""
    text = """
import os, numba
from helper import K
from granular_env.components.support.addresses import address, caller
from granular_env.components.support.jit import jit
W = float(os.environ["W"])
@numba.njit(cache=True)
def judge(x): return K * W * x
judge(1.0)
call = caller("float64(float64)")
@jit
def run(where): return call(where, (1.0,))
print(run(address(judge, "float64(float64)")))
"""
    write(tmp_path, {"task.py": text})
    said = []
    for k, weight in (("3.0", "1"), ("4.0", "1"), ("4.0", "2"), ("3.0", "1")):
        write(tmp_path, {"helper.py": f"K = {k}\n"})
        said.append(run("import task", tmp_path, environment={"W": weight}).stdout.split()[-1])
    assert said == ["3.0", "4.0", "8.0", "3.0"]
    assert len(list((tmp_path / "cache" / "kernels").glob("task.judge-*.kernel"))) == 3


def test_what_was_compiled_before_with_unknown_values_is_not_kept(tmp_path: Path) -> None:
    """A function of numba's own that has run already may have frozen another value than its global has now."""
    text = "import numba\nK = 3.0\n@numba.njit\ndef inner(x): return K * x\ninner(1.0)\nK = float(os.environ['K'])"
    write(tmp_path, {"task.py": TASK.format(imports=text, expression="inner(x)")})
    run("import task; task.judge(1.0); print(task.jit(lambda x: task.inner(x) + 1.0)(1.0))", tmp_path, environment={"K": "5"})
    assert not list((tmp_path / "cache" / "kernels").glob("*.kernel"))


# -- never in the way ---------------------------------------------------------------------------------------------------

SMALL = "from granular_env.components.support.powers import power; print(power(2.0, 0.5))"


def kernels(folder: Path) -> list[Path]:
    return sorted((folder / "cache" / "kernels").glob("*.kernel"))


def test_damaged_files_are_replaced(tmp_path: Path) -> None:
    right = run(SMALL, tmp_path).stdout
    damages: list[Callable[[bytes], bytes]] = [
        lambda data: b"", lambda data: data[:20], lambda data: data[: len(data) // 2], lambda data: data[:-1],
        lambda data: bytes(len(data)), lambda data: data[:-1] + bytes([data[-1] ^ 1]),
    ]  # fmt: skip
    assert len(kernels(tmp_path)) == 3
    for three in (damages[:3], damages[3:]):
        # What a kernel calls is read only where the kernel itself is compiled: damage all of them.
        for path, damage in zip(kernels(tmp_path), three, strict=True):
            path.write_bytes(damage(path.read_bytes()))
        assert run(SMALL, tmp_path).stdout == right
        assert min(path.stat().st_size for path in kernels(tmp_path)) > 1000


def test_a_full_disk_is_said_once_and_stops_nothing(tmp_path: Path) -> None:
    """No file may become larger than 1 kB: the kernel's way of a full disk that a test can have."""
    limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))  # noqa: E731
    done = run(SMALL, tmp_path, preexec_fn=limit, environment={"GRANULAR_ENV_QUIET": ""})
    assert done.stdout == run(SMALL, tmp_path).stdout
    assert done.stderr.count("cannot be kept in") == 1 and "File too large" in done.stderr
    assert not [path for path in (tmp_path / "cache" / "kernels").iterdir() if path.name.startswith(".part")]


@pytest.fixture
def fresh(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The cache's folder is looked for anew."""
    monkeypatch.setenv("GRANULAR_ENV_QUIET", "")
    cache_folder.cache_clear()
    yield
    cache_folder.cache_clear()


@pytest.mark.usefixtures("fresh")
def test_without_a_home_nothing_is_kept_and_it_is_said(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def no_home() -> Path:
        raise RuntimeError("Could not determine home directory.")

    for name in ("GRANULAR_ENV_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", no_home)
    assert cache_folder() is None
    assert "Could not determine home directory" in capsys.readouterr().err


@pytest.mark.usefixtures("fresh")
def test_a_folder_that_others_may_write_to_is_not_trusted(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("GRANULAR_ENV_CACHE", str(tmp_path / "own"))
    before = os.umask(0)
    try:
        folder = cache_folder()
    finally:
        os.umask(before)
    assert folder is not None and folder.stat().st_mode & 0o777 == 0o700
    for path in (folder, folder.parent):
        cache_folder.cache_clear()
        path.chmod(0o777)
        assert cache_folder() is None
        assert str(path) in capsys.readouterr().err
        path.chmod(0o700)


def test_the_cache_forgets_what_was_not_used_for_longest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for age in range(4):
        path = tmp_path / str(age)
        path.write_bytes(bytes(10))
        os.utime(path, (1000 - age, 1000 - age))
    monkeypatch.setattr(kernel_cache, "_LARGEST_CACHE", 25)
    kernel_cache._forget_oldest(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["0", "1"]


# -- never silent for long ----------------------------------------------------------------------------------------------


def test_the_first_compilation_speaks_once_and_a_warm_cache_never(tmp_path: Path) -> None:
    loud = {"GRANULAR_ENV_QUIET": "0"}
    first = run(SMALL, tmp_path, environment=loud, fresh=True)
    assert re.fullmatch(r"granular-env: compiling .* about \d+ s of one core, once; kept in .*kernels\n", first.stderr)
    assert str(tmp_path / "cache" / "kernels") in first.stderr
    assert first.stdout == "1.414213562373095\n"
    again = run(SMALL, tmp_path, environment=loud, fresh=True)
    assert (again.stdout, again.stderr) == (first.stdout, "")


def test_the_quiet_switch_hides_it(tmp_path: Path) -> None:
    assert run(SMALL, tmp_path, environment={"GRANULAR_ENV_QUIET": "1"}).stderr == ""


def test_of_many_processes_one_speaks(tmp_path: Path) -> None:
    """The first one is still there when the second compiles for other types."""
    code = (
        "import subprocess, sys\nfrom granular_env.components.support.powers import power\npower(2.0, 0.5)\n"
        "second = 'from granular_env.components.support.powers import power; power(2, 1); print(len(power.overloads))'\n"
        "subprocess.run([sys.executable, '-c', second], check=True)"
    )
    done = run(code, tmp_path, environment={"GRANULAR_ENV_QUIET": ""})
    assert done.stdout == "1\n" and done.stderr.count("compiling") == 1


@pytest.mark.skipif(not JIT, reason="nothing is compiled")
def test_a_kernel_is_compiled_once_whatever_whole_numbers_it_is_called_with(tmp_path: Path) -> None:
    text = """from granular_env.components.support.jit import jit
@jit
def scaled(k, x): return k * x
@jit
def called(n, x):
    k = 1  # a literal at first, any number later
    for _ in range(n):
        x += scaled(k, x) + scaled(3, x)
        k += 1
    return x
print(called(2, 1.0), len(scaled.overloads))
"""
    write(tmp_path, {"task.py": text})
    assert run("import task", tmp_path).stdout == "30.0 1\n"


# -- other versions of numba ----------------------------------------------------------------------------------------------


def test_a_numba_that_is_built_in_another_way_gives_the_same_results(tmp_path: Path) -> None:
    """Without what `code_libraries` stands on kernels are compiled by numba alone, in every process."""
    write(tmp_path, {"kernels.py": """
from granular_env.components.support.jit import internal, internal_inlined, jit

@internal_inlined
def square(x):
    return x * x

@internal
def add(pair, n):
    for i in range(n):
        pair[0][i] += square(pair[1][i]) / 3.0

@jit
def go(pair, n):
    add(pair, n)
    return pair[0].sum()
"""})  # fmt: skip
    code = (
        "import sys, numpy as np\nfrom kernels import add, go\nx = np.arange(5.0)\nadd((x, x), 3)\n"
        "print(go((x, x + 0.1), 5).hex(), x.tobytes().hex())"
    )
    told = {"GRANULAR_ENV_QUIET": "0"}
    plain = run(code, tmp_path, cache=tmp_path / "a", fresh=True, environment=told)
    assert list((tmp_path / "a").rglob("*.kernel")) and "install numba" not in plain.stderr
    for absent in ("codegen.JITCodeLibrary", "compiler.CompileResult._rebuild"):
        without = run(
            f"import numba\ndel numba.core.{absent}\n{code}", tmp_path, cache=tmp_path / "b", fresh=True, environment=told
        )
        assert without.stdout == plain.stdout != ""
        assert "install numba" in without.stderr and not list((tmp_path / "b").rglob("*.kernel"))
