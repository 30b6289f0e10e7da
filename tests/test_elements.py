"""An array element has the same name in stop rules, measures, overrides, start values and tasks."""

from __future__ import annotations

import numpy as np
import pytest

import granular_env as ge
from granular_env.components.errors import ExperimentError, ParameterError
from granular_env.components.variables import Element, Variable, parse_element, parse_index
from granular_env.envs import ComponentEnv, Task
from granular_env.experiments import load_experiment
from granular_env.recording.element_arrays import listed_positions
from granular_env.viewing.curves import component_names
from granular_env.viewing.places import element_label

ROW = "discs/broken-row"
VELOCITY = Variable("velocity", "output", "m/s", (10, 2), "velocity", axes=("disc", "direction"))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "velocity[",
        "velocity[a]",
        "velocity[1:3]",
        None,
    ],
)
def test_other_texts_are_refused(text: object) -> None:
    with pytest.raises(ParameterError, match="expected"):
        parse_element(text)


@pytest.mark.parametrize(
    "given",
    [
        "x",
        1.5,
        10**400,
    ],
)
def test_what_is_no_index_is_refused(given: object) -> None:
    with pytest.raises(ParameterError, match="whole number for each axis"):
        parse_index(given)


@pytest.mark.parametrize("index", [(10, 0), (0, 2), (0,), (0, 0, 0), (-11, 0)])
def test_an_index_outside_names_the_axes(index: tuple[int, ...]) -> None:
    with pytest.raises(ParameterError, match=r"expected an index of 2 numbers: -10 to 9 \(disc\), -2 to 1 \(direction\)"):
        Element("velocity", index).check_variable(VELOCITY)


def test_overrides_set_one_element() -> None:
    overrides = {
        "start.velocity[4,1]": 0.25,
        "start.velocity[0]": [1.0, 2.0],
        "input.force.pattern[9,0]": 3.0,
        "input.force.pattern[-1,1]": 4,
    }
    experiment = load_experiment(ROW, overrides)
    assert experiment.start["velocity"] == {"4,1": 0.25, "0": [1.0, 2.0]}
    pattern = experiment.to_dict()["input"]["force"]["pattern"]
    assert pattern[9] == [3.0, 4] and pattern[0] == [-1, 0]
    component = ge.run(ROW, overrides={**overrides, "duration": 1e-5}).component
    assert component.get("velocity")[4, 1] == pytest.approx(0.25, rel=1e-3)
    with pytest.raises(ExperimentError, match=r"got the index '10', expected -10 to 9"):
        load_experiment(ROW, {"input.force.pattern[10,0]": 3.0})
    with pytest.raises(
        ExperimentError,
        match=r"^override 'start.velocity\[4,2\]=1.0': start.velocity\[4,2\]: there is no such element",
    ):
        ge.run(ROW, overrides={"start.velocity[4,2]": 1.0})


class Tear(Task):
    """Pull the ends along x; observe one link and one velocity."""

    name = "tear"
    actions = {"force[0,0]": 1.0, "force[-1,0]": 2.0}
    observations = {"linked[0]": 1.0, "velocity[2,0]": 0.5, "displacement": 1.0}

    def begin_episode(self, component, seen):
        self.counters = {}

    def evaluate_step(self, component, seen, duration):
        return float(seen["velocity[2,0]"]), bool(seen["linked[0]"] == 0.0)


def test_a_task_drives_and_sees_elements() -> None:
    env = ComponentEnv(ge.make("discs", rows=1, columns=3), Tear(), deadline=50)
    assert env.action_space.shape == (2,) and env.observation_space.shape == (2 + 6,)
    env.reset(seed=0)
    observation, reward, _, _, info = env.step([-1.0, 1.0])
    assert env.component.get("force").tolist() == [[-1.0, 0.0], [0.0, 0.0], [2.0, 0.0]]
    velocity = env.component.get("velocity")[2, 0]
    assert reward == info["velocity[2,0]"] == velocity > 0.0 and observation[1] == pytest.approx(velocity / 0.5)
    with pytest.raises(ParameterError, match=r"action\[1\]: got nan"):
        env.step([0.0, np.nan])


@pytest.mark.parametrize(
    ("axes", "entries"),
    [
        (("disc", "direction"), ("x", "y")),
        (("automaton", "entry"), ("xx", "yy", "xy")),
        (("cell", "entry"), ("xx", "yy", "zz", "xy")),
        (("point", "entry"), ("xx", "yy", "zz", "xy", "yz", "zx")),
    ],
)
def test_entries_of_vectors_and_tensors_have_names_in_figures(axes: tuple[str, ...], entries: tuple[str, ...]) -> None:
    variable = Variable("stress", "output", "Pa", (7, len(entries)), "stress", axes=axes)
    assert component_names(variable) == [f"stress_{entry}" for entry in entries]
    labels = [element_label(variable, (3, place), None) for place in range(len(entries))]
    assert labels == [f"stress {entry}, {axes[0]} 3" for entry in entries]


def test_entries_without_names_have_numbers_in_figures() -> None:
    assert component_names(Variable("pair", "output", "1", (7, 2), "pair", axes=("disc", "end"))) == ["pair[:,0]", "pair[:,1]"]


@pytest.mark.parametrize(
    ("axis", "expected"),
    [
        ("receiver", [[0.1, 0.2], [0.3, 0.4]]),
        ("gas gauge", [[0.5], [0.6]]),
        ("shell gauge", [[0.7], [0.8]]),
        ("node", None),
        ("end", None),
    ],
)
def test_positions_of_receivers_and_gauges_are_read_from_the_parameters(axis: str, expected: list[list[float]] | None) -> None:
    shell = {"gauges": [[0.7, 1.57], [0.8, 0.0]], "nodes": [3, 4]}
    parameters = {"grid": {"receivers": [[0.1, 0.2], [0.3, 0.4]]}, "gas": {"gauges": [0.5, 0.6]}, "shell": shell, "ends": 2}
    variable = Variable("pressure", "output", "Pa", (2,), "pressure", axes=(axis,))
    found = listed_positions(parameters, variable)
    assert (None if found is None else found.tolist()) == expected
