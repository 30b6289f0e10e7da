"""What an author declares of a component is checked when one is built; what a component holds nobody else can change."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import granular_env as ge
from granular_env.components.balances import Balance
from granular_env.components.component import Component
from granular_env.components.discs import Discs
from granular_env.components.drawables import Cells, Curve, Drawable, Links, Points
from granular_env.components.errors import ParameterError, StepError
from granular_env.components.events import EventDetail
from granular_env.components.oscillator import OscillatorParameters
from granular_env.components.state_block import Block
from granular_env.components.variables import Variable

EVENTFUL: dict[str, Any] = {"event_kinds": {"event": "text"}}


def drawing(change: Callable[[Points, Links], tuple[Drawable, ...]]) -> type[Discs]:
    class Drawn(Discs):
        def drawables(self) -> tuple[Drawable, ...]:
            points, links = super().drawables()
            assert isinstance(points, Points) and isinstance(links, Links)
            return change(points, links)

    return Drawn


def renamed(drawable: Any, **fields: Any) -> Any:
    return dataclasses.replace(drawable, **fields)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda p, k: (p, renamed(k, points="zzz")), "drawables.links.points: got 'zzz', expected one of discs"),
        (lambda p, k: (p, renamed(k, pairs=k.pairs + 5)), "expected rows of indices from 0 to 7"),
        (lambda p, k: (p, renamed(k, pairs=k.pairs - 1)), "drawables.links.pairs: got"),
        (
            lambda p, k: (p, renamed(k, state="speed")),
            "drawables.links.state: got 'speed' of shape (8,), expected a row for each of the 10",
        ),
        (lambda p, k: (renamed(p, colour="colour"), k), "drawables.discs.colour: got 'colour', expected the name of an output"),
        (lambda p, k: (renamed(p, displacement="linked"), k), "drawables.discs.displacement: got 'linked' of shape"),
        (
            lambda p, k: (renamed(p, radius=p.radius[:3]), k),
            "drawables.discs.radius: got shape (3,), expected one for each of the 8 points",
        ),
        (
            lambda p, k: (renamed(p, reference=np.zeros((8, 5))), k),
            "drawables.discs.reference: got shape (8, 5), expected a row for each of at least one, of 1 to 3 columns",
        ),
        (lambda p, k: (Cells("c", p.reference, np.array([[0, 1, 8]]), "speed"),), "drawables.c.connectivity: got"),
        (
            lambda p, k: (Cells("c", p.reference, np.array([[0, 1, 2]]), "speed", state="linked"),),
            "drawables.c.state: got 'linked' of shape (10,), expected one for each of the 1 cells",
        ),
        (lambda p, k: (Curve("c", np.zeros(3), "speed"),), "drawables.c.field: got 'speed' of shape"),
        (lambda p, k: (p, renamed(k, name="discs")), "drawables.discs.name: got 'discs' again, expected each name once"),
        (lambda p, k: (p, renamed(k, pairs=1.0 * k.pairs)), "drawables.links.pairs: got float64, expected whole numbers"),
        (lambda p, k: (renamed(p, radius=-p.radius), k), "drawables.discs.radius: got -0.01, expected no negative one"),
        (
            lambda p, k: (renamed(p, reference=np.where(p.reference == p.reference[3], np.nan, p.reference)), k),
            "drawables.discs.reference: got nan at [0, 1], expected finite numbers",
        ),
        (lambda p, k: (Curve("c", np.full(8, np.inf), "speed"),), "drawables.c.coordinate: got inf at [0]"),
        (
            lambda p, k: (p, renamed(k, pairs=np.zeros((10, 3), int))),
            "drawables.links.pairs: got shape (10, 3), expected two columns",
        ),
        (lambda p, k: (p, renamed(k, state="")), "drawables.links.state: got '', expected the name of an output"),
        (lambda p, k: (renamed(p, displacement=""), k), "drawables.discs.displacement: got '', expected the name"),
        (lambda p, k: (Cells("c", p.reference, np.array([[0, 1, 2]]), ""),), "drawables.c.field: got ''"),
        (
            lambda p, k: (Cells("c", p.reference, np.array([[0, 1, 2]]), "linked"),),
            "drawables.c.field: got 'linked' of shape (10,), expected one for each of the 1 cells, or of the 8 nodes",
        ),
        (lambda p, k: (Cells("c", p.reference, np.zeros((0, 3), int), "speed"),), "drawables.c.connectivity: got no cells"),
        (lambda p, k: (renamed(p, radius=["a"] * 8), k), "drawables.discs.radius: got an array of <U1, expected numbers"),
        (
            lambda p, k: (Points("none", np.zeros((0, 2)), np.zeros(0), "displacement"),),
            "drawables.none.reference: got shape (0, 2), expected a row for each of at least one",
        ),
        (lambda p, k: (p, "links"), "drawables: got 'links', expected Points, Links, Cells or Curve"),
    ],
)
def test_drawables_that_do_not_fit_are_refused(change: Any, message: str) -> None:
    with pytest.raises(ParameterError) as error:
        drawing(change)()
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("balance", "message"),
    [
        (Balance("heat", "J", {}), "balances.heat.stored: got no entry"),
        (Balance("heat", "J", {"speed": 1.0}), "balances.heat.speed: another variable has this name"),
        (Balance("heat", "J", {"mass": 1.0}), "balances.heat.mass: another variable has this name"),
        (Balance("warmth", "kg", {"kinetic_energy": 1.0}), "balances.warmth.kinetic_energy: another variable has this name"),
        (Balance("energy", "J", {"heat": 1.0}), "balances.energy: given twice, expected each quantity once"),
        (
            Balance("heat", "J", {"one": np.zeros(2)}, {"other": np.zeros(3)}),
            "balances.heat.other: got the shape (3,), expected (2,), as the other entries",
        ),
        (None, "balances: got (Balance("),
    ],
)
def test_balances_that_do_not_fit_are_refused(balance: Any, message: str) -> None:
    class Balanced(Discs):
        def balances(self) -> tuple[Balance, ...]:
            return (*super().balances(), balance)

    with pytest.raises(ParameterError) as error:
        Balanced()
    assert message in str(error.value)


def test_an_output_of_its_own_is_no_entry_of_a_balance() -> None:
    """Nobody could tell which of the two values is read; an entry that is declared for its description alone is one value."""
    fracture = Variable("fracture_energy", "output", "J", (), "energy of the links that are broken")
    assert declaring(fracture)().variables["fracture_energy"].description == fracture.description
    with pytest.raises(ParameterError, match="balances.energy.fracture_energy: another variable has this name; give one of"):
        declaring(fracture, fracture_energy=lambda: 2.0)()
    with pytest.raises(ParameterError, match="balances.energy.x: another variable has this name"):
        type("Made", (Slip,), {"entries": {"x": 1.0}, "unit": "J"})()


@pytest.mark.parametrize(
    ("kind", "index", "value", "limit"),
    [
        ("nope", 1, 1.0, 0.5),
        ("link_broken", -7, 1.0, 0.5),
        ("link_broken", 2**70, 1.0, 0.5),
        ("link_broken", 1, float("nan"), 0.5),
        ("link_broken", 1, 1.0, float("inf")),
    ],
)
def test_events_that_no_log_could_hold_are_refused(kind: str, index: int, value: float, limit: float) -> None:
    discs = Discs()
    with pytest.raises(ParameterError, match="event"):
        discs._add_event(1, kind, index, value, limit)
    assert discs.event_count == 0


def test_a_component_holds_a_copy_of_an_array() -> None:
    discs = Discs()
    force = np.ones((8, 2))
    force.setflags(write=False)
    discs.step(1e-4, force=force)
    force.setflags(write=True)
    force[:] = np.nan
    np.testing.assert_array_equal(discs.held_inputs["force"], np.ones((8, 2)))
    discs.step(1e-4)


def test_drawables_are_closed_to_writing() -> None:
    discs = Discs()
    points, links = discs.drawables()
    for array in (points.reference, points.radius, links.pairs):  # type: ignore[union-attr]
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    # Whoever opens them writes to a copy.
    assert discs.reference.flags.writeable and not np.shares_memory(discs.reference, points.reference)  # type: ignore[union-attr]


def declaring(*more: Variable, **outputs: Callable[[], Any]) -> type[Discs]:
    class Declared(Discs):
        def _declare(self) -> Iterable[Variable]:
            yield from super()._declare()
            yield from more

        def _outputs(self) -> dict[str, Callable[[], Any]]:
            return {**super()._outputs(), **outputs}

    return Declared


HEAT = Variable("heat", "output", "J", (), "heat")


@pytest.mark.parametrize(
    ("variable", "message"),
    [
        (HEAT, "variables.heat: nothing says how to read it, expected a way to read each output; let `_outputs` give it"),
        (dataclasses.replace(HEAT, name="Heat Flow"), "variables.Heat Flow: this is its name, expected small letters"),
        (dataclasses.replace(HEAT, name="speed"), "variables.speed: declared twice"),
        (dataclasses.replace(HEAT, name="stiffness"), "variables.stiffness: a parameter has this name"),
        (dataclasses.replace(HEAT, causality="inpt"), "variables.heat: got the causality 'inpt', expected 'input' or 'output'"),
        (dataclasses.replace(HEAT, unit=""), "variables.heat: got no unit, expected such as 'm/s', or '1'"),
        (dataclasses.replace(HEAT, shape=(2.5,)), "variables.heat: got the shape (2.5,), expected a tuple of whole numbers"),
        (dataclasses.replace(HEAT, axes=("disc",)), "variables.heat: got the axes ('disc',), expected a name for each index"),
        (dataclasses.replace(HEAT, minimum=1.0, maximum=0.0), "variables.heat: got values from 1 to 0"),
        (dataclasses.replace(HEAT, description=""), "variables.heat: got no description"),
        (dataclasses.replace(HEAT, dtype="int32"), "variables.heat: got the dtype 'int32', expected 'float64'"),
        (dataclasses.replace(HEAT, shape=[2]), "variables.heat: got the shape [2], expected a tuple of whole numbers"),
        (dataclasses.replace(HEAT, causality="parameter"), "variables.heat: got the causality 'parameter', expected a field"),
        (dataclasses.replace(HEAT, name="duration", causality="input"), "variables.duration: `step` and `reset` take"),
        (dataclasses.replace(HEAT, name="seed", state=True), "variables.seed: `step` and `reset` take"),
    ],
)
def test_variables_that_do_not_fit_are_refused(variable: Variable, message: str) -> None:
    with pytest.raises(ParameterError) as error:
        declaring(variable)()
    assert message in str(error.value)
    assert declaring(HEAT, heat=lambda: 2.0)().get("heat") == 2.0


def test_an_output_that_nobody_declared_is_refused() -> None:
    with pytest.raises(ParameterError, match="variables.spede: `_outputs` gives it, `_declare` does not.* 'speed'"):
        declaring(spede=lambda: 2.0)()


class Slip(Component):
    """A component of one number, in which every test makes one slip."""

    name = "slip"
    Parameters = OscillatorParameters
    layout: ClassVar[dict[str, Any]] = {"x": ("f8", ())}
    shape: ClassVar[tuple[int, ...]] = ()
    length: ClassVar[Any] = 1e-3
    unit: ClassVar[str] = "m"
    entries: ClassVar[dict[str, float]] = {"kinetic_energy": 1.0}
    late_kinds: ClassVar[dict[str, str]] = {}

    def _build(self) -> None:
        self.step_size = type(self).length
        if self.layout:
            self._lay_out(**self.layout)
        if self.late_kinds:
            self._declare_events(self.late_kinds, {})

    def _declare(self) -> Iterable[Variable]:
        yield Variable("x", "output", self.unit, self.shape, "place", state=True)

    def _advance(self, ticks: int) -> int:
        self._block["x"] += 1.0
        if "event" in self.event_kinds:
            self._add_event(self.tick + 1, "event", None, 1.0, 1.0)
        return 0

    def _explain(self, status: int) -> StepError:
        raise AssertionError

    def balances(self) -> tuple[Balance, ...]:
        return (Balance("energy", "J", self.entries, initial=1.0),)


@pytest.mark.parametrize(
    ("slip", "message"),
    [
        ({"layout": {}}, "component 'slip': state: it is not laid out; call `_lay_out` in `_build`"),
        ({"layout": {"x": ("f4", (3,))}}, "state.x: got the type 'f4', expected 'f8', 'i8' or 'u8'"),
        ({"layout": {"x": ("?", ())}}, "state.x: got the type '?'"),
        ({"layout": {"y": ("f8", ())}}, "variables.x: nothing says how to read it"),
        ({"shape": (3,)}, "variables.x: got the shape (3,), expected (), as its part of the state has"),
        ({"length": -1.0}, "step_size: got -1.0, expected more than 0 and finite"),
        ({"length": None}, "step_size: got None"),
        ({"length": float("nan")}, "step_size: got nan"),
        ({"late_kinds": {"event": "text"}}, "event_kinds: got event, expected a list of the state to note them in; `_lay"),
        (
            {"event_kinds": {"event": "text"}, "layout": {"x": ("f8", ()), "growing": {"events": ("f8", (4,))}}},
            "event_kinds: got event",
        ),
        ({"event_details": {"evnt": EventDetail("J")}}, "event_details.evnt: there is no such kind"),
        (
            EVENTFUL | {"event_details": {"event": EventDetail("J", counts="links")}},
            "event_details.event.counts: got 'links', expected the name of a drawable",
        ),
        (
            EVENTFUL | {"event_details": {"event": EventDetail("J", ratio="rato")}},
            "event_details.event.ratio: got 'rato', expected the name of an output",
        ),
    ],
)
def test_a_slip_of_an_author_is_told_by_name(slip: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError) as error:
        type("Made", (Slip,), slip)()
    assert message in str(error.value)


def test_a_part_of_the_state_is_written_as_any_array_is() -> None:
    made = type("Made", (Slip,), EVENTFUL)()
    made.step(3e-3)
    assert made.get("x") == 1.0 and [event.kind for event in made.events()] == ["event"]


def test_an_entry_of_a_balance_that_is_gone_is_named() -> None:
    made = Slip()
    assert made.get("kinetic_energy") == 1.0
    made.__class__ = type("Made", (Slip,), {"entries": {"potential_energy": 1.0}})
    with pytest.raises(ge.GranularError, match="balances: balances\\(\\) gave 'kinetic_energy' at the reset and does not now"):
        made.get("kinetic_energy")


def test_an_output_of_another_shape_than_declared_is_not_recorded(tmp_path: Path) -> None:
    class Misshapen(Discs):
        def _outputs(self) -> dict[str, Callable[[], Any]]:
            return {**super()._outputs(), "speed": lambda: np.zeros(3)}

    path = tmp_path / "a.mcap"
    with pytest.raises(ParameterError, match=r"variables.speed: it has the shape \(3,\), expected \(8,\), as"):
        ge.record(Misshapen(), path)
    assert not path.exists()


def test_points_and_nodes_along_a_line_are_columns(tmp_path: Path) -> None:
    row = Points("discs", np.arange(8.0), np.ones(8), "speed")
    assert row.reference.shape == (8, 1)
    assert Cells("c", np.arange(3.0), np.array([[0, 1], [1, 2]]), "speed").nodes.shape == (3, 1)
    with ge.record(drawing(lambda p, k: (row, k))(), tmp_path / "a.mcap"):
        pass
    drawn, _ = ge.open_log(tmp_path / "a.mcap").drawables
    np.testing.assert_array_equal(drawn.reference, row.reference)


def test_a_list_has_no_more_rows_than_room() -> None:
    block = Block(growing={"slips": ("f8", (3,))}, fixed=("f8", ()))
    with pytest.raises(ValueError, match=r"the list 'slips' has room for \d+ rows, got 5000: call `room` first"):
        block.set_count("slips", 5000)
    with pytest.raises(ValueError, match="there is no list 'slip' that grows; known: slips"):
        block.append("slip", (1.0, 2.0, 3.0))
    block.append("slips", (1.0, 2.0, 3.0))
    assert block.count("slips") == 1
