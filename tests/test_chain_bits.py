"""The same bits however the kernels run: JIT off, tiled, tick by tick, as plain numpy; and no stale machine code."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from support.chain_tools import INTEGRATORS, ROOT, bit_cases, python

import granular_env as ge
from granular_env.components.chain.integrators import compositions

GRAINS, TICKS = 11, 40

_UNJITTED = """
from support import chain_tools
chain_tools.print_bit_cases({schemes!r}, {grains}, {ticks})
"""
_TILED = """
from granular_env.components.chain.integrators import compositions
compositions.TILED_ABOVE, compositions._TILE_GRAINS, compositions._BLOCK_STAGES = {above}, {tile}, {block}
print({tile}, {block})
"""
TILINGS = [(6, 5), (11, 10), (16, 15), (17, 8), (40, 40)]
SCHEMES, LENGTHS = ("pefrl", "leapfrog"), (20, 21, 23, 24, 26, 30)


def compiled(schemes: tuple[str, ...], grains: int, ticks: int) -> list[str]:
    return [f"{name}: {digest}" for name, digest in bit_cases(schemes, grains, ticks)]


@pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")
def test_the_same_bits_with_the_jit_off() -> None:
    said = python(_UNJITTED.format(schemes=INTEGRATORS, grains=GRAINS, ticks=TICKS), NUMBA_DISABLE_JIT="1")
    assert said.splitlines() == compiled(INTEGRATORS, GRAINS, TICKS)


@pytest.fixture(scope="module")
def tiled() -> dict[str, list[str]]:
    """What a process without the compiler prints for each tiling, by the tiling."""
    code = ""
    for tile, block in TILINGS:
        code += _TILED.format(above=4, tile=tile, block=block)
        code += "".join(_UNJITTED.format(schemes=SCHEMES, grains=grains, ticks=9) for grains in LENGTHS)
    printed: dict[str, list[str]] = {}
    for line in python(code, NUMBA_DISABLE_JIT="1").splitlines():
        if ":" in line:
            list(printed.values())[-1].append(line)
        else:
            printed[line] = []
    return printed


@pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")
@pytest.mark.parametrize(("tile", "block"), TILINGS)
def test_the_same_bits_in_tiles(tile: int, block: int, tiled: dict[str, list[str]]) -> None:
    """Tiles narrower and wider than the chain, blocks of one and of many steps, every kind of end.

    The lengths make the last grain change tiles before, in the middle of, and after a step.
    """
    assert tiled[f"{tile} {block}"] == [line for grains in LENGTHS for line in compiled(SCHEMES, grains, 9)]


def plain_numpy(chain: ge.Chain, velocity: np.ndarray, ticks: int) -> tuple[np.ndarray, np.ndarray]:
    """PEFRL written as arrays, for a chain between two planes; the arithmetic of each grain in the same order."""
    shape, h, mass = chain.geometry, chain.step_size, chain.geometry.mass
    u, v = np.zeros(len(velocity) + 2), velocity.copy()
    for _ in range(ticks):
        u[1:-1] += compositions.PEFRL.drifts[0] * h * v
        for kick, drift in zip(compositions.PEFRL.kicks, compositions.PEFRL.drifts[1:], strict=True):
            d = np.maximum(u[:-1] - u[1:] + shape.rest_overlap, 0.0)
            force = shape.stiffness * (d * np.sqrt(d))
            v += kick * h * (1.0 / mass) * (force[:-1] - force[1:])
            u[1:-1] += drift * h * v
    return u[1:-1], v


@pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")
@pytest.mark.parametrize("grains", [100, compositions.TILED_ABOVE + 3001])
def test_against_plain_numpy_and_itself_tick_by_tick(grains: int) -> None:
    """The long chain is advanced in tiles, 70 steps are three blocks of them."""
    random = np.random.default_rng(5)
    velocity = random.uniform(-1.0, 1.0, grains)
    chain = ge.make(
        "chain", grains=grains, left="plane", right="plane", radius={"low": 1e-3, "high": 3e-3, "seed": 1}, step_size=1e-7
    )
    chain.reset(velocity=velocity)
    chain.step(70 * chain.step_size)
    whole = chain.save().to_bytes()
    u, v = plain_numpy(chain, velocity, 70)
    assert np.array_equal(chain.get("displacement"), u)
    assert np.array_equal(chain.get("velocity"), v)
    chain.reset(velocity=velocity)
    for _ in range(70):
        chain.step()
    assert chain.save().to_bytes() == whole


@pytest.mark.parametrize("more", [4096 - 1, 4096 - 50, 4096 - 103])
def test_a_right_piston_on_a_chain_of_many_tiles(more: int) -> None:
    """The piston changes tiles in mid-step; it moves as its velocity says, and the whole as tick by tick."""
    grains = compositions.TILED_ABOVE + more
    states = []
    for pieces in (1, 60):
        chain = ge.make("chain", grains=grains, right="piston", step_size=1e-7)
        for _ in range(pieces):
            chain.step(60 // pieces * chain.step_size, right_velocity=-1.0)
        assert chain.get("displacement")[-1] == pytest.approx(-6e-6, rel=1e-12)
        states.append(chain.save().to_bytes())
    assert states[0] == states[1]


@pytest.mark.slow  # all of the chain is compiled twice; test_kernel_cache.py edits a small kernel every day
def test_an_edited_law_is_compiled_anew(tmp_path: Path) -> None:
    """Hertz's law lies in another file than the integrator that calls it; numba's own cache would keep the old force."""
    shutil.copytree(ROOT / "granular_env", tmp_path / "granular_env", ignore=shutil.ignore_patterns("__pycache__"))
    code = (
        "import granular_env as ge\n"
        f"assert ge.__file__.startswith({str(tmp_path)!r}), ge.__file__\n"
        "chain = ge.make('chain', grains=3, integrator='rk4', contact_stiffness=1e7, step_size=1e-7)\n"
        "chain.reset(velocity={0: 1.0}); chain.step(2e-5); print(chain.get('velocity').tolist())"
    )
    # How well the code is optimized makes no difference here, and takes half of the time.
    options = {"folder": tmp_path, "GRANULAR_ENV_CACHE": str(tmp_path / "cache"), "NUMBA_OPT": "0"}
    before = python(code, **options)
    kernels = tmp_path / "granular_env" / "components" / "chain" / "laws" / "hertz.py"
    text = kernels.read_text(encoding="utf-8")
    assert text.count("return k * (d * sqrt(d))") == 1
    kernels.write_text(text.replace("return k * (d * sqrt(d))", "return k * (d * d)"), encoding="utf-8")
    assert python(code, **options) != before
    kernels.write_text(text, encoding="utf-8")
    assert python(code, **options) == before
