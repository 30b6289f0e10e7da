"""Errors contain their faults as data, with one notation for locations; one rule applies to all numbers."""

from __future__ import annotations

import pickle
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import granular_env as ge
from granular_env.components.errors import Fault, GranularError, ParameterError, location_text, one_line, to_location
from granular_env.experiments import load_experiment
from granular_env.experiments.preparation import branch_inputs, prepare_experiment
from granular_env.log_runs import run_branch
from granular_env.recording import open_log
from granular_env.recording.container import Limits
from granular_env.recording.replay import advance_to_tick, make_component, restore_snapshot

NAN = float("nan")
ROW = "discs/broken-row"
MASKED = np.ma.masked_array(np.ones((8, 2)), mask=[[True, False]] * 8)
DISCS = {"name": "x", "duration": 1e-4, "component": {"type": "discs"}}


def faults(action: Callable[[], Any]) -> tuple[Fault, ...]:
    """Return the faults of the error that an action raises."""
    with pytest.raises(GranularError) as caught, warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        action()
    assert "\n" not in one_line(str(caught.value)) and "array(" not in str(caught.value)
    return caught.value.faults


def fault(action: Callable[[], Any]) -> Fault:
    """Return the only fault."""
    (one,) = faults(action)
    return one


@pytest.fixture
def discs() -> ge.Component:
    return ge.make("discs")


# -- locations --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "location"),
    [
        ("input.force[0,1]", ("input", "force", 0, 1)),
        ("stop[0].variable", ("stop", 0, "variable")),
    ],
)
def test_a_location_is_written_in_one_way(text: str, location: tuple[str | int, ...]) -> None:
    assert to_location(text) == location and location_text(location) == text


def test_an_error_keeps_its_faults_between_processes() -> None:
    error = ParameterError("got 1", expected="2", hint="give 2", at="a[3]", source="b")
    assert pickle.loads(pickle.dumps(error)).faults == error.faults == (Fault(("a", 3), "got 1", "2", "give 2", "b"),)
    for again in (type(error)(error), pickle.loads(pickle.dumps(type(error)(error)))):  # as raised by gymnasium.AsyncVectorEnv
        assert again.faults == error.faults and str(again) == str(error)
    step = ge.StepError("too fast", time=1.0, variable="velocity", index=3, value=2.0, limit=1.0)
    assert vars(pickle.loads(pickle.dumps(step))) == vars(step)


# -- data for front ends ----------------------------------------------------------------------------------------------

ONE_NAN = np.where(np.arange(16).reshape(8, 2) == 15, NAN, 0.0)
CALLS: dict[str, tuple[Callable[[ge.Component], Any], tuple[str | int, ...], str, str, str]] = {
    "nan in an input": (lambda c: c.step(None, force=ONE_NAN), ("input", "force", 7, 1), "got nan", "a finite number", ""),
    "shape": (
        lambda c: c.step(None, force=np.ones(3)),
        ("input", "force"),
        "got an array of shape (3,)",
        "a number, an array of shape (8, 2) or a Profile",
        "",
    ),
    "unknown input": (lambda c: c.step(None, forc=1.0), ("input", "forc"), "unknown", "", "did you mean 'force'?"),
    "duration": (lambda c: c.step(-1.0), ("duration",), "got -1.0 s", "more than 0 and finite", ""),
    "law": (
        lambda c: ge.make("chain", grains=3, law={"name": "power", "exponent": "2"}),
        ("law", "exponent"),
        "got '2'",
        "a number",
        "",
    ),
    "preset": (
        lambda c: ge.make("chain", grains=3, material="stel"),
        ("material",),
        "got 'stel'",
        "the name of a preset",
        "did you mean 'steel'? or give density, young and poisson",
    ),
    "stop": (
        lambda c: prepare_experiment(load_experiment({**DISCS, "stop": [{"variable": "sped", "above": 1.0}]})),
        ("stop", 0, "variable"),
        "got 'sped'",
        "an output of component 'discs'",
        "did you mean 'speed'?",
    ),
}


@pytest.mark.parametrize("name", CALLS)
def test_a_fault_says_where_what_came_what_was_expected_and_what_to_do(discs: ge.Component, name: str) -> None:
    action, *parts = CALLS[name]
    found = fault(lambda: action(discs))
    assert [found.location, found.received, found.expected, found.hint] == parts


# -- numbers ----------------------------------------------------------------------------------------------------------

NO_NUMBERS = {
"truth": True,
"text": "3",
"masked": MASKED,
"too large": 10**400,
"too wide": np.longdouble("1e4000"),
"complex": np.ones((8, 2), complex),
}  # fmt: skip


@pytest.mark.parametrize("name", NO_NUMBERS)
def test_what_is_no_number_is_refused_wherever_it_is_given(discs: ge.Component, name: str) -> None:
    value, before = NO_NUMBERS[name], discs.state_view().tobytes()
    assert fault(lambda: discs.step(None, force=value)).location[:2] == ("input", "force")
    assert fault(lambda: discs.reset(velocity=value)).location[:2] == ("start", "velocity")
    assert fault(lambda: ge.Profile.constant(1.0) * value)
    assert discs.state_view().tobytes() == before


@pytest.mark.parametrize("value", ["3", True, np.True_, [3], 3.5, b"3"])
def test_a_parameter_that_is_a_number_is_no_text_and_no_truth_value(value: object) -> None:
    assert fault(lambda: ge.make("discs", rows=value)).expected.startswith("a whole number")
    assert value == 3.5 or fault(lambda: ge.make("discs", mass=value)).location == ("mass",)
    assert value == 3.5 or fault(lambda: ge.Material(density=value, young=1e9, poisson=0.2)).location == ("density",)


def test_all_faults_of_parameters_are_told_at_once() -> None:
    found = faults(lambda: ge.make("discs", rows="3", mass=True, colums=3))
    assert [one.location for one in found] == [("rows",), ("mass",), ("colums",)]


@pytest.mark.parametrize(
    ("component", "parameters", "expected"),
    [
        ("detonation", {"gas": {"gamma": "abc", "gas_constant": -1.0}}, [("gas", "gamma"), ("gas", "gas_constant")]),
        ("detonation", {"cross_section": [1e-3, "a", 1e-3]}, [("cross_section", 1)]),
        ("grid", {"material": ["steel", {"density": "abc", "young": 1e9, "poisson": 0.3}]}, [("material", 1, "density")]),
    ],
)
def test_a_fault_of_a_table_or_a_list_is_located_in_it_where_a_name_or_a_number_could_stand(
    component: str, parameters: dict[str, Any], expected: list[tuple[str | int, ...]]
) -> None:
    assert [one.location for one in faults(lambda: ge.make(component, **parameters))] == expected


@pytest.mark.parametrize("value", [{0: [1.0, 1.0], "0,1": 2.0}, {"0,1": 2.0, -8: 1.0}, {3: 1.0, "3": 2.0}])
def test_an_element_is_given_once(discs: ge.Component, value: dict[Any, Any]) -> None:
    assert fault(lambda: discs.reset(velocity=value)).expected == "each element once"


def test_a_whole_number_beyond_64_bits_is_a_number() -> None:
    ready = prepare_experiment(load_experiment({**DISCS, "input": {"force": [[10**20, 1]] * 8}}))
    assert ready.inputs["force"][0].tolist() == [1e20, 1.0]


def test_a_variable_is_recorded_once(discs: ge.Component, tmp_path) -> None:
    assert fault(lambda: ge.record(discs, tmp_path / "x.mcap", variables=["speed", "speed"])).location == ("variables", 1)
    assert not list(tmp_path.iterdir())


# -- elements of inputs -----------------------------------------------------------------------------------------------


def test_an_element_of_an_input_has_one_name(tmp_path) -> None:
    document = {**DISCS, "duration": 1e-3, "input": {"force": {"0": [1.0, 2.0], "3,1": 5.0}}}
    held = prepare_experiment(load_experiment(document)).inputs["force"]
    assert held[0].tolist() == [1.0, 2.0] and held[3].tolist() == [0.0, 5.0] and held.sum() == 8.0
    overrides = {"input.force[0,1]": 3.0, "input.force[3]": [6.0, 7.0], "input.force[-1,0]": 4.0}
    held = prepare_experiment(load_experiment(document, overrides)).inputs["force"]
    assert held[0].tolist() == [1.0, 3.0] and held[3].tolist() == [6.0, 7.0] and held[7].tolist() == [4.0, 0.0]
    alone = prepare_experiment(load_experiment(DISCS, {"input.force[0,1]": 3.0})).inputs["force"]
    assert alone[0, 1] == alone.sum() == 3.0
    ge.run(document, log=tmp_path / "discs.mcap")
    with open_log(tmp_path / "discs.mcap") as log:
        begun = log.branch(5e-4)
        inputs = branch_inputs({"input.force[1,1]": 9.0}, begun.component)
        result = run_branch(begun, tmp_path / "branch.mcap", inputs, None, progress=False)
    assert result.component.get("force")[:2].tolist() == [[1.0, 2.0], [0.0, 9.0]]


def test_an_element_of_a_profile_is_set_in_its_pattern() -> None:
    found = fault(lambda: load_experiment(ROW, {"input.force[0,1]": 2.0}))
    assert found.location == ("input", "force", 0, 1) and "pattern[0,1]" in found.hint
    pattern = prepare_experiment(load_experiment(ROW, {"input.force.pattern[0,1]": 2.0})).inputs["force"].pattern
    assert pattern[0, 1] == 2.0


# -- origin of errors -------------------------------------------------------------------------------------------------


def test_what_the_content_of_a_log_gives_keeps_its_data() -> None:
    oscillator, other = ge.make("oscillator"), ge.make("oscillator", mass=2.0)
    with pytest.raises(ge.LogError) as caught:
        restore_snapshot(oscillator, other.save())
    (fault,) = caught.value.faults
    assert fault.location == ("snapshots",) and "same parameters and version" in str(fault.hint)
    with pytest.raises(ge.LogError) as caught:
        advance_to_tick(oscillator, [(0, {"force": NAN})], 3)
    (fault,) = caught.value.faults
    assert fault.location == ("steps", "input", "force") and "nan" in str(fault.received) and fault.expected
    with pytest.raises(ge.LogError) as caught:
        make_component({"component": "oscillator", "parameters": {"mass": -1.0}}, Limits("x.mcap"), None)
    assert caught.value.faults[0].location == ("header", "parameters", "mass") and "x.mcap" in str(caught.value)
