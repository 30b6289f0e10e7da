"""What an author declares of a component is checked when one is built; what a component holds nobody else can change."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import granular_env as ge
from granular_env.components.balances import Balance
from granular_env.components.discs import Discs
from granular_env.components.drawables import Cells, Curve, Drawable, Links, Points
from granular_env.components.errors import ParameterError


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
            "drawables.discs.reference: got shape (8, 5), expected up to 3 columns",
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
        (Balance("energy", "kg", {"kinetic_energy": 1.0}), "balances.energy.kinetic_energy: another variable has this name"),
    ],
)
def test_balances_that_do_not_fit_are_refused(balance: Balance, message: str) -> None:
    class Balanced(Discs):
        def balances(self) -> tuple[Balance, ...]:
            return (*super().balances(), balance)

    with pytest.raises(ParameterError) as error:
        Balanced()
    assert message in str(error.value)


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


def test_an_output_of_another_shape_than_declared_is_not_recorded(tmp_path: Path) -> None:
    class Misshapen(Discs):
        def _outputs(self) -> dict[str, Callable[[], Any]]:
            return {**super()._outputs(), "speed": lambda: np.zeros(3)}

    path = tmp_path / "a.mcap"
    with pytest.raises(ParameterError, match=r"variables.speed: it has the shape \(3,\), expected \(8,\), as"):
        ge.record(Misshapen(), path)
    assert not path.exists()
