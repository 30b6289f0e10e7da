"""Environments in mid-episode: as bytes for another process, in a batch, and at an instant of a log."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.env_toys import MAKERS, SMALL, actions, transcript

import granular_env as ge
from granular_env.components.errors import LogError, ParameterError
from granular_env.components.support.serialization import pack, unpack
from granular_env.domains.chain import ChainVectorEnv
from granular_env.domains.chain.tasks.piston import make_piston
from granular_env.domains.chain.tasks.protection import make_protection
from granular_env.envs import ComponentEnv, EnvState, RecordEnv
from granular_env.envs.state import EpisodeOrigin
from granular_env.recording import record

HARD: dict[str, Any] = {
    "grains": 6,
    "deadline": 60,
    "control_delay": 4,
    "action_rate": 0.2,
    "noise": 0.05,
    "randomise": {"velocity": (0.0, 2.0)},
}


# -- as bytes -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("maker", sorted(MAKERS))
def test_bytes_hold_the_whole_state(maker: str) -> None:
    env, other = MAKERS[maker](), MAKERS[maker]()
    env.reset(seed=2)
    transcript(env, actions(9))
    data = env.save().to_bytes()
    assert EnvState.from_bytes(data).to_bytes() == data
    other.restore(EnvState.from_bytes(data))
    assert transcript(other, actions(40, seed=1)) == transcript(env, actions(40, seed=1))
    np.testing.assert_array_equal(other.reset()[0], env.reset()[0])


def test_a_new_process_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    """Saved at random instants of a noisy, delayed episode."""
    generator, expected = np.random.default_rng(5), []
    env = make_piston(**HARD)
    for number, instant in enumerate(generator.integers(0, 30, 4).tolist()):
        env.reset(seed=number)
        transcript(env, actions(instant, seed=number))
        (tmp_path / f"{number}.state").write_bytes(env.save().to_bytes())
        told = transcript(env, actions(60, seed=7))
        expected.append(b"".join([*told, env.reset()[0].tobytes()]).hex())
    script = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from pathlib import Path
from support.env_toys import actions, transcript
from granular_env.domains.chain.tasks.piston import make_piston
from granular_env.envs import EnvState
env = make_piston(**{HARD!r})
for number in range(4):
    env.restore(EnvState.from_bytes((Path({str(tmp_path)!r}) / f"{{number}}.state").read_bytes()))
    print(b"".join([*transcript(env, actions(60, seed=7)), env.reset()[0].tobytes()]).hex())
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == expected


def test_bytes_that_are_no_state_are_refused() -> None:
    env = make_piston(**SMALL)
    env.reset(seed=1)
    data = env.save().to_bytes()
    for wrong in (b"", b"nonsense" * 20, data[:-1], data[:40] + b"x" + data[41:], env.component.save().to_bytes()):
        with pytest.raises(LogError):
            EnvState.from_bytes(wrong)


@pytest.mark.parametrize("name", ["test", "seed", "random", "exponential", "Generator", "RandomState", "", None, 3, ["PCG64"]])
def test_bytes_choose_nothing_that_is_called(name: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    called: list[str] = []
    for one in ("test", "seed", "random", "exponential"):
        monkeypatch.setattr(np.random, one, lambda *arguments, one=one: called.append(one))
    env = make_piston(**SMALL)
    env.reset(seed=1)
    header, arrays = unpack(env.save().to_bytes())
    header["random"] = {"bit_generator": name}
    with pytest.raises(LogError):
        EnvState.from_bytes(pack(header, arrays))
    assert called == []


@pytest.mark.parametrize("kind", [np.random.MT19937, np.random.PCG64DXSM, np.random.Philox, np.random.SFC64])
def test_states_of_bit_generators_that_numpy_does_not_check_are_refused(kind: Any) -> None:
    env = MAKERS["swing"]()
    env.np_random = np.random.Generator(kind(5))
    env.reset()
    with pytest.raises(LogError, match="expected 'PCG64'"):
        EnvState.from_bytes(env.save().to_bytes())


@pytest.mark.parametrize(
    ("name", "value"),
    [("state", -1), ("state", 2**128), ("inc", 1.5), ("inc", None), ("has_uint32", 2), ("has_uint32", True), ("uinteger", -1)],
)
def test_states_of_pcg64_out_of_range_are_refused(name: str, value: Any) -> None:
    env = make_piston(**SMALL)
    env.reset(seed=1)
    header, arrays = unpack(env.save().to_bytes())
    random = header["random"]
    (random["state"] if name in random["state"] else random)[name] = value
    with pytest.raises(LogError, match=f"{name}: got"):
        EnvState.from_bytes(pack(header, arrays))


@pytest.mark.parametrize("place", [0, 2, 3, 4, 5])
@pytest.mark.parametrize("number", [math.nan, math.inf, -1.5, 1e300])
def test_memories_that_no_environment_has_are_refused_and_nothing_moves(place: int, number: float) -> None:
    if place in (4, 5) and math.isfinite(number):
        pytest.skip("an input may be any finite number")
    env = make_piston(**SMALL)
    batch = ChainVectorEnv(make_piston, 3, **SMALL)
    env.reset(seed=1)
    batch.reset(seed=2)
    batch.step(np.ones((3, 1)))
    state, good = env.save(), batch.save()
    memory = np.frombuffer(state.episode).copy()
    memory[place] = number
    bad = EnvState(state.snapshot, memory.tobytes(), EpisodeOrigin(state.origin.task, state.origin.random, {}))
    for restore in (lambda: env.restore(bad), lambda: batch.restore([state, bad], [0, 1])):
        with pytest.raises(ParameterError, match="counts and commands"):
            restore()
    assert batch.save() == good, "a batch takes all of them or none"
    batch.restore(good)
    batch.step(np.ones((3, 1)))


def test_random_numbers_that_are_none_are_refused_and_nothing_moves() -> None:
    env, other = make_piston(**SMALL), make_piston(**SMALL)
    env.reset(seed=1)
    other.reset(seed=1)
    transcript(other, actions(4))
    state, before = other.save(), env.save()
    for random in ({"bit_generator": "seed"}, {}, {**state.origin.random, "state": {"state": -1, "inc": 3}}):
        with pytest.raises(ParameterError, match="random numbers"):
            env.restore(EnvState(state.snapshot, state.episode, EpisodeOrigin(state.origin.task, random, {})))
        assert env.save() == before


def test_states_are_told_apart_and_shown() -> None:
    env = make_piston(**SMALL)
    env.reset(seed=1)
    first, again = env.save(), env.save()
    env.step([0.1])
    assert first == again and hash(first) == hash(again) and first != env.save() and first != 3
    assert repr(first).startswith("EnvState('piston', tick=0")


def test_a_state_with_another_memory_is_refused() -> None:
    env, other = make_piston(**SMALL), make_piston(**SMALL, control_delay=2)
    env.reset(seed=1)
    other.reset(seed=1)
    with pytest.raises(ParameterError, match="control_delay"):
        env.restore(other.save())


# -- in a batch -----------------------------------------------------------------------------------------------------------


def test_states_move_between_batches_and_single_environments() -> None:
    batch, env = ChainVectorEnv(make_piston, 3, **HARD, info="full"), make_piston(**HARD)
    batch.reset(seed=4)
    env.reset(seed=20)
    chosen = [actions(3, seed=step) for step in range(30)]
    for some in chosen[:10]:
        batch.step(some)
        env.step(some[0])
    states = batch.save()
    first = [batch.step(some) for some in chosen[10:]]
    # One goes back, one becomes the single environment, one goes on as it is.
    now = batch.save()
    batch.restore([states[1], env.save()], environments=[1, 2])
    assert batch.save([0])[0].to_bytes() == now[0].to_bytes()
    for step, some in enumerate(chosen[10:]):
        observations, rewards, *_ = batch.step(some)
        observation, reward, *_ = env.step(some[2])
        np.testing.assert_array_equal(observations[1], first[step][0][1])
        np.testing.assert_array_equal(observations[2], observation)
        assert rewards[1] == first[step][1][1] and rewards[2] == reward


def test_restored_environments_know_whether_they_are_over() -> None:
    batch = ChainVectorEnv(make_protection, 2, grains=4, deadline=3, internal_steps=15, clock=0)
    batch.reset(seed=1)
    begun = batch.save()
    for _ in range(3):
        _, _, _, truncated, _ = batch.step(np.zeros((2, 1)))
    assert truncated.all()
    over = batch.save()
    batch.restore(begun)
    assert not batch.step(np.ones((2, 1)))[3].any() and batch.save()[0].snapshot.tick == 15
    batch.restore(over)
    assert batch.step(np.ones((2, 1)))[4]["time"].tolist() == [0.0, 0.0], "what is over is reset by the next step"


def test_states_that_do_not_fit_a_batch_are_refused() -> None:
    batch = ChainVectorEnv(make_piston, 2, **SMALL)
    batch.reset(seed=1)
    states = batch.save()
    for wrong, environments, words in (
        (states[:1], None, "got 1, expected 2"),
        (states, [0, 0], "once"),
        (states, [0, 2], "0 to 1"),
        ([states[0], None], None, "state"),
        (3, None, "got 3, expected 2"),
        (states, 1, "environments: got 1"),
    ):
        batch.step(np.ones((2, 1)))
        before = [state.to_bytes() for state in batch.save()]
        with pytest.raises(ParameterError, match=words):
            batch.restore(wrong, environments)  # type: ignore[arg-type]
        assert [state.to_bytes() for state in batch.save()] == before, "nothing has changed"


# -- at an instant of a log -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("instant", [0, 7, 23, 39])
@pytest.mark.parametrize("maker", [make_piston, make_protection])
def test_a_log_goes_on_as_an_environment(maker: type[ComponentEnv], instant: int, tmp_path: Path) -> None:
    """The same inputs give the bits of the log's own continuation."""
    chosen, path = actions(40), tmp_path / "episode.mcap"
    env = RecordEnv(maker(**SMALL), path, every=1.5e-6)
    env.reset(seed=1)
    passed = [env.unwrapped.component.save().to_bytes()]
    for action in chosen:
        env.step(action)
        passed.append(env.unwrapped.component.save().data)
    env.close()
    fresh = maker(**SMALL)
    observation, info = fresh.branch(path, at=instant * fresh.duration, seed=3)
    assert fresh.observation_space.contains(observation) and info["time"] == fresh.component.time
    for number in range(instant, 40):
        fresh.step(chosen[number])
        assert fresh.component.save().data == passed[number + 1]
    assert fresh.component.tick == env.unwrapped.component.tick


def test_an_episode_from_a_log_is_one_of_its_own(tmp_path: Path) -> None:
    chain, path = (
        ge.make("chain", grains=8, step_size=5e-7, left="piston", radius=3e-3, velocity_scale=10.0),
        tmp_path / "run.mcap",
    )
    with record(chain, path):
        chain.reset()
        chain.step(3e-5, left_velocity=ge.Profile.half_sine(2.0, 3e-5))
    env = make_piston(**SMALL)
    assert env.component.identity == chain.identity
    env.branch(path, at=3e-5)
    rewards = [env.step([0.0])[1] for _ in range(20)]
    # The work that the profile did is nobody's here; but the wave is there.
    assert rewards[0] == pytest.approx(0.0, abs=1e-3)
    assert np.abs(env.component.get("velocity")).max() > 0.1
    _, _, _, truncated, _ = env.step([0.0])
    assert not truncated and env.save().snapshot.tick == chain.tick + 63


def test_an_environment_of_a_batch_goes_on_from_a_log(tmp_path: Path) -> None:
    path = tmp_path / "pushed.mcap"
    recorded = make_protection(**SMALL)
    with record(recorded.component, path):
        recorded.reset(seed=1)
        transcript(recorded, actions(20))
    batch, single = ChainVectorEnv(make_protection, 2, **SMALL), make_protection(**SMALL)
    batch.reset(seed=1)
    batch.single(1).branch(path, at=1.5e-5, seed=8)
    single.branch(path, at=1.5e-5, seed=8)
    for some in actions(30):
        observations, rewards, *_ = batch.step(np.stack([some, some]))
        observation, reward, *_ = single.step(some)
        np.testing.assert_array_equal(observations[1], observation)
        assert rewards[1] == reward


def test_a_log_of_another_chain_is_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    other = make_piston(grains=9, radius=2e-3)
    with record(other.component, path):
        other.reset(seed=1)
        other.step([0.5])
    env = make_piston(**SMALL)
    env.reset(seed=1)
    before = env.save().to_bytes()
    with pytest.raises(ParameterError, match="grains is 9 there and 8 here; radius is 0.002 there and 0.003 here"):
        env.branch(path, at=0.0)
    with pytest.raises(ParameterError, match="at: got 1 s, the log goes from"):
        other.branch(path, at=1.0)
    with pytest.raises(ParameterError, match="velocity"):
        other.branch(path, at=0.0, options={"velocity": 1.0})
    with pytest.raises(LogError):
        env.branch(tmp_path / "missing.mcap", at=0.0)
    with pytest.raises(ParameterError, match="oscillator"):
        oscillator = MAKERS["swing"]()
        with record(oscillator.component, tmp_path / "swing.mcap"):
            oscillator.reset(seed=1)
            oscillator.step([0.5])
        env.branch(tmp_path / "swing.mcap", at=0.0)
    assert env.save().to_bytes() == before


def test_any_component_can_be_branched(tmp_path: Path) -> None:
    path, env, other = tmp_path / "swing.mcap", MAKERS["swing"](), MAKERS["swing"]()
    with record(env.component, path):
        env.reset(seed=1)
        transcript(env, actions(10))
    other.branch(path, at=10 * other.duration)
    assert other.component.save().data == env.component.save().data
    other.step([0.1])
