"""Custom kernels, tasks and objectives work with any law; laws from other packages and scripts run and replay."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from support import cubic_law

import granular_env as ge
from granular_env.components.chain.differentiable_quantities import contact_force, contact_force_pullback
from granular_env.components.chain.laws import LAWS as KNOWN
from granular_env.components.chain.laws import functions
from granular_env.components.chain.objective import Objective
from granular_env.components.support.jit import jit
from granular_env.domains.chain.control import value_and_grad

LAWS: dict[str, dict[str, Any]] = {
    "hertz": {},
    "power": {"law": {"name": "power", "exponent": 1.8}, "contact_stiffness": 2e11},
    "viscous": {"law": {"name": "viscous", "dissipation": 20.0}},
    "walton_braun": {"law": {"name": "walton_braun", "unloading_stiffness": 2.5e7}, "contact_stiffness": 1e7},
}


def pressed(name: str) -> ge.Chain:
    chain = ge.Chain(grains=5, right="plane", precompression=50.0, step_size=1e-8, **LAWS[name])
    chain.reset(velocity=np.array([1.0, 0.5, 0.0, 0.0, 0.0]))
    return chain


@jit
def twice_the_force(chain, j):
    return 2.0 * contact_force(chain, j)


@pytest.mark.parametrize("name", LAWS)
def test_a_kernel_gets_the_law_of_its_chain(name: str) -> None:
    chain = pressed(name)
    assert [twice_the_force(chain.state, j) for j in range(6)] == (2.0 * chain.get("contact_force")).tolist()


@jit
def _note(chain, step, steps, inputs, constants, sums):
    if step == steps - 1:
        sums[0] += contact_force(chain, 2)


@jit
def _value(sums, constants, slopes):
    slopes[0] = 1.0
    return sums[0]


@jit
def _pullback(chain, adjoint, step, steps, inputs, input_adjoint, constants, slopes):
    if step == steps - 1:
        contact_force_pullback(chain, adjoint, 2, slopes[0])


@pytest.mark.parametrize("name", ["hertz", "power", "viscous"])
def test_one_objective_serves_chains_of_several_laws(name: str) -> None:
    chain, drive, h = pressed(name), np.zeros((20, 2)), 1e-4
    drive[:, 0] = 30.0
    objective = Objective(_note, _value, _pullback)
    force, gradient = value_and_grad(objective, chain, drive, ticks=20)
    # The output also contains the inputs held after the drive.
    twin = pressed(name)
    twin.step(400 * twin.step_size, left_force=30.0)
    assert force == twin.get("contact_force")[2]
    forces = [value_and_grad(objective, chain, drive + sign * h, ticks=20)[0] for sign in (1.0, -1.0)]
    assert gradient["drive"][:, 0].sum() == pytest.approx((forces[0] - forces[1]) / (2.0 * h), rel=1e-5)


def test_two_laws_of_one_name_are_refused() -> None:
    class CubicContacts(NamedTuple):
        stiffness: np.ndarray

    with pytest.raises(TypeError, match="support.cubic_law has a law of that name.*rename one"):
        functions.force.register(CubicContacts)
    assert functions.force.implementations[cubic_law.CubicContacts] is cubic_law.force


_RUN = """
import sys
sys.path[:0] = {folders!r}
import granular_env as ge
{imports}
chain = ge.Chain(grains=4, contact_stiffness=1e7, step_size=1e-7, law={law!r})
chain.reset(displacement={{0: 1e-6}})
print(chain.get("contact_force").tolist())
"""


def _run(law: str, folders: list[Path], cache: Path, imports: str = "") -> str:
    code = _RUN.format(law=law, folders=[str(folder) for folder in folders], imports=imports)
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False,
        env={**os.environ, "GRANULAR_ENV_CACHE": str(cache), "PYTHONPATH": str(Path(ge.__file__).parents[1])},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout


def test_a_law_in_a_script_leaves_a_cache_that_other_processes_can_load(tmp_path: Path) -> None:
    """The second process cannot import the law's module, but must load the index of compiled kernels."""
    module = Path(cubic_law.__file__).read_text(encoding="utf-8")
    scratch, cache = tmp_path / "scratch", tmp_path / "cache"
    scratch.mkdir()
    (scratch / "scratch_law.py").write_text(
        module.replace("Cubic", "Scratch").replace('"cubic"', '"scratch"'), encoding="utf-8"
    )
    known = "import scratch_law\nfrom granular_env.components.chain.laws import LAWS\nLAWS['scratch'] = scratch_law.Scratch"
    first = _run("scratch", [scratch], cache, known)
    assert _run("hertz", [], cache) != first == _run("scratch", [scratch], cache, known)


def test_a_law_of_another_package_runs_records_and_replays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A package whose entry point names the law; without it the name is unknown."""
    about = tmp_path / "laws_of_another_package-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: laws-of-another-package\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[granular_env.chain_laws]\nquartic = laws_of_another_package:Quartic\n")
    module = Path(cubic_law.__file__).read_text(encoding="utf-8").replace("Cubic", "Quartic").replace('"cubic"', '"quartic"')
    (tmp_path / "laws_of_another_package.py").write_text(module, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    from granular_env.components.chain.laws import CHOSEN_LAWS

    vars(CHOSEN_LAWS).pop("_plugin_laws", None)
    try:
        log = tmp_path / "run.mcap"
        experiment = {
            "name": "quartic", "duration": 1e-5,
            "component": {"type": "chain", "grains": 4, "contact_stiffness": 1e7, "step_size": 1e-7, "law": "quartic"},
            "start": {"velocity": {"0": 1.0}},
        }  # fmt: skip
        ge.run(experiment, log=log)
        assert ge.verify(log).identical
    finally:
        vars(CHOSEN_LAWS).pop("_plugin_laws", None)
    assert "quartic" not in KNOWN
