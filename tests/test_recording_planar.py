"""Logs of a component in a plane: array inputs, vectors in balances, events, links, a growing state."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.component_examples import DISCS, TEAR
from support.conformance_tools import drive_component, state_bits
from support.recording_helpers import change_arrays, film_topics, rewrite_log

import granular_env as ge
from granular_env.components.component import Component
from granular_env.components.discs import Discs
from granular_env.components.drawables import Links, Points
from granular_env.components.errors import GranularError, LogError
from granular_env.components.events import EventDetail
from granular_env.components.profiles import Profile
from granular_env.recording import open_log, record, verify
from granular_env.recording.drawables import drawable_facts, parse_drawables
from granular_env.recording.event_places import event_place
from granular_env.recording.records import EVENTS, HEADER, STEPS, Record


def torn_log(path: Path, ticks: int = 120, **options: object) -> Component:
    """Record a run with numbers, arrays and profiles with patterns as inputs; return the component."""
    component = DISCS.make()
    with record(component, path, **options):  # type: ignore[arg-type]
        component.reset(**DISCS.start)
        drive_component(component, DISCS, ticks)
        component.step(10 * component.step_size, force=0.25)
    return component


def test_a_log_verifies_and_holds_the_arrays(tmp_path: Path) -> None:
    component = torn_log(tmp_path / "a.mcap")
    log = open_log(tmp_path / "a.mcap")
    assert verify(log).identical
    (segment,) = log.segments
    given = {place: held["force"] for place, (_, held) in enumerate(log.step_history(segment)) if held}
    assert given[0].tobytes() == TEAR.tobytes() and given[30].tobytes() == (0.5 * TEAR).tobytes()  # type: ignore[union-attr]
    assert given[60].pattern.tobytes() == TEAR.tobytes()  # type: ignore[union-attr]
    assert given[120].tolist() == np.full((6, 2), 0.25).tolist()  # type: ignore[union-attr]
    assert list(log.input_intervals("force"))[-1].value.tolist() == component.get("force").tolist()  # type: ignore[union-attr]
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
    component = DISCS.make_started()
    with record(component, tmp_path / "a.mcap"):
        component.step(None, force=TEAR)
        with pytest.raises(GranularError):
            component.step(100 * component.step_size, force=1e300)
        drive_component(component, DISCS, 60)
    log = open_log(tmp_path / "a.mcap")
    assert log.events() == component.events() != [] and verify(log).identical


def test_a_restored_component_logs_only_what_is_new(tmp_path: Path) -> None:
    component = DISCS.make_started()
    drive_component(component, DISCS, DISCS.ticks // 2)
    before = component.events()
    with record(component, tmp_path / "a.mcap"):
        drive_component(component, DISCS, DISCS.ticks)
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


@pytest.mark.parametrize(
    "at",
    [
        0.0,
        6.5e-4,
    ],
)
def test_a_branch_with_unchanged_inputs_has_the_parents_bits(tmp_path: Path, at: float) -> None:
    component = torn_log(tmp_path / "a.mcap")
    branch = open_log(tmp_path / "a.mcap").branch(at)
    branch.run(tmp_path / "b.mcap")
    assert state_bits(branch.component) == state_bits(component)
    assert verify(tmp_path / "b.mcap").identical


# -- changes are named --------------------------------------------------------------------------------------------------


def flipped(array: np.ndarray, place: int) -> np.ndarray:
    """Return the array with one bit changed."""
    other = array.copy()
    other.view(np.int64).reshape(-1)[place] ^= 1
    return other


@pytest.mark.parametrize("array", ["0.values", "pattern.0"])
def test_one_changed_bit_of_an_array_input_names_it(tmp_path: Path, array: str) -> None:
    torn_log(tmp_path / "a.mcap", hash_every=1)

    def change(old: Record) -> Record:
        has = old.kind == STEPS and old.arrays.get(array, np.zeros(0)).size
        return change_arrays(old, **{array: flipped(old.arrays[array], 3)}) if has else old

    rewrite_log(tmp_path / "a.mcap", tmp_path / "b.mcap", change)
    result = verify(tmp_path / "b.mcap")
    assert not result.identical and result.variable == "force"


def test_one_changed_bit_of_an_event_is_noticed(tmp_path: Path) -> None:
    torn_log(tmp_path / "a.mcap")
    places = {EVENTS: lambda old: change_arrays(old, rows=flipped(old.arrays["rows"], 3))}
    rewrite_log(tmp_path / "a.mcap", tmp_path / "b.mcap", lambda old: places.get(old.kind, lambda same: same)(old))
    result = verify(tmp_path / "b.mcap")
    assert result.variable == "events" and not result.identical


# -- display ------------------------------------------------------------------------------------------------------------


def test_links_are_logged_and_drawn(tmp_path: Path) -> None:
    torn_log(tmp_path / "a.mcap", variables=["displacement", "speed", "linked"])
    log = open_log(tmp_path / "a.mcap")
    points, links = log.drawables
    assert isinstance(points, Points) and points.reference.shape == (6, 2)
    assert isinstance(links, Links) and links.pairs.tolist() == DISCS.make().drawables()[1].pairs.tolist()  # type: ignore[union-attr]
    assert {"/points/discs", "/links/links"} <= film_topics(tmp_path / "a.mcap").keys()


def test_the_force_of_links_is_recorded_on_request_and_optional_in_a_header(tmp_path: Path) -> None:
    component = torn_log(tmp_path / "a.mcap")
    assert "link_force" not in open_log(tmp_path / "a.mcap").variables
    facts, arrays = drawable_facts(component.drawables())
    assert facts[1]["force"] == "link_force"
    _, links = parse_drawables([facts[0], {name: text for name, text in facts[1].items() if name != "force"}], arrays, {})
    assert isinstance(links, Links) and links.force == ""
    for force in ("speed", 1):  # one value per disc, not per link; not a name
        with pytest.raises(LogError):
            parse_drawables([facts[0], {**facts[1], "force": force}], arrays, component.variables)


# -- hostile logs -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "name", "values"),
    [
        (STEPS, "0.values", np.zeros((2, 6))),
        (STEPS, "0.values", np.full((3, 6, 2), np.nan)),
        (STEPS, "pattern.0", np.zeros((6, 3))),
        (STEPS, "pattern.0", np.full((6, 2), np.inf)),
        (EVENTS, "rows", np.zeros((1, 4))),
        (EVENTS, "rows", np.array([[1e300, 0.0, 0.0, 1.0, 1.0]])),
        (EVENTS, "rows", np.array([[1.0, 7.0, 0.0, 1.0, 1.0]])),
        (HEADER, "1.pairs", np.full((6, 2), 99)),
        (HEADER, "0.radius", np.zeros(4)),
    ],
)
def test_arrays_of_another_form_are_refused(tmp_path: Path, kind: int, name: str, values: np.ndarray) -> None:
    torn_log(tmp_path / "a.mcap", ticks=90)
    rewrite_log(
        tmp_path / "a.mcap",
        tmp_path / "b.mcap",
        lambda old: change_arrays(old, **{name: values}) if old.kind == kind and name in old.arrays else old,
    )
    with pytest.raises(LogError):
        log = open_log(tmp_path / "b.mcap")
        _ = list(log.input_intervals("force")), log.events(), log.drawables


def test_a_profile_times_an_array_and_a_number(tmp_path: Path) -> None:
    """A force as a pattern times a profile, and as an array at each step, differ only by rounding."""
    shaped, stepped = DISCS.make_started(), DISCS.make_started()
    signal = Profile.table([0.0, 0.2, 1.0], [0.0, 1.0, 0.0])
    shaped.step(50 * shaped.step_size, force=TEAR * signal)
    for tick in range(50):
        stepped.step(None, force=signal((tick + 0.5) * stepped.step_size) * TEAR)
    np.testing.assert_allclose(shaped.get("velocity"), stepped.get("velocity"), rtol=1e-12, atol=1e-14)


def test_links_across_a_closed_side_have_their_place_there() -> None:
    shape, closed = {"name": "rectangle", "width": 0.04, "height": 0.02}, {"left": "periodic", "right": "periodic"}
    specimen = ge.make("automata", shape=shape, diameter=0.01, packing="square", boundaries=closed)
    points, links = specimen.drawables()
    assert isinstance(points, Points) and isinstance(links, Links) and points.period.tolist() == [0.04, 0.0]
    lengths = np.sqrt((points.shortest_vectors(links.pairs) ** 2).sum(axis=1))
    assert lengths == pytest.approx(0.01, rel=1e-12)
    across = np.flatnonzero(~points.is_unwrapped(links.pairs))
    assert len(across) == 3, "one in each row"
    detail = EventDetail("1", "links")
    for link in across.tolist():
        place = event_place(link, detail, specimen.drawables())
        assert place is not None and place.position[0] in (pytest.approx(-0.005), pytest.approx(0.035))
