"""The environments' pages match their docstrings and spaces; their pictures exist and are small."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import gymnasium
import numpy as np
import pytest

import granular_env.envs  # noqa: F401 - registers the environments
from granular_env.domains import load_environments

ENVIRONMENTS = load_environments()
DOCS = Path(__file__).resolve().parent.parent / "docs"


@pytest.fixture(scope="module")
def pages() -> ModuleType:
    spec = importlib.util.spec_from_file_location("environment_pages", DOCS / "environment_pages.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_a_page_is_what_the_environment_says(pages: ModuleType, name: str) -> None:
    path = DOCS / "environments" / f"{pages.slug(name.rpartition('/')[2])}.md"
    assert path.read_text("utf-8") == pages.make_page(name), "run: python docs/environment_pages.py --pages"
    picture = DOCS / "images" / "environments" / f"{path.stem}.gif"
    assert 10_000 < picture.stat().st_size < 300_000
    assert f"environments/{path.stem}.md" in (DOCS.parent / "mkdocs.yml").read_text("utf-8")


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_a_table_covers_the_observation_and_says_what_each_number_is(pages: ModuleType, name: str) -> None:
    env = gymnasium.make(name).unwrapped
    observation, info = env.reset(seed=1)
    for action in (0.1, -0.2, 0.15):
        observation, *_, info = env.step(np.full(env.action_space.shape, action))
    covered = []
    for first, last, quantity, unit in pages.observation_rows(env):
        covered += range(first, last + 1)
        scale = float(unit.split()[0])
        name, where = quantity.split("`")[1:3] if quantity.startswith("`") else ("", quantity)
        if where.startswith(" at "):
            expected = env.component.get(name)[[int(place) for place in where[4:].split(", ")]] / scale
            np.testing.assert_allclose(observation[first : last + 1], expected, rtol=1e-6, atol=1e-12)
        elif name and where != " of the goal":
            expected = np.ravel(info[name]) / scale
            np.testing.assert_allclose(observation[first : last + 1], expected, rtol=1e-6, atol=1e-12)
        elif name:
            assert observation[first] == pytest.approx(info[name] / scale, rel=1e-5)
    assert covered == list(range(env.observation_space.shape[0]))
