"""Logs: bitwise round trips, replay and branches."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.recording_helpers import CHAIN, chain_log, change_arrays, oscillator_log, rewrite_log

import granular_env.components.catalogue as catalogue
from granular_env.components.component import Component
from granular_env.components.errors import ParameterError, StepError
from granular_env.components.profiles import Profile
from granular_env.components.snapshot import Snapshot
from granular_env.recording import open_log, record, verify
from granular_env.recording.records import FRAMES, SNAPSHOTS, STEPS, Record


def test_frames_are_what_the_component_said(tmp_path: Path) -> None:
    component = catalogue.make("oscillator")
    expected = []
    with record(component, tmp_path / "a.mcap", every=0.02, variables=["velocity", "input_work", "force"]):
        component.reset(velocity=1.0)
        for number in range(100):
            if component.tick % 2 == 0:
                expected.append([component.get(name) for name in ("velocity", "input_work", "force")])
            component.step(0.01, force=float(number))
    log = open_log(tmp_path / "a.mcap")
    assert log.complete and log.calls == 100 and list(log.variables)[:3] == ["velocity", "input_work", "force"]
    assert set(log.variables) >= {"kinetic_energy", "momentum_residual"}, "the balances always come along"
    found = np.column_stack([log.series(name)[1][:-1] for name in ("velocity", "input_work", "force")])
    assert found.tobytes() == np.array(expected).tobytes()
    times, velocity = log.series("velocity")
    assert np.allclose(times, 0.02 * np.arange(51), rtol=0, atol=1e-12)
    assert log.get("velocity", 0.5) == velocity[25] == log.get("velocity", 0.51)
    assert log.get("velocity", log.duration + 0.004) == velocity[-1], "rounding is no matter"
    with pytest.raises(ParameterError, match="from 0 s to 1 s"):
        log.get("velocity", 1.01)


def test_default_frames_thin_out_and_are_the_same_each_time(tmp_path: Path) -> None:
    ticks = []
    for name in "ab":
        oscillator_log(tmp_path / name)
        log = open_log(tmp_path / name)
        ticks.append(log.ticks("velocity"))
        assert set(log.variables) >= {"position", "velocity", "kinetic_energy", "momentum_residual"}
    assert np.array_equal(*ticks)
    gaps = np.diff(ticks[0])
    # Every tick up to 128, every second tick up to 256, every fourth tick up to the end at 260.
    assert [int((gaps == gap).sum()) for gap in (1, 2, 4)] == [128, 64, 1] and len(gaps) == 193 and (np.diff(gaps) >= 0).all()


def test_an_experiments_duration_decides_how_many_frames(tmp_path: Path) -> None:
    component = catalogue.make("oscillator")
    with record(component, tmp_path / "a.mcap", experiment={"duration": 50.0, "name": "long"}):
        component.step(50.0)
    log = open_log(tmp_path / "a.mcap")
    assert len(log.ticks("position")) == 5000 // 20 + 1
    assert log.metadata["experiment"] == {"duration": 50.0, "name": "long"}


def test_the_log_says_what_it_is(tmp_path: Path) -> None:
    component = chain_log(tmp_path / "a.mcap")
    with open_log(tmp_path / "a.mcap") as log:
        facts = log.metadata
        assert facts["component"] == "chain" and facts["identity"] == component.identity
        assert {"python", "numpy", "numba", "llvmlite", "mcap"} <= facts["versions"].keys()
        assert "cpu" in facts["machine"] and facts["report"].keys() == component.report().keys()
        assert log.variables["velocity"].unit == "m/s" and log.variables["velocity"].shape == (12,)
        assert np.array_equal(log.drawables[0].reference, component.drawables()[0].reference)  # type: ignore[union-attr]
        assert log.input_variables["left_force"].unit == "N"
        last = list(log.input_intervals("left_force"))[-1]
        assert last.value == 44.0 and last.end == log.end_tick
        assert log.component().get("velocity")[0] == 1.0


def test_xarray_shares_the_dimensions_of_what_is_counted(tmp_path: Path) -> None:
    pytest.importorskip("xarray")
    chain_log(tmp_path / "a.mcap", variables=["velocity", "displacement", "contact_force", "overlap"])
    log = open_log(tmp_path / "a.mcap")
    data = log.to_xarray()
    assert log.variables["velocity"].axes == ("grain",)
    product = data.velocity * data.displacement
    assert product.dims == ("time", "grain") and product.shape == log.series("velocity")[1].shape
    assert (data.contact_force * data.overlap).dims == ("time", "contact")
    assert data.grain.values.tolist() == list(range(12)) and data.contact.size == log.variables["overlap"].shape[0]
    assert np.array_equal(data.velocity.sel(grain=3), log.series("velocity")[1][:, 3])
    assert data.sizes["time"] == len(log.times("velocity")) and data.time.attrs["units"] == "s"


def test_chosen_frames_equal_those_of_the_series_in_any_order(tmp_path: Path) -> None:
    chain = catalogue.make("chain", **CHAIN)
    with record(chain, tmp_path / "a.mcap", every=chain.step_size):
        for _ in range(3):
            chain.reset(velocity={0: 1.0})
            chain.step(20 * chain.step_size)
    with open_log(tmp_path / "a.mcap") as log:
        velocity = log.series("velocity")[1]
        assert len(log.frame_rows("velocity")) > 1
        for numbers in (np.array([55, 3, 3, 21, 0, len(velocity) - 1]), np.arange(len(velocity)), np.array([], dtype=np.int64)):
            assert log.frames_at("velocity", numbers).tobytes() == velocity[numbers].tobytes()
            assert log.frames_at("velocity", numbers, [4, 1]).tobytes() == velocity[numbers][:, [4, 1]].tobytes()


def test_segments_are_laid_end_to_end(tmp_path: Path) -> None:
    component = catalogue.make("oscillator")
    with record(component, tmp_path / "a.mcap", every=0.05):
        for episode in range(3):
            component.reset(velocity=float(episode + 1))
            component.step(0.3, force=float(episode))
    log = open_log(tmp_path / "a.mcap")
    assert [(s.start, s.end) for s in log.segments] == [(0, 30)] * 3
    assert log.duration == pytest.approx(0.9)
    assert (np.diff(log.ticks("velocity")) >= 0).all() and len(log.ticks("velocity")) == 21
    assert log.get("velocity", 0.3) == 2.0 and log.get("velocity", 0.6) == 3.0
    result = verify(log)
    assert result.identical and result.calls == 3 and result.frames == 21


@pytest.mark.parametrize("make_log", [oscillator_log, chain_log])
def test_a_log_verifies(make_log, tmp_path: Path) -> None:  # noqa: ANN001
    make_log(tmp_path / "a.mcap", snapshot_every=None)
    log = open_log(tmp_path / "a.mcap")
    seen = []
    result = verify(log, progress=seen.append)
    assert result.identical and result and result.calls == log.calls and result.ticks == log.end_tick
    # A time counts as one frame for any number of recorded variables.
    assert result.frames == len(np.unique(log.ticks(next(iter(log.variables)))))
    assert result.hashes >= 1 and result.snapshots >= 2
    assert "identical" in result.message and seen and 0.0 < max(seen) <= 1.0


def record_a_failure(component: Component, path: Path, left_force: float | Profile) -> None:
    """100 internal steps, a step that fails because of the force, and 50 more steps."""
    h = component.step_size
    with record(component, path, every=h):
        component.reset(velocity={0: 1.0})
        component.step(100 * h)
        with pytest.raises(StepError):
            component.step(5000 * h, left_force=left_force)
        component.step(50 * h)


def test_a_failed_step_leaves_no_trace_but_its_reason(tmp_path: Path) -> None:
    record_a_failure(catalogue.make("chain", **CHAIN), tmp_path / "a.mcap", 1e9)
    log = open_log(tmp_path / "a.mcap")
    assert log.ticks("velocity").tolist() == list(range(151))
    assert [incident["incident"] for incident in log.incidents] == ["failed"]
    assert verify(log).identical


def test_parts_of_a_long_step_that_were_written_are_a_segment_of_their_own_if_it_fails(tmp_path: Path, monkeypatch) -> None:  # noqa: ANN001
    monkeypatch.setattr("granular_env.recording.recorder._WAKE_BYTES", 0)
    component = catalogue.make("chain", **CHAIN)
    h = component.step_size
    with record(component, tmp_path / "a.mcap", every=10 * h):
        component.reset(velocity={0: 1.0})
        component.step(100 * h, left_force=1.0)
        before = component.save()
        with pytest.raises(StepError):
            component.step(5000 * h, left_force=Profile.triangle(2e5, 4000 * h, rise=3999 * h))
        assert component.save().data == before.data
        component.step(50 * h)
    log = open_log(tmp_path / "a.mcap")
    first, second = log.segments
    assert first.start == 0 and first.end > 100 and (second.start, second.end) == (100, 150)
    (incident,) = log.incidents
    # The part of the step that was written and then undone.
    assert incident["incident"] == "failed" and incident["undone_ticks"] == first.end - 100
    assert verify(log).identical


def test_a_long_step_is_written_while_it_lasts(tmp_path: Path, monkeypatch) -> None:  # noqa: ANN001
    """Bitwise identical to an unrecorded run, with all frames."""
    monkeypatch.setattr("granular_env.recording.recorder._WAKE_BYTES", 0)
    component = catalogue.make("chain", **CHAIN)
    h = component.step_size
    component.reset(velocity={0: 1.0})
    component.step(1000 * h, left_force=1.0)
    alone = component.save()
    with record(component, tmp_path / "a.mcap", every=10 * h):
        component.reset(velocity={0: 1.0})
        component.step(1000 * h, left_force=1.0)
        assert component.save().data == alone.data
    log = open_log(tmp_path / "a.mcap")
    assert log.ticks("velocity").tolist() == list(range(0, 1001, 10)) and len(log.segments) == 1
    assert verify(log).identical


# -- tampering, with every checksum valid ------------------------------------------------------------------------------


def _one_input_bit(step: int):  # noqa: ANN202
    def change(old: Record) -> Record:
        if old.kind != STEPS or old.first != 0:
            return old
        values = old.arrays["0.values"].copy()
        values.view(np.int64)[step] ^= 1 << 40
        return change_arrays(old, **{"0.values": values})

    return change


def test_one_changed_input_bit_is_caught_at_its_step(tmp_path: Path) -> None:
    component = chain_log(tmp_path / "a.mcap", hash_every=1, steps=20)
    rewrite_log(tmp_path / "a.mcap", tmp_path / "b.mcap", _one_input_bit(7))
    result = verify(tmp_path / "b.mcap")
    assert not result.identical and result.variable == "left_force"
    # Step 7 runs from tick 21 to 24; with a hash at every tick, the first tick shows the change.
    assert result.interval == pytest.approx((21 * component.step_size, 22 * component.step_size))
    assert result.variable in result.message


@pytest.mark.parametrize("array", ["profile_coefficients", "profile_ticks"])
def test_one_changed_bit_of_a_profile_names_its_input(tmp_path: Path, array: str) -> None:
    component = catalogue.make("chain", **{**CHAIN, "left": "piston"})
    h = component.step_size
    with record(component, tmp_path / "a.mcap", hash_every=1):
        component.reset()
        component.step(50 * h)
        component.step(100 * h, left_velocity=Profile.triangle(1.0, 80 * h, start=60 * h))

    def change(old: Record) -> Record:
        if old.kind != STEPS or not len(old.arrays[array]):
            return old
        values = old.arrays[array].copy()
        values.view(np.int64)[np.flatnonzero(values)[-1]] ^= 1
        return change_arrays(old, **{array: values})

    rewrite_log(tmp_path / "a.mcap", tmp_path / "b.mcap", change)
    result = verify(tmp_path / "b.mcap")
    assert not result.identical and result.variable == "left_velocity" and result.interval is not None
    assert 0.0 <= result.interval[0] < result.interval[1] <= 150.0001 * h and "left_velocity" in result.message


def test_a_changed_held_number_names_its_input(tmp_path: Path) -> None:
    component = catalogue.make("chain", **CHAIN)
    component.step(left_force=20.0)
    with record(component, tmp_path / "a.mcap"):
        component.step(50 * component.step_size)

    def change(old: Record) -> Record:
        if old.kind != SNAPSHOTS:
            return old
        snapshot = Snapshot.from_bytes(old.arrays["snapshot"].tobytes())
        snapshot.inputs = {**snapshot.inputs, "left_force": np.nextafter(20.0, 21.0).item()}
        return change_arrays(old, snapshot=np.frombuffer(snapshot.to_bytes(), dtype=np.uint8))

    rewrite_log(tmp_path / "a.mcap", tmp_path / "b.mcap", change)
    result = verify(tmp_path / "b.mcap")
    assert not result.identical and result.variable == "left_force" and "left_force" in result.message


def test_one_changed_bit_of_a_frame_is_named_with_its_index(tmp_path: Path) -> None:
    component = chain_log(tmp_path / "a.mcap", variables=["velocity"], every=6e-7)

    def change(old: Record) -> Record:
        if old.kind != FRAMES or old.detail != 0:
            return old
        values = old.arrays["values"].copy()
        values.view(np.int64)[5 * CHAIN["grains"] + 3] ^= 1
        return change_arrays(old, values=values)

    rewrite_log(tmp_path / "a.mcap", tmp_path / "b.mcap", change)
    result = verify(tmp_path / "b.mcap")
    gap = round(6e-7 / component.step_size)
    assert (result.variable, result.index) == ("velocity", 3)
    assert result.interval == pytest.approx((4 * gap * component.step_size, 5 * gap * component.step_size))


# -- branches ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "at",
    [
        0.0,
        0.6,
        2.6,
    ],
)
def test_a_branch_with_unchanged_inputs_has_the_parents_bits(tmp_path: Path, at: float) -> None:
    end = oscillator_log(tmp_path / "a.mcap", every=0.01, snapshot_every=0.5)
    parent = open_log(tmp_path / "a.mcap")
    branch = parent.branch(round(at, 2))
    child = branch.run(tmp_path / "b.mcap")
    for name in parent.variables:
        times, values = child.series(name)
        parent_times, parent_values = parent.series(name)
        assert times.tobytes() == parent_times[-len(times) :].tobytes()
        assert values.tobytes() == parent_values[-len(values) :].tobytes()
    assert branch.component.save().memory.tobytes() == end.save().memory.tobytes()
    told = child.metadata["parent"]
    assert told["file"] == "a.mcap" and told["tick"] == branch.tick and told["log"] == parent.identity
    result = verify(child)
    assert result.identical if child.calls else result.outcome == "nothing was compared"


# -- arguments ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"every": 0.015}, "every"),
        ({"variables": ["velocitty"]}, "velocity"),
        ({"hash_every": 0}, "hash_every"),
        ({"experiment": {"x": object()}}, "experiment"),
    ],
)
def test_bad_arguments_leave_no_file(tmp_path: Path, options: dict[str, object], message: str) -> None:
    component = catalogue.make("oscillator")
    with pytest.raises(ParameterError, match=message):
        record(component, tmp_path / "a.mcap", **options)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())
    component.step(0.01)


def test_an_existing_file_is_kept(tmp_path: Path) -> None:
    oscillator_log(tmp_path / "a.mcap")
    before = (tmp_path / "a.mcap").read_bytes()
    with pytest.raises(ParameterError, match="exists"):
        oscillator_log(tmp_path / "a.mcap")
    assert (tmp_path / "a.mcap").read_bytes() == before
    oscillator_log(tmp_path / "a.mcap", overwrite=True)
