"""Parts of the contract that no single component covers: errors, blocks, start values, the catalogue."""

from __future__ import annotations

import inspect
import threading
from importlib.metadata import EntryPoint

import numpy as np
import pytest

from granular_env.components import catalogue, errors
from granular_env.components.component import Component
from granular_env.components.discs import Discs
from granular_env.components.errors import GranularError, ParameterError
from granular_env.components.number_arrays import start_array
from granular_env.components.oscillator import Oscillator
from granular_env.components.state_block import Block


def test_every_error_is_of_the_family() -> None:
    found = [kind for _, kind in inspect.getmembers(errors, inspect.isclass) if issubclass(kind, Exception)]
    for kind in found:
        assert issubclass(kind, GranularError) or issubclass(kind, Warning)
    assert issubclass(errors.ParameterError, ValueError) and issubclass(errors.StepError, ArithmeticError)


def test_nearest_names_one_or_lists_all() -> None:
    assert errors.spelling_hint("velocty", ["position", "velocity"]) == "did you mean 'velocity'?"
    assert errors.spelling_hint("q", ["b", "a"]) == "known: a, b"
    assert errors.spelling_hint("q", []) == "known: none"


def test_a_block_is_one_memory_with_views() -> None:
    block = Block(first=("f8", (2, 3)), count=("i8", (), -1, 9), last=("f8", (1,)))
    assert block.memory.shape == (8,)
    block["first"][1, 2], block["count"][...], block["last"][0] = 5.0, -1, 7.0
    assert block.memory[5] == 5.0 and block.memory[7] == 7.0
    assert block.memory.view(np.int64)[6] == -1
    copy = block.memory.copy()
    block["count"][...] = 9
    block.memory[:] = copy
    assert int(block["count"]) == -1


def test_a_state_that_grows_is_restored_with_its_rows() -> None:
    block = Block(growing={"rows": ("f8", (2,)), "none": ("f8", ())}, fixed=("f8", (1000,)))
    block["fixed"] = 3.0
    block.append("rows", [1.0, 2.0])
    before = block.to_bytes()
    block.back_up()
    for _ in range(40):
        block["fixed"] += 1.0
        block.append("rows", [5.0, 6.0])
        block.append("none", 7.0)
    block.restore_backup()
    assert block.to_bytes() == before and block.count("rows") == 1 and block.count("none") == 0


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (2, [2, 2, 2]),
        ([1, 2, 3], [1, 2, 3]),
        ({-1: 4}, [0, 0, 4]),
        ({"1": 4}, [0, 4, 0]),
    ],
)
def test_start_values_fill_an_array(value: object, expected: list[float]) -> None:
    assert start_array("x", value, (3,)).tolist() == expected


@pytest.mark.parametrize(
    "value",
    [
        {3: 1.0},
        {"a": 1.0},
        [1, 2],
    ],
)
def test_wrong_start_values_are_refused(value: object) -> None:
    with pytest.raises(ParameterError, match="start.x"):
        start_array("start.x", value, (3,))


# -- catalogue --------------------------------------------------------------------------------------------------------

OURS = catalogue.component_names()


def test_the_catalogue_makes_what_it_names() -> None:
    assert {"chain", "discs", "oscillator"} <= set(OURS)
    component = catalogue.make("oscillator", mass=3.0)
    assert type(component) is Oscillator and component.get("mass") == 3.0


@pytest.mark.parametrize(
    ("name", "advice"),
    [
        ("oscilator", "did you mean 'oscillator'"),
        (None, "known"),
    ],
)
def test_unknown_components_are_refused(name: object, advice: str) -> None:
    with pytest.raises(ParameterError, match=advice):
        catalogue.make(name)  # type: ignore[arg-type]


@pytest.fixture
def foreign(monkeypatch: pytest.MonkeyPatch):  # noqa: ANN201
    """Simulate components installed by a third party."""

    def install(**points: str) -> None:
        found = [EntryPoint(name, value, catalogue.ENTRY_POINT_GROUP) for name, value in points.items()]
        monkeypatch.setattr(catalogue, "_plugin_entry_points", lambda: found)

    return install


def test_third_parties_add_their_own(foreign) -> None:  # noqa: ANN001
    foreign(pendulum="granular_env.components.oscillator:Oscillator")
    assert catalogue.component_names() == [*OURS, "pendulum"]
    assert isinstance(catalogue.make("pendulum"), Component)


def test_third_parties_cannot_replace_ours(foreign) -> None:  # noqa: ANN001
    foreign(oscillator="json:loads")
    assert catalogue.component_names() == OURS
    assert catalogue.component_class("oscillator") is Oscillator


@pytest.mark.parametrize(
    "value",
    [
        "no_such_module:X",
        "json:loads",
    ],
)
def test_broken_third_parties_are_named(foreign, value: str) -> None:  # noqa: ANN001
    foreign(theirs=value)
    with pytest.raises(ParameterError, match=f"'theirs'.*{value}"):
        catalogue.make("theirs")
    assert value in catalogue.component_summary("theirs")  # a list of all components still contains it


# -- attributes and arrays ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["stiffness", "force", "parameters"])
def test_a_variable_cannot_be_set_as_an_attribute(name: str) -> None:
    with pytest.raises(ParameterError, match=rf"^{name}: cannot be set; .*step\(duration, {name}=...\)"):
        setattr(Oscillator(), name, 50.0)


def test_a_component_holds_a_copy_of_an_array() -> None:
    discs = Discs()
    force = np.ones((8, 2))
    discs.step(1e-4, force=force)
    force[:] = np.nan
    np.testing.assert_array_equal(discs.held_inputs["force"], np.ones((8, 2)))
    discs.step(1e-4)


def test_drawables_are_read_only_copies() -> None:
    discs = Discs()
    points, links = discs.drawables()
    for array in (points.reference, points.radius, links.pairs):  # type: ignore[union-attr]
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    assert discs.reference.flags.writeable and not np.shares_memory(discs.reference, points.reference)  # type: ignore[union-attr]


# -- steps and notifications --------------------------------------------------------------------------------------------


class Bystander:
    """An observer that counts its notifications, and raises errors on request."""

    def __init__(self, raises: str = "") -> None:
        self.raises, self.told, self.next_tick = raises, [], 1 << 60

    def _note(self, what: str) -> None:
        self.told.append(what)
        if what == self.raises:
            raise RuntimeError(what)

    def on_reset(self, component: Component) -> None:
        pass

    def on_sample(self, component: Component) -> None:
        pass

    def on_step(self, component: Component, ticks: int, inputs: object) -> None:
        self._note("on_step")

    def on_failure(self, component: Component, error: BaseException) -> None:
        self._note("on_failure")


def test_a_step_stands_when_an_observer_raises_after_it() -> None:
    oscillator = Oscillator()
    oscillator.observe(Bystander("on_step"))
    with pytest.raises(RuntimeError, match="on_step"):
        oscillator.step(3 * oscillator.step_size)
    assert oscillator.tick == 3


def test_a_component_is_stepped_by_one_at_a_time() -> None:
    oscillator, seen = Oscillator(), []

    class Meddler(Bystander):
        def on_step(self, component: Component, ticks: int, inputs: object) -> None:
            other = threading.Thread(target=self.meddle, args=(component,))
            other.start()
            other.join()

        def meddle(self, component: Component) -> None:
            with pytest.raises(GranularError, match="in the middle of a step.*a separate component in each thread"):
                component.step()
            seen.append(component.tick)

    oscillator.observe(Meddler())
    oscillator.step(2 * oscillator.step_size)
    oscillator.step()
    assert seen == [2, 3] and oscillator.tick == 3
