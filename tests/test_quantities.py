"""Quantities as text: exact conversion to SI, and refusal of other units."""

import math
import pickle

import pytest

import granular_env as ge
from granular_env.components.errors import ParameterError
from granular_env.components.support.quantities import Quantity, parse_quantity
from granular_env.experiments import load_experiment
from granular_env.experiments.preparation import prepare_experiment
from granular_env.sweep.plan import load_plan
from granular_env.sweep.tasks import make_workload


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("1e-4", "s", 1e-4), ("100us", "s", 1e-4), ("100 \u00b5s", "s", 1e-4), ("1 ms", "s", 1e-3), ("2 min", "s", 120.0),
        ("-3mm", "m", -3e-3), ("210 GPa", "Pa", 210e9), ("5 N/mm^2", "Pa", 5e6), ("5g", "kg", 5e-3),
        ("2 cm\u00b2", "m^2", 2e-4),
        ("7.8 g/cm^3", "kg/m^3", 7800.0), ("5 mm/us", "m/s", 5e3), ("1 J/(g K)", "J/(kg K)", 1e3), ("10 kHz", "1/s", 1e4),
        ("30 deg", "rad", math.radians(30.0)), ("3 kN s/m^1.5", "N s/m^1.5", 3e3), ("0.5", "N/m^p", 0.5), ("2", "1", 2.0),
    ],
)  # fmt: skip
def test_the_nearest_float_in_si(text, unit, value):
    assert parse_quantity(text, unit) == value


@pytest.mark.parametrize(
    "text", ["5 mm", "x", "", "nan", "1_0 s", "3kks", "5s5s", "1e999", "1e9999 s", "5 S", "1 s^999999999", "5 s s"]
)
def test_a_wrong_unit_is_refused(text):
    with pytest.raises(ParameterError) as caught:
        parse_quantity(text, "s", at="duration")
    assert str(caught.value) == f"duration: got {text!r}, expected a time such as 100us or 1e-4"


PULSE = {
    "name": "pulse",
    "duration": "0.1 ms",
    "component": {"type": "chain", "grains": 5, "radius": "3 mm", "mass": {"1": "1 g"}, "step_size": "0.2us"},
    "start": {"velocity": {"0": "5000 mm/s"}},
    "input": {"left_force": {"profile": "half_sine", "peak": "2 kN", "duration": "10us"}, "right_force": "-1 N"},
    "stop": [{"variable": "velocity", "above": "1 km/s", "every": "1us"}],
    "record": {"every": "1 us", "snapshot_every": "0.1ms"},
}
PULSE_IN_SI = {
    "name": "pulse",
    "duration": 1e-4,
    "component": {"type": "chain", "grains": 5, "radius": 3e-3, "mass": {"1": 1e-3}, "step_size": 2e-7},
    "start": {"velocity": {"0": 5.0}},
    "input": {"left_force": {"profile": "half_sine", "peak": 2e3, "duration": 1e-5}, "right_force": -1.0},
    "stop": [{"variable": "velocity", "above": 1e3, "every": 1e-6}],
    "record": {"every": 1e-6, "snapshot_every": 1e-4},
}


def test_an_experiment_holds_si_numbers():
    experiment = load_experiment(PULSE)
    assert experiment.to_dict() == load_experiment(PULSE_IN_SI).to_dict() == PULSE_IN_SI
    ready, same = prepare_experiment(experiment), prepare_experiment(load_experiment(PULSE_IN_SI))
    assert ready.component.parameters == same.component.parameters
    assert ready.component.save().to_bytes() == same.component.save().to_bytes()
    assert ge.Chain(grains=5, radius="3 mm").parameters.radius == 3e-3


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("duration", "1 mm", "duration: got '1 mm', expected a time"),
        ("record.every", "1 mm", "record.every: got '1 mm', expected a time"),
        ("component.radius", "3 s", "component.radius: got '3 s', expected a length"),
        ("start.velocity.2", "3 s", "start.velocity.2: got '3 s', expected a speed"),
        ("input.left_force.peak", "3 mm", "input.left_force.peak: got '3 mm', expected a force"),
        ("input.left_force.duration", "3 mm", "input.left_force.duration: got '3 mm', expected a time"),
        ("input.right_force", "3 mm", "input.right_force: got '3 mm', expected a force"),
        ("stop.0.above", "3 mm", "stop[0].above: got '3 mm', expected a speed"),
    ],
)
def test_a_wrong_unit_in_an_experiment_names_its_key(key, value, said):
    with pytest.raises(ge.ExperimentError) as caught:
        prepare_experiment(load_experiment(PULSE, {key: value}))
    assert said in str(caught.value)


def test_the_tasks_of_a_sweep_do_not_depend_on_how_a_value_is_written():
    plan = {"version": 1, "experiment": "chains/tapered", "measure": {"peak": "max velocity[1]"}}
    tasks = [
        make_workload(load_plan({**plan, "grid": {"duration": values}})).tasks
        for values in (["10 us", "20us"], [1e-5, 2e-5], {"from": "10 us", "to": "20 us", "count": 2})
    ]
    assert [task.hash for task in tasks[0]] == [task.hash for task in tasks[1]] == [task.hash for task in tasks[2]]
    assert pickle.loads(pickle.dumps(Quantity("2 kN"))).text == "2 kN"
