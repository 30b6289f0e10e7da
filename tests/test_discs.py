"""The toy component in the plane: physics, breaking links, and the generic packages that show or drive it."""

from __future__ import annotations

import math
from pathlib import Path

import gymnasium
import numpy as np
import pytest

import granular_env as ge
from granular_env.colours import ColourScale, diverging_colours
from granular_env.components.discs import Discs
from granular_env.components.drawables import to_three_columns
from granular_env.components.errors import ParameterError, StepError
from granular_env.components.profiles import Profile
from granular_env.components.variables import Variable
from granular_env.control.runner import run_study
from granular_env.envs import OpenLoop
from granular_env.envs.policies import Policy
from granular_env.recording import verify
from granular_env.sweep import run_sweep
from granular_env.viewing.figures import plane
from granular_env.viewing.figures.keys import displacement_notes
from granular_env.viewing.scene_data import MeshFrames, SceneData
from granular_env.viewing.scene_scales import Scales

THROWN = {"rows": 3, "columns": 4, "clearance": 0.03}


def thrown(step_size: float = 1e-5) -> Discs:
    """Return a block moving towards the upper right corner of its box."""
    discs = Discs(**THROWN, step_size=step_size)
    discs.reset(velocity=(6.0, 4.0))
    return discs


# -- physics ------------------------------------------------------------------------------------------------------------


def test_a_block_at_rest_stays_at_rest() -> None:
    discs = Discs(rows=3, columns=3)
    discs.step(0.01)
    # Rounding of the positions, 1e-17 m, times omega = 2000 / s, over several periods.
    assert np.abs(discs.get("velocity")).max() < 1e-12 and discs.events() == []


def test_two_linked_discs_swing_at_their_own_frequency() -> None:
    discs = Discs(rows=1, columns=2, mass=0.01, stiffness=1e4, step_size=1e-6)
    discs.reset(velocity={0: (-0.01, 0.0), 1: (0.01, 0.0)})
    quarter = 0.5 * math.pi / math.sqrt(2.0 * 1e4 / 0.01)  # the reduced mass is half a disc's mass
    discs.step(round(quarter / 1e-6) * 1e-6)
    # The amplitude is v / omega; an error of one step at the turning point changes it by (omega h)^2 / 2 = 1e-6.
    assert discs.get("displacement")[1, 0] == pytest.approx(0.01 / math.sqrt(2.0 * 1e4 / 0.01), rel=1e-5)


def test_link_forces_push_pressed_discs_apart() -> None:
    discs = Discs(rows=1, columns=3, stiffness=1e4, breaking_strain=0.01)
    discs.reset(displacement={0: (-0.001, 0.0), 2: (-0.0003, 0.0)})  # the first link is too long, the second is pressed
    discs.step(discs.step_size)
    assert discs.get("linked").tolist() == [0.0, 1.0]
    assert discs.get("link_force") == pytest.approx([0.0, 3.0], abs=1e-3)
    discs.reset(displacement={0: (0.0001, 0.0)})
    assert discs.get("link_force") == pytest.approx([1.0, 0.0])


def test_a_disc_bounces_off_the_wall() -> None:
    disc = Discs(rows=1, columns=1, clearance=0.001)
    disc.reset(velocity=(1.0, 0.5))
    disc.step(0.0055)  # 1 and 2 ms to the walls, and half a period of 6.28 ms in each
    # Only the right and upper walls reflect the disc; the error of leapfrog is up to (omega h)^2 / 4 = 2.5e-5 of the speed.
    np.testing.assert_allclose(disc.get("velocity"), [[-1.0, -0.5]], rtol=2e-4)
    np.testing.assert_allclose(disc.get("wall_impulse"), [-0.02, -0.01], rtol=2e-4)


def test_the_energy_residual_falls_with_the_step() -> None:
    residuals = []
    for step_size in (4e-5, 1e-5, 2.5e-6):
        discs, worst = thrown(step_size), 0.0
        for _ in range(100):
            discs.step(4e-4)
            worst = max(worst, abs(discs.get("energy_residual")))
        residuals.append(worst / 3.12)
        assert discs.get("broken_links") > 0
    # 12 discs of 0.01 kg at sqrt(52) m/s have 3.12 J. The order is 2 also in steps in which contacts open or close.
    assert residuals[0] < 5e-3 and residuals[1] < residuals[0] / 4 and residuals[2] < residuals[1] / 4


def test_momentum_is_the_impulse() -> None:
    discs, force = Discs(**THROWN), np.zeros((12, 2))
    force[0], force[7] = (3.0, -1.0), (0.5, 4.0)
    discs.step(0.002, force=force)
    assert not discs.get("wall_impulse").any()
    np.testing.assert_allclose(discs.get("impulse"), 0.002 * force.sum(axis=0), rtol=1e-12)
    np.testing.assert_allclose(0.01 * discs.get("velocity").sum(axis=0), discs.get("impulse"), rtol=1e-12)


# -- breaking -----------------------------------------------------------------------------------------------------------


def test_a_link_breaks_at_its_limit() -> None:
    discs, force = Discs(rows=1, columns=2, step_size=1e-6), np.array([[-1.5, 0.0], [1.5, 0.0]])
    while not discs.events():
        discs.step(None, force=force)
    (event,) = discs.events()
    assert (event.kind, event.index, event.limit, event.tick) == ("link_broken", 0, 0.01, discs.tick)
    # The link lengthens at up to 1 m/s, i.e. by 5e-5 of its length per step.
    assert 0.01 < event.value < 0.01 + 5e-5
    assert discs.get("fracture_energy") == pytest.approx(0.5 * 1e4 * (event.value * 0.02) ** 2, rel=1e-12)
    assert discs.get("linked").tolist() == [0.0] and discs.get("broken_links") == 1.0
    velocity = discs.get("velocity")
    discs.step(1e-4, force=0.0)
    assert discs.get("velocity").tolist() == velocity.tolist()  # no link holds the discs


def test_snapshots_grow_with_what_breaks_and_go_on_bit_for_bit() -> None:
    discs, saved = thrown(), []
    for _ in range(10):
        saved.append((discs.save(), discs.state_bytes, discs.event_count))
        discs.step(0.004)
    (_, first, none), (_, last, many) = saved[0], saved[-1]
    assert none == 0 < many and last == first + many * (5 + 1) * 8  # a row of the events, and the number of the link
    for number, (snapshot, _, count) in enumerate(saved):
        other = Discs(**THROWN)
        other.restore(ge.Snapshot.from_bytes(snapshot.to_bytes()))
        assert other.event_count == count
        other.step(0.004 * (10 - number))
        assert other.save().to_bytes() == discs.save().to_bytes() and other.events() == discs.events()


def test_faults_name_what_is_wrong() -> None:
    discs = Discs(rows=2, columns=2)
    with pytest.raises(ParameterError, match=r"force.*shape \(4, 2\)"):
        discs.step(None, force=np.zeros((4, 3)))
    with pytest.raises(StepError, match=r"velocity\[0\]: reached .* take a smaller step_size"):
        discs.step(0.01, force=1e9)
    assert discs.tick == 0 and not discs.get("velocity").any()
    with pytest.raises(ParameterError, match="discs"):
        Discs(rows=100_000, columns=100_000)


# -- the generic packages -------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    result = ge.run("discs/broken-row", log=tmp_path_factory.mktemp("logs") / "a.mcap", overrides={"duration": 0.02})
    return ge.open_log(result.log)


def test_the_shipped_row_breaks_in_the_middle(log) -> None:
    (event,) = log.events("link_broken")
    assert event.index == 4 and event.value > event.limit == 0.01
    assert verify(log).identical
    # The pulses meet in the middle after 4.5 links at 20 m/s = 4.5 ms, and their sum peaks 2 ms later.
    assert 4.5e-3 < event.tick * 1e-5 < 6.6e-3


def test_a_branch_with_less_force_does_not_break(log, tmp_path: Path) -> None:
    pattern = np.zeros((10, 2))
    pattern[0, 0], pattern[9, 0] = -1.0, 1.0
    weaker = Profile.half_sine(0.7, 4e-3) * pattern
    child = log.branch(0.0).run(tmp_path / "b.mcap", {"force": weaker})
    assert child.events() == [] and verify(tmp_path / "b.mcap").identical
    same = log.branch(0.005)
    same.run(tmp_path / "c.mcap")
    assert same.component.get("displacement").tobytes() == log.get("displacement", log.duration).tobytes()


def test_a_plane_has_cells_in_the_colours_of_their_field_or_of_its_mean_over_their_nodes() -> None:
    nodes = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0], [1.0, 1.0], [2.0, 1.0]])
    corners = np.array([[0, 1, 4, 3], [1, 2, 5, 4]])
    for field in (np.array([[-3.0, 5.0]]), np.array([[-3.0, -3.0, 13.0, -3.0, -3.0, 13.0]])):
        stress, moved = Variable("stress", "output", "Pa", (), ""), np.full((1, 6, 3), 0.01)
        mesh = MeshFrames(
            "grid",
            np.zeros(1),
            np.zeros(1, np.int64),
            to_three_columns(nodes),
            corners,
            moved,
            field,
            stress,
            located=True,
            is_plane=True,
        )
        scales = Scales(10.0, (ColourScale(("stress",), "Pa", 13.0, True),), (0.0, 0.0, 0.0), (2.0, 1.0, 0.0))
        shown = plane.Plane(SceneData("a grid", meshes=(mesh,)), scales)
        axes, bar = plane.draw_plane(shown).axes
        (drawn,) = axes.collections
        np.testing.assert_allclose(drawn.get_facecolor()[:, :3], diverging_colours(np.array([-3.0, 5.0]), 13.0) / 255.0)
        assert bar.get_xlabel() == "stress [Pa]"
        np.testing.assert_allclose(drawn.get_paths()[1].vertices[:4], nodes[corners[1]] + 0.1)
        assert plane.plane_text(shown) == "Grid at chosen instants, x to the right, y up."
        assert displacement_notes(shown) == ["displacements \u00d7 10"]


def played(env: gymnasium.Env, policy: Policy) -> tuple[float, dict]:
    observation, info = env.reset(seed=0)
    policy.reset()
    total, over = 0.0, False
    while not over:
        observation, reward, terminated, truncated, info = env.step(policy(observation, info))
        total, over = total + float(reward), terminated or truncated
    return total, info


@pytest.mark.parametrize("target", [0, 4, 7])
def test_pulses_that_meet_split_the_row_at_any_link(target: int) -> None:
    env = gymnasium.make("granular_env/Splitting-v1", target=target)
    policies = env.unwrapped.task.baselines()
    value, info = played(env, policies["theory"])
    assert info["linked"][target] == 0.0 and info["wrong_links"] == 0.0 and info["closeness"] == 1.0
    # A link that breaks at 2 N and 0.2 mm stores 0.2 mJ.
    assert value == pytest.approx(1.0 - 0.1 * info["work"] / 2e-4, rel=1e-9) and value > 0.586
    value, info = played(env, policies["nothing"])
    assert abs(value) < 1e-9 and info["linked"].all()


def test_a_wrong_link_costs_a_whole_return() -> None:
    env = gymnasium.make("granular_env/Splitting-v1", target=2, force_scale=4.0, work_price=0.0)
    value, info = played(env, OpenLoop(np.tile([0.0, 1.0], (60, 1))))  # only the right end, above the strength of a link
    assert info["wrong_links"] >= 1.0 and value == pytest.approx(info["closeness"] - info["wrong_links"], rel=1e-9)


def test_the_picture_shows_the_tension_of_links_and_no_broken_link() -> None:
    env = gymnasium.make("granular_env/Splitting-v1", target=2, render_mode="rgb_array")
    env.reset()
    at_rest = np.asarray(env.render())
    played(env, env.unwrapped.task.baselines()["theory"])
    split = np.asarray(env.render())
    middles = [[picture[200, 40 + 44 + 88 * link + 44] for link in range(9)] for picture in (at_rest, split)]
    assert all(colour.tolist() == [225, 225, 228] for colour in middles[0])
    # Tension is red next to the broken link, where only the grey rims of two discs are left.
    assert np.ptp(middles[1][2]) < 4 and int(middles[1][1][0]) > 2 * int(middles[1][1][2])


def test_two_discs_at_one_place_are_refused_by_name_and_nothing_has_moved() -> None:
    discs = ge.make("discs")
    discs.step(1e-4, force=np.ones((8, 2)))
    before = discs.save().to_bytes()
    with pytest.raises(ParameterError, match=r"start.displacement\[1\]: puts disc 1 on top of disc 0; move one of them"):
        discs.reset(displacement={1: [-0.02, 0.0]})
    assert discs.save().to_bytes() == before


def test_the_shipped_study_finds_more_than_theory(tmp_path: Path) -> None:
    pytest.importorskip("cma", reason="the extra `control` is not installed")
    result = run_study("splitting", tmp_path / "study", overrides={"budget": 5_000, "seeds": [3]}, only=["cma"])
    score, theory = result.method_trials("cma")[0].score, result.baselines["theory"]
    assert score is not None and score.value > theory.value + 0.1
    assert verify(tmp_path / "study" / "logs" / "cma-3.mcap").identical


def test_a_sweep_finds_how_strain_decides(tmp_path: Path) -> None:
    plan = {
        "version": 1, "experiment": "discs/broken-row", "set": {"duration": 0.01},
        "grid": {"component.breaking_strain": [0.006, 0.01, 0.02]},
        "measure": {"broken": "final broken_links", "middle": "final linked[4]", "fastest": "max speed"},
    }  # fmt: skip
    columns = run_sweep(plan, tmp_path / "sweep", engine="serial").columns()
    broken = columns["broken"]
    assert broken[0] > broken[1] == 1.0 and broken[2] == 0.0 and columns["middle"] == [columns["middle"][0], 0.0, 1.0]


def test_events_are_asked_for_by_kind_and_index() -> None:
    discs = ge.run("discs/broken-row").component
    (broken,) = discs.events("link_broken")
    assert discs.events(index=broken.index) == [broken] and discs.events("link_broken", broken.index + 1) == []
    with pytest.raises(ParameterError, match="kind: got 'broken', expected a kind of event"):
        discs.events("broken")
    with pytest.raises(ParameterError, match="index: got 1.5"):
        discs.events(index=1.5)  # type: ignore[arg-type]


def test_a_sweep_measures_events(tmp_path) -> None:
    plan = {
        "version": 1, "experiment": "discs/broken-row", "grid": {"input.force.peak": [0.1, 1.5]},
        "measure": {"broken": "events link_broken", "when": "first link_broken"},
    }  # fmt: skip
    sweep = run_sweep(plan, tmp_path / "sweep", engine="serial")
    found = sweep.columns()
    event = ge.run("discs/broken-row", overrides={"input.force.peak": 1.5}).component.events()[0]
    assert list(found["broken"]) == [0.0, 1.0] and np.isnan(found["when"][0])
    assert found["when"][1] == pytest.approx(event.tick * 1e-5) and sweep.units["when"] == "s"
    plan["measure"] = {"broken": "events link_brokn"}
    with pytest.raises(ge.GranularError, match=r"measure.broken.kind: got 'link_brokn'.*did you mean 'link_broken'"):
        run_sweep(plan, tmp_path / "wrong", engine="serial")
