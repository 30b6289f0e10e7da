"""The page of the environments matches their docstrings and spaces; its pictures exist and are small."""

from __future__ import annotations

import importlib.util
import re
from decimal import Decimal
from pathlib import Path
from types import ModuleType

import gymnasium
import numpy as np
import pytest

import granular_env.envs  # noqa: F401 - registers the environments
from granular_env.domains import load_environments
from granular_env.envs.policies import play

ENVIRONMENTS = load_environments()
DOCS = Path(__file__).resolve().parent.parent / "docs"


@pytest.fixture(scope="module")
def pages() -> ModuleType:
    spec = importlib.util.spec_from_file_location("environment_pages", DOCS / "environment_pages.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_is_what_the_environments_say(pages: ModuleType) -> None:
    page = pages.PAGE.read_text("utf-8")
    assert page == pages.make_page(), "run: python docs/environment_pages.py --pages"
    assert pages.RETURNS.keys() == {pages.short_name(name) for name in ENVIRONMENTS}
    for link in re.findall(r"\]\(#([^)]+)\)", page):
        assert link in {title.lower().replace(" ", "-") for title in re.findall(r"^## (.+)$", page, re.MULTILINE)}


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_the_table_states_the_returns_of_the_baselines(pages: ModuleType, name: str) -> None:
    env = gymnasium.make(name)
    policies = env.unwrapped.task.baselines()
    for policy, text in zip(("nothing", "theory", "best"), pages.RETURNS[pages.short_name(name)], strict=True):
        if policy in policies:
            found, (low, *high) = play(env, policies[policy], seed=0)[0], text.split(" to ")
            # A number is rounded to its last digit; a range covers sampled episodes.
            last_digit = Decimal(1).scaleb(Decimal(low).as_tuple().exponent) if not high else 0
            assert float(low) - 0.51 * float(last_digit) <= found <= float(high[0] if high else low) + 0.51 * float(last_digit)


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_a_picture_is_there_and_small(pages: ModuleType, name: str) -> None:
    picture = pages.IMAGES / f"{pages.slug(pages.short_name(name))}.gif"
    assert 10_000 < picture.stat().st_size < 300_000


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
