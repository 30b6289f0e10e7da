"""Logs of a component in a plane: array inputs, vectors in balances, events, links, a state that grows."""

from __future__ import annotations

import dataclasses
import random
import warnings
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from support.component_examples import DISCS, TEAR
from support.conformance_tools import bits, drive
from support.recording_helpers import changed, film_topics, rewrite

import granular_env as ge
from granular_env.components.component import Component
from granular_env.components.discs import Discs
from granular_env.components.drawables import Links, Points
from granular_env.components.errors import GranularError, LogError
from granular_env.components.events import EventDetail
from granular_env.components.profiles import Profile
from granular_env.components.variables import Variable
from granular_env.recording import open_log, record, verify
from granular_env.recording.format.records import EVENTS, HASHES, HEADER, SNAPSHOTS, STEPS, TOPICS, Record
from granular_env.recording.reader.event_places import place_of
from granular_env.recording.recorder import log_writer
from granular_env.viewing import plot, report


def torn_log(path: Path, ticks: int = 120, **options: object) -> Component:
    """Numbers, arrays and profiles with patterns; the component as it is at the end."""
    component = DISCS.make()
    with record(component, path, **options):  # type: ignore[arg-type]
        component.reset(**DISCS.start)
        drive(component, DISCS, ticks)
        component.step(10 * component.step_size, force=0.25)
    return component


def test_a_log_verifies_and_holds_the_arrays(tmp_path: Path) -> None:
    component = torn_log(tmp_path / "a.mcap")
    log = open_log(tmp_path / "a.mcap")
    assert verify(log).identical
    (segment,) = log.segments
    given = {place: held["force"] for place, held in log.steps_of(segment).by_step().items()}
    assert given[0].tobytes() == TEAR.tobytes() and given[30].tobytes() == (0.5 * TEAR).tobytes()  # type: ignore[union-attr]
    assert given[60].pattern.tobytes() == TEAR.tobytes()  # type: ignore[union-attr]
    assert given[120].tolist() == np.full((6, 2), 0.25).tolist()  # type: ignore[union-attr]
    times, values = log.inputs["force"]
    assert values.shape == (len(times), 6, 2) and values[-1].tolist() == component.get("force").tolist()
    assert log.series("momentum")[1].shape[1:] == (2,)
    assert log.get("velocity", log.duration).tobytes() == component.get("velocity").tobytes()


def test_events_are_logged_once_and_found(tmp_path: Path) -> None:
    component = torn_log(tmp_path / "a.mcap")
    log = open_log(tmp_path / "a.mcap")
    assert log.events() == component.events() != []
    first = log.events()[0]
    assert log.events("link_broken", first.index)[0] == first
    assert log.events(index=99) == []
    assert log.event_kinds == Discs.event_kinds
    with pytest.raises(ge.ParameterError, match="link_brokn.*did you mean 'link_broken'"):
        log.events("link_brokn")


def test_a_step_that_fails_leaves_no_event(tmp_path: Path) -> None:
    component = DISCS.started()
    with record(component, tmp_path / "a.mcap"):
        component.step(None, force=TEAR)
        with pytest.raises(GranularError):
            component.step(100 * component.step_size, force=1e300)
        drive(component, DISCS, 60)
    log = open_log(tmp_path / "a.mcap")
    assert log.events() == component.events() != [] and verify(log).identical


def test_a_restored_component_logs_only_what_is_new(tmp_path: Path) -> None:
    component = DISCS.started()
    drive(component, DISCS, DISCS.ticks // 2)
    before = component.events()
    with record(component, tmp_path / "a.mcap"):
        drive(component, DISCS, DISCS.ticks)
        component.step(200 * component.step_size, force=3.0 * TEAR)
    log = open_log(tmp_path / "a.mcap")
    assert before and log.events() == component.events()[len(before) :] != []
    assert log.earlier_events() == before and log.earlier_events("link_broken", before[0].index)[0] == before[0]
    with pytest.raises(ge.ParameterError, match="link_brokn.*did you mean 'link_broken'"):
        log.earlier_events("link_brokn")
    assert verify(log).identical


def test_a_branch_knows_the_events_before_it_and_so_does_its_branch(tmp_path: Path) -> None:
    component = torn_log(tmp_path / "a.mcap")
    whole = open_log(tmp_path / "a.mcap")
    assert whole.earlier_events() == []
    middle = 0.5 * (whole.events()[0].tick + whole.events()[-1].tick) * whole.step_size
    child = whole.branch(middle).run(tmp_path / "b.mcap")
    last = child.branch(child.duration + child.start_tick * child.step_size).run(tmp_path / "c.mcap")
    for log in (child, last):
        earlier = log.earlier_events()
        assert earlier and [*earlier, *log.events()] == component.events() and verify(log).variable is None
        assert all(event.tick <= log.start_tick for event in earlier) and all(e.tick > log.start_tick for e in log.events())
    assert child.events() != [] == last.events()


def test_a_branch_that_an_older_version_wrote_does_not_know_the_events_before_it(tmp_path: Path) -> None:
    torn_log(tmp_path / "a.mcap")
    whole = open_log(tmp_path / "a.mcap")
    whole.branch(whole.duration).run(tmp_path / "b.mcap", until=1.1 * whole.duration)

    def change(old: Record) -> Record:
        if old.kind != SNAPSHOTS or "events" not in old.arrays:
            return old
        return dataclasses.replace(old, arrays={"snapshot": old.arrays["snapshot"]})

    rewrite(tmp_path / "b.mcap", tmp_path / "old.mcap", change)
    assert open_log(tmp_path / "old.mcap").earlier_events() is None and verify(tmp_path / "old.mcap").identical


def test_events_before_the_start_that_were_changed_are_noticed(tmp_path: Path) -> None:
    torn_log(tmp_path / "a.mcap")
    whole = open_log(tmp_path / "a.mcap")
    whole.branch(whole.duration).run(tmp_path / "b.mcap", until=1.1 * whole.duration)

    def with_events(change: Callable[[np.ndarray], np.ndarray]) -> Path:
        def changed_start(old: Record) -> Record:
            has = old.kind == SNAPSHOTS and "events" in old.arrays
            return changed(old, events=change(old.arrays["events"])) if has else old

        rewrite(tmp_path / "b.mcap", tmp_path / "c.mcap", changed_start)
        return tmp_path / "c.mcap"

    result = verify(with_events(lambda rows: flipped(rows, 3)))
    assert result.variable == "events" and not result.identical
    for wrong in (lambda rows: rows + [1e9, 0, 0, 0, 0], lambda rows: rows[:, :4], lambda rows: rows * [1, np.nan, 1, 1, 1]):
        with pytest.raises(LogError, match="the events before a segment have the wrong form"):
            open_log(with_events(wrong)).earlier_events()


@pytest.mark.parametrize("at", [0.0, 2.5e-4, 6.5e-4, 1.25e-3])
def test_a_branch_with_unchanged_inputs_has_the_parents_bits(tmp_path: Path, at: float) -> None:
    component = torn_log(tmp_path / "a.mcap")
    branch = open_log(tmp_path / "a.mcap").branch(at)
    branch.run(tmp_path / "b.mcap")
    assert bits(branch.component) == bits(component)
    assert verify(tmp_path / "b.mcap").identical


def test_a_branch_takes_another_array(tmp_path: Path) -> None:
    torn_log(tmp_path / "a.mcap")
    branch = open_log(tmp_path / "a.mcap").branch(2.5e-4)
    child = branch.run(tmp_path / "b.mcap", {"force": -TEAR})
    assert child.inputs["force"][1][-1].tolist() == (-TEAR).tolist()
    with pytest.raises(ge.ParameterError, match="force.*shape"):
        open_log(tmp_path / "a.mcap").branch(2.5e-4).run(tmp_path / "c.mcap", {"force": np.ones(3)})


# -- what is changed is named -------------------------------------------------------------------------------------------


def flipped(array: np.ndarray, place: int) -> np.ndarray:
    """The array with one bit changed."""
    other = array.copy()
    other.view(np.int64).reshape(-1)[place] ^= 1
    return other


@pytest.mark.parametrize("second_account", [True, False])
@pytest.mark.parametrize("array", ["0.values", "pattern.0"])
def test_one_changed_bit_of_an_array_input_names_it(tmp_path: Path, array: str, second_account: bool) -> None:
    torn_log(tmp_path / "a.mcap", hash_every=1)

    def change(old: Record) -> Record:
        if old.kind == HASHES and old.detail == 1 and not second_account:
            return dataclasses.replace(old, header={})
        has = old.kind == STEPS and old.arrays.get(array, np.zeros(0)).size
        return changed(old, **{array: flipped(old.arrays[array], 3)}) if has else old

    rewrite(tmp_path / "a.mcap", tmp_path / "b.mcap", change)
    result = verify(tmp_path / "b.mcap")
    assert not result.identical and result.variable == "force"


def test_one_changed_bit_of_an_event_is_noticed(tmp_path: Path) -> None:
    torn_log(tmp_path / "a.mcap")
    places = {EVENTS: lambda old: changed(old, rows=flipped(old.arrays["rows"], 3))}
    rewrite(tmp_path / "a.mcap", tmp_path / "b.mcap", lambda old: places.get(old.kind, lambda same: same)(old))
    result = verify(tmp_path / "b.mcap")
    assert result.variable == "events" and not result.identical


# -- what people see ----------------------------------------------------------------------------------------------------


def test_links_are_logged_and_drawn(tmp_path: Path) -> None:
    torn_log(tmp_path / "a.mcap", variables=["displacement", "speed", "linked"])
    log = open_log(tmp_path / "a.mcap")
    points, links = log.drawables
    assert isinstance(points, Points) and points.reference.shape == (6, 2)
    assert isinstance(links, Links) and links.pairs.tolist() == DISCS.make().drawables()[1].pairs.tolist()  # type: ignore[union-attr]
    assert {"/particles", "/preview", "/links/links"} <= film_topics(tmp_path / "a.mcap").keys()


def test_a_report_shows_balances_and_events(tmp_path: Path) -> None:
    torn_log(tmp_path / "a.mcap", variables=["displacement", "speed", "linked"])
    log = open_log(tmp_path / "a.mcap")
    html = report(log, tmp_path / "report").read_text()
    for words in ("potential energy", "fracture energy", "momentum x", "momentum residual y", "link broken", "Events"):
        assert words in html
    assert plot(log, "speed").axes
    last = log.events()[-1].tick * log.step_size
    child = log.branch(last).run(tmp_path / "b.mcap", until=last + 2 * log.step_size)
    happened, before = len(child.events()), len(child.earlier_events() or [])
    html = report(child, tmp_path / "branch").read_text()
    assert (
        f"Of these events {happened} are in this log, {before} before it begins at {last:.9g} s: {before} x link broken."
        in html
    )


def test_xarray_has_the_axes_of_the_plane(tmp_path: Path) -> None:
    torn_log(tmp_path / "a.mcap", variables=["displacement", "speed"])
    data = open_log(tmp_path / "a.mcap").to_xarray()
    assert data.displacement.dims == ("time", "disc", "direction") and data.speed.dims == ("time", "disc")


def test_an_axis_may_have_the_name_of_a_variable(tmp_path: Path) -> None:
    class Springs(Discs):
        def _declare(self) -> Iterable[Variable]:
            for one in super()._declare():
                yield dataclasses.replace(one, axes=("speed",)) if one.name == "speed" else one

    with record(Springs(), tmp_path / "a.mcap"):
        pass
    data = open_log(tmp_path / "a.mcap").to_xarray()
    assert data.speed.dims == ("time", "speed_0")


# -- hostile logs -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "name", "values"),
    [
        (STEPS, "0.values", np.zeros((2, 6))),
        # More than a block has: under load there may be a block of one.
        (STEPS, "0.values", np.zeros((99, 6, 2))),
        (STEPS, "0.values", np.full((3, 6, 2), np.nan)),
        (STEPS, "pattern.0", np.zeros((6, 3))),
        (STEPS, "pattern.0", np.full((6, 2), np.inf)),
        (STEPS, "pattern.0", np.zeros((6, 2), np.int64)),
        (EVENTS, "rows", np.zeros((1, 4))),
        (EVENTS, "rows", np.full((1, 5), np.nan)),
        (EVENTS, "rows", np.array([[1e300, 0.0, 0.0, 1.0, 1.0]])),
        (EVENTS, "rows", np.array([[1.0, 7.0, 0.0, 1.0, 1.0]])),
        (HEADER, "1.pairs", np.full((6, 2), 99)),
        (HEADER, "1.pairs", np.zeros((6, 3), np.int64)),
        (HEADER, "0.radius", np.zeros(4)),
        (HEADER, "0.reference", np.zeros((6, 4))),
    ],
)
def test_arrays_of_another_form_are_refused(tmp_path: Path, kind: int, name: str, values: np.ndarray) -> None:
    torn_log(tmp_path / "a.mcap", ticks=90)
    rewrite(
        tmp_path / "a.mcap",
        tmp_path / "b.mcap",
        lambda old: changed(old, **{name: values}) if old.kind == kind and name in old.arrays else old,
    )
    with pytest.raises(LogError):
        log = open_log(tmp_path / "b.mcap")
        _ = log.inputs, log.events(), log.drawables


def test_random_lies_are_refused_or_found(tmp_path: Path) -> None:
    """Any number of a record changed, with every checksum right: an error of the family, or a difference that is named."""
    torn_log(tmp_path / "a.mcap", ticks=90)
    chance, kinds, noticed = random.Random(3), (STEPS, EVENTS, HASHES, SNAPSHOTS, HEADER), 0
    for _ in range(48):
        kind, wild = chance.choice(kinds), chance.choice([0, -1, 1, 2**62, 0x7FF8000000000000])

        def change(old: Record, kind: int = kind, wild: int = wild) -> Record:
            names = [name for name, array in old.arrays.items() if array.size and array.dtype.itemsize == 8]
            if old.kind != kind or not names:
                return old
            name = chance.choice(sorted(names))
            array = np.array(old.arrays[name])
            array.view(np.int64).reshape(-1)[chance.randrange(array.size)] = wild
            return changed(old, **{name: array})

        rewrite(tmp_path / "a.mcap", tmp_path / "b.mcap", change)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                noticed += not verify(tmp_path / "b.mcap").identical
                open_log(tmp_path / "b.mcap").events()
            except GranularError:
                noticed += 1
    # Most numbers matter. How records are cut, and so which numbers are drawn, hangs on the machine's load.
    assert noticed > 24


def test_a_profile_times_an_array_and_a_number(tmp_path: Path) -> None:
    """The same force as a pattern times a profile, and as an array at each step, differ by rounding only."""
    shaped, stepped = DISCS.started(), DISCS.started()
    signal = Profile.table([0.0, 0.2, 1.0], [0.0, 1.0, 0.0])
    shaped.step(50 * shaped.step_size, force=TEAR * signal)
    for tick in range(50):
        stepped.step(None, force=signal((tick + 0.5) * stepped.step_size) * TEAR)
    np.testing.assert_allclose(shaped.get("velocity"), stepped.get("velocity"), rtol=1e-12, atol=1e-14)


def test_events_that_a_cut_log_has_lost_are_missing_not_different(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Events are written after the steps in which they happened, so a cut can fall between them."""
    discs = ge.make("discs", rows=3, columns=4)
    with monkeypatch.context() as patched, record(discs, tmp_path / "a.mcap", every=1e-3):
        patched.setattr(log_writer, "CHUNK_BYTES", 1)  # each record has a chunk of its own
        discs.reset(velocity={0: (1.0, 0.0), 8: (-1.0, 0.5)})
        for _ in range(50):
            discs.step(1e-4)
    whole, cut, mended = (tmp_path / "a.mcap").read_bytes(), tmp_path / "cut.mcap", tmp_path / "mended.mcap"
    happened, fewer = open_log(tmp_path / "a.mcap").events(), 0
    with (tmp_path / "a.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    for chunk in summary.chunk_indexes:
        (channel,) = chunk.message_index_offsets
        if TOPICS.get(summary.channels[channel].topic) not in (STEPS, HASHES, EVENTS):
            continue
        cut.write_bytes(whole[: chunk.chunk_start_offset + chunk.chunk_length])
        ge.recover(cut, mended, overwrite=True)
        found, log = verify(mended), open_log(mended)
        if not found.ticks:
            continue
        assert found.identical, found.message
        known = log.events()
        assert known == happened[: len(known)]
        missing = [event for event in happened[len(known) :] if event.tick <= log.end_tick]
        assert all(event.tick > log.events_end_tick for event in missing)
        assert any("event" in one for one in found.missing) == bool(missing)
        fewer += bool(missing)
    assert fewer, "no cut has fallen between steps and their events"


def test_events_of_other_ticks_than_those_of_the_step_are_refused(tmp_path: Path) -> None:
    class Early(Discs):
        def _advance(self, ticks: int) -> int:
            self._add_event(self._tick + 5000, "link_broken", 0, 1.0, 0.5)
            return super()._advance(ticks)

    discs = Early()
    with record(discs, tmp_path / "a.mcap"), pytest.raises(ge.ParameterError, match="noted one for tick 5000, expected ticks"):
        discs.step(10 * discs.step_size)
    log = open_log(tmp_path / "a.mcap")
    assert log.events() == [] and [incident["incident"] for incident in log.incidents] == ["unrecorded"]


def test_a_recorder_that_cannot_begin_lets_the_file_go(tmp_path: Path) -> None:
    class Broken(Discs):
        is_broken = False

        def _outputs(self) -> dict[str, Any]:
            read = super()._outputs()
            return {**read, "speed": lambda: np.array(["no number"]) if self.is_broken else read["speed"]()}

    discs = Broken()
    Broken.is_broken = True
    with pytest.raises((GranularError, ValueError)):
        record(discs, tmp_path / "a.mcap", variables=["speed"])
    with record(Discs(), tmp_path / "a.mcap", overwrite=True) as recorder:
        assert recorder.tick == 0


def test_links_across_a_closed_side_have_their_place_there() -> None:
    shape, closed = {"name": "rectangle", "width": 0.04, "height": 0.02}, {"left": "periodic", "right": "periodic"}
    specimen = ge.make("automata", shape=shape, diameter=0.01, packing="square", boundaries=closed)
    points, links = specimen.drawables()
    assert isinstance(points, Points) and isinstance(links, Links) and points.period.tolist() == [0.04, 0.0]
    lengths = np.sqrt((points.ways(links.pairs) ** 2).sum(axis=1))
    assert lengths == pytest.approx(0.01, rel=1e-12)
    across = np.flatnonzero(~points.stays_inside(links.pairs))
    assert len(across) == 3, "one in each row"
    detail = EventDetail("1", "links")
    for link in across.tolist():
        place = place_of(link, detail, specimen.drawables())
        assert place is not None and place.position[0] in (pytest.approx(-0.005), pytest.approx(0.035))
