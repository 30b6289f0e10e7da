"""Chains that are drawn for each episode: the same in every vectoriser, exact in states, branches and logs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from support.env_toys import actions, transcript

from granular_env.components.chain import Chain
from granular_env.components.errors import ParameterError
from granular_env.domains.chain import ChainVectorEnv
from granular_env.domains.chain.tasks import ENVIRONMENTS
from granular_env.domains.chain.tasks.piston import make_piston
from granular_env.domains.chain.tasks.protection import make_protection
from granular_env.domains.chain.tasks.pulse_forming import make_pulse_forming
from granular_env.envs import EnvState, RecordEnv
from granular_env.envs.registration import register_all
from granular_env.recording import record, verify

register_all()
DRAWN: dict[str, Any] = {"randomise": {"radius": (2e-3, 3e-3)}}
SMALL: dict[str, Any] = {"grains": 6, "deadline": 24, **DRAWN}


def radii(vectoriser: str, count: int = 4) -> np.ndarray:
    env = gymnasium.make_vec("granular_env/Protection-v1", count, vectorization_mode=vectoriser, **SMALL)
    found = [env.reset(seed=0)[1]["drawn_radius"]]
    for _ in range(26):  # the next episode begins on the way
        infos = env.step(np.zeros((count, 1), np.float32))[4]
    found.append(infos["drawn_radius"])
    env.close()
    return np.array(found)


def test_every_vectoriser_draws_a_chain_for_each_environment_and_episode() -> None:
    native = radii("vector_entry_point")
    assert len(set(native.reshape(-1).tolist())) == 8
    np.testing.assert_array_equal(radii("sync"), native)


@pytest.mark.slow
def test_processes_draw_the_same() -> None:
    np.testing.assert_array_equal(radii("async"), radii("vector_entry_point"))


def test_the_constants_of_the_task_are_those_of_the_chain_that_was_drawn() -> None:
    env = make_piston(grains=5, **DRAWN)
    for seed in range(3):
        radius = env.reset(seed=seed)[1]["drawn_radius"]
        fixed = make_piston(grains=5, radius=radius)
        assert env.constants.tolist() == fixed.constants.tolist()
        env.reset(seed=seed)
        fixed.reset(seed=seed)
        told, expected = env.step([0.4]), fixed.step([0.4])
        assert told[1] == expected[1] and told[0].tobytes() == expected[0].tobytes()


def test_a_state_carries_the_chain_that_was_drawn() -> None:
    env, other = make_protection(**SMALL), make_protection(**SMALL)
    env.reset(seed=1)
    transcript(env, actions(3))
    state = EnvState.from_bytes(env.save().to_bytes())
    other.reset(seed=2)
    assert other.component.identity != env.component.identity
    other.restore(state)
    assert other.component.identity == env.component.identity and other.observe()[1].keys() == env.observe()[1].keys()
    assert transcript(other, actions(20, seed=1)) == transcript(env, actions(20, seed=1))
    np.testing.assert_array_equal(other.reset()[0], env.reset()[0])
    plain = make_protection(grains=6, deadline=24)
    plain.reset(seed=1)
    for one, foreign in ((plain, state), (other, plain.save())):
        before = one.save()
        with pytest.raises(ParameterError, match="randomise"):
            one.restore(foreign)
        assert one.save() == before


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_states_move_between_lanes_of_unlike_chains(mode: AutoresetMode) -> None:
    arguments = {**SMALL, "grains": 12, "place": 3, "amplitude": 4.0, "deadline": 40}
    batch, single = ChainVectorEnv(make_pulse_forming, 3, autoreset_mode=mode, **arguments), make_pulse_forming(**arguments)
    batch.reset(seed=1)
    single.reset(seed=9)
    single.step([0.3])
    batch.restore([single.save(), batch.save([0])[0]], environments=[0, 2])
    for some in actions(20):
        observations, rewards, *_, infos = batch.step(np.tile(some, (3, 1)))
        observation, reward, *_, info = single.step(some)
        np.testing.assert_array_equal(observations[0], observation)
        assert rewards[0] == reward and infos["drawn_radius"][0] == info["drawn_radius"]


def test_each_recorded_episode_has_a_log_of_its_chain_that_can_be_branched(tmp_path: Path) -> None:
    env = RecordEnv(make_protection(**SMALL), tmp_path / "episode.mcap")
    passed = []
    for seed in (1, 2):
        env.reset(seed=seed)
        transcript(env.unwrapped, actions(8))
        passed.append(env.unwrapped.component.save())
    env.close()
    assert [path.name for path in env.paths] == ["episode.mcap", "episode-2.mcap"]
    for path, state in zip(env.paths, passed, strict=True):
        assert verify(path).identical
        fresh = make_protection(**SMALL)
        info = fresh.branch(path, at=8 * fresh.duration)[1]
        assert fresh.component.save().data == state.data and info["drawn_radius"] == fresh.component.get("radius")


def test_a_recorder_is_not_left_behind_on_the_last_chain(tmp_path: Path) -> None:
    env = make_protection(**SMALL)
    env.reset(seed=1)
    with record(env.component, tmp_path / "one.mcap"):
        env.reset(seed=1)  # the same chain again
        transcript(env, actions(5))
        before = env.save()
        with pytest.raises(ParameterError, match="RecordEnv"):
            env.reset(seed=2)
        assert env.save().snapshot.data == before.snapshot.data
    assert verify(tmp_path / "one.mcap").calls == 5


def test_a_start_value_that_is_refused_leaves_the_chain() -> None:
    env = make_protection(**SMALL)
    env.reset(seed=1)
    before = env.component.identity
    with pytest.raises(ParameterError):
        env.reset(options={"velocty": 1.0})
    assert env.component.identity == before


@pytest.mark.parametrize("randomise", [{"radius": (-1e-3, 3e-3)}, {"precompression": (0.0, 1e9)}])
def test_ends_of_a_range_that_cannot_be_are_refused_at_once(randomise: Any) -> None:
    with pytest.raises(ParameterError):
        make_pulse_forming(randomise=randomise)


ARRANGED = {
    "dimer": {"name": "dimer", "radius": [3e-3, 1.5e-3]},
    "tapered": {"name": "tapered", "first_radius": 3e-3, "taper": 0.01},
    "decorated": {"name": "decorated", "radius": 3e-3, "decoration_radius": 1.5e-3},
    "random": {"name": "random", "low": 2e-3, "high": 3e-3, "seed": 1},
    "other material": {"name": "dimer", "material": ["steel", "aluminium"]},
}


@pytest.mark.parametrize("arrangement", ARRANGED)
@pytest.mark.parametrize("name", ENVIRONMENTS)
@pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")
def test_every_task_takes_arranged_grains_and_may_draw_what_they_leave_open(name: str, arrangement: str) -> None:
    chain = {"arrangement": ARRANGED[arrangement]}
    # Precompression changes the waves that SolitonTrain asks for, which has none.
    drawn = {"velocity": (0.0, 0.5)} if "Soliton" in name else {"precompression": (5.0, 10.0)}
    env = gymnasium.make(name, grains=65, chain=chain, randomise=drawn, deadline=260)
    expected = Chain(**chain, grains=65).geometry.radius
    for seed in range(2):
        _, info = env.reset(seed=seed)
        assert env.unwrapped.component.geometry.radius.tolist() == expected.tolist()
        assert "precompression" not in drawn or 5.0 <= info["drawn_precompression"] <= 10.0
        for _ in range(5):
            assert np.isfinite(env.step([0.1])[1])


def test_a_radius_that_is_given_twice_is_told_of() -> None:
    for changes in ({"radius": 2e-3}, {"randomise": {"radius": (2e-3, 3e-3)}}):
        with pytest.raises(ParameterError, match="give it in one place"):
            make_protection(chain={"arrangement": ARRANGED["dimer"]}, **changes)
