"""Experiment files: errors name file, table and key, and suggest the closest valid name."""

import json

import numpy as np
import pytest

from granular_env.components.discs import Discs
from granular_env.components.errors import ExperimentError
from granular_env.documents import parse_assignments
from granular_env.experiments import load_experiment
from granular_env.experiments.preparation import prepare_experiment
from granular_env.recording import verify
from granular_env.run_loop import run

GOOD = """
name = "good"
duration = 1.0
[component]
type = "oscillator"
stiffness = 4.0
[start]
position = 1.0
[input.force]
profile = "sum"
profiles = [{ profile = "half_sine", peak = 1, duration = 0.5 }, { profile = "constant", value = 2 }]
[[stop]]
variable = "position"
below = -100.0
[record]
every = 0.1
variables = ["position", "kinetic_energy", "force"]
"""


@pytest.fixture
def good(tmp_path):
    path = tmp_path / "good.toml"
    path.write_text(GOOD)
    return path


def test_a_good_file_is_ready_to_run(good):
    ready = prepare_experiment(load_experiment(good))
    assert ready.ticks == 100
    assert ready.component.get("position") == 1.0
    assert ready.component.tick == 0
    assert ready.inputs["force"](0.25) == pytest.approx(3.0, abs=1e-12)


def test_to_dict_gives_the_same_experiment_and_is_json(good):
    first = load_experiment(good)
    second = load_experiment(json.loads(json.dumps(first.to_dict())))
    assert second.to_dict() == first.to_dict()
    np.testing.assert_array_equal(
        prepare_experiment(first).inputs["force"].coefficients, prepare_experiment(second).inputs["force"].coefficients
    )


# Each: text to replace in the valid file, its replacement, and expected text of the message.
FAULTS = [
    ("duration = 1.0", "duratoin = 1.0", ["duratoin: unknown; did you mean 'duration'?", "duration: missing"]),
    ("duration = 1.0", 'duration = "1.0"', ["duration: got '1.0'"]),
    ("duration = 1.0", "duration = nan", ["duration: got nan"]),
    ("duration = 1.0", "duration = 0.0123456", ["duration: got 0.0123456 s, which is 1.23456 internal steps", "0.01 s"]),
    (
        'type = "oscillator"',
        'type = "oscilator"',
        ["component", "got 'oscilator', expected the name of a component; did you mean 'oscillator'?"],
    ),
    ("stiffness = 4.0", "stifness = 4.0", ["component", "stifness: unknown; did you mean 'stiffness'?"]),
    ("position = 1.0", "positon = 1.0", ["start.positon", "did you mean 'position'?"]),
    ("position = 1.0", "position = inf", ["start.position"]),
    ('"half_sine"', '"half_sin"', ["input.force.profiles[0].profile", "did you mean 'half_sine'?"]),
    ("peak = 1", "peek = 1", ["input.force.profiles[0].peek: unknown; did you mean 'peak'?", "profiles[0].peak: missing"]),
    ("[input.force]", "[input]\nforce = [1.0, nan]\n[input.other]", ["input.force[1]: got nan, expected a finite number"]),
    ('profile = "sum"', 'profile = "triangle"', ["input.force.profiles: unknown"]),
    ('variable = "position"', 'varable = "position"', ["stop[0].varable: unknown; did you mean 'variable'?"]),
    ('variable = "position"', 'variable = "position[1]"', ["stop[0].variable: got 'position[1]', expected no index"]),
    ("below = -100.0", "below = -100.0\nevery = 0.015", ["stop[0].every: got 0.015 s, which is 1.5 internal steps"]),
    ("every = 0.1", "every = 0.015", ["record.every: got 0.015 s, which is 1.5 internal steps"]),
    ('"kinetic_energy"', "3", ["record.variables[1]: got 3"]),
]


@pytest.mark.parametrize(("old", "new", "said"), FAULTS, ids=[new for _, new, _ in FAULTS])
def test_faults_name_file_key_and_remedy(good, old, new, said):
    assert old in GOOD
    good.write_text(GOOD.replace(old, new))
    with pytest.raises(ExperimentError) as caught:
        prepare_experiment(load_experiment(good))
    for words in [str(good), *said]:
        assert words in str(caught.value)


def test_all_faults_are_told_at_once(good):
    good.write_text(
        GOOD.replace("every = 0.1", "evry = 0.1").replace("below", "bellow").replace("duration = 1.0", "duration = 0")
    )
    with pytest.raises(ExperimentError) as caught:
        load_experiment(good)
    assert len(str(caught.value).splitlines()) >= 3


@pytest.mark.parametrize(
    "override",
    [
        "radius=1e-300",
        "contact_stiffness=1e300",
    ],
)
def test_sizes_beyond_all_measure_are_refused_and_nothing_hangs(override):
    with pytest.raises(ExperimentError, match="units, which must be SI"):
        prepare_experiment(load_experiment("nesterenko-1983/3.1-one-grain", parse_assignments([f"component.{override}"])))


def test_files_that_are_no_toml(tmp_path):
    for content, said in [(b"\xff\xfe", "utf-8"), (b"a = [" + b"[" * 100_000, "TOML"), (b"", "name: missing")]:
        path = tmp_path / "x.toml"
        path.write_bytes(content)
        with pytest.raises(ExperimentError, match=said):
            load_experiment(path)


# -- inputs of several elements -----------------------------------------------------------------------------------------

CORNER = [[1.0, 0.0], [0.0, 0.5], [0.0, 0.0], [0.0, 0.0]]
DISCS = {"name": "discs", "duration": 1e-3, "component": {"type": "discs", "columns": 2}, "input": {"force": CORNER}}


def test_an_array_and_a_profile_with_a_pattern_are_held(tmp_path):
    script = Discs(columns=2)
    script.step(1e-3, force=np.array(CORNER))
    constant = {"profile": "constant", "value": 1.0, "pattern": CORNER}
    for overrides in ({}, {"input.force": np.array(CORNER)}, {"input.force": constant}):
        result = run(DISCS, overrides=overrides, log=tmp_path / "discs.mcap", overwrite=True)
        assert result.component.save().data == script.save().data
        assert verify(tmp_path / "discs.mcap").identical


@pytest.mark.parametrize(
    ("force", "said"),
    [
        (
            [1.0, 2.0],
            "input.force: got an array of shape (2,), expected an array of shape (4, 2)",
        ),
        (
            [[1.0, 2.0], [3.0]],
            "input.force: got rows of different length, expected numbers, in a list or in rows of equal length",
        ),
        (
            {"profile": "sum", "profiles": [{"profile": "constant", "value": 1.0, "pattern": CORNER}]},
            "input.force.profiles[0].pattern: got a pattern, expected no pattern in a term of a sum",
        ),
    ],
)
def test_an_array_that_does_not_fit_is_named(force, said):
    with pytest.raises(ExperimentError) as caught:
        prepare_experiment(load_experiment(DISCS, {"input.force": force}))
    assert said in str(caught.value)


# -- overrides ------------------------------------------------------------------------------------------------------


def test_overrides_reach_every_table(good):
    overrides = [
        "duration=2",
        "component.mass=2.5",
        "start.velocity=3",
        "input.force.profiles.1.value=7",
        "stop.0.below=-5",
        "record.variables=['velocity']",
        "name=other",
        "seed=4",
    ]
    experiment = load_experiment(good, parse_assignments(overrides))
    assert experiment.duration == 2.0
    assert experiment.component.parameters == {"stiffness": 4.0, "mass": 2.5}
    assert experiment.start == {"position": 1.0, "velocity": 3}
    assert experiment.input["force"].profiles[1].value == 7.0
    assert experiment.stop[0].below == -5.0
    assert experiment.record.variables == ["velocity"]
    assert experiment.name == "other"
    assert experiment.seed == 4


def test_an_override_reaches_into_what_is_only_named():
    """`law = "viscous"` is the table {name = "viscous"}; `law.dissipation` is a key of this table."""
    viscous = load_experiment("nesterenko-1983/3.4-piston", {"component.law": "viscous", "component.law.dissipation": 0.5})
    assert viscous.component.parameters["law"] == {"name": "viscous", "dissipation": 0.5}
    rod = load_experiment("gato-shie-2010/taylor-rod", {"component.material.poisson": 0.3})
    assert rod.component.parameters["material"] == {"name": "thermoviscoplastic", "poisson": 0.3}
    with pytest.raises(
        ExperimentError, match=r"component.left: got \{'name': 'piston', 'speed': 1\}, expected 'free', 'piston'"
    ):
        prepare_experiment(load_experiment("nesterenko-1983/3.4-piston", {"component.left.speed": 1}))


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("duratoin=1", "did you mean 'duration'?"),
        ("component.stifness=1", "did you mean 'stiffness'?"),
        ("input.forse=1", "input.forse: unknown; did you mean 'force'?"),
        ("stop.3.below=1", "expected -1 to 0"),
        ("stop.0.bellow=1", "did you mean 'below'?"),
        ("duration", "expected key=value"),
        ("duration=5OO", "duration: got '5OO', expected a time such as 100us"),
        ("duration=5 + 1", "not a TOML value"),
        ("duration=fast", "duration: got 'fast'"),
    ],
)
def test_a_wrong_override_is_named(good, override, said):
    with pytest.raises(ExperimentError) as caught:
        prepare_experiment(load_experiment(good, parse_assignments([override])))
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("component.mass=-1", "override 'component.mass=-1': component.mass: got -1"),
        ("duration=0.0123", "override 'duration=0.0123': duration: got 0.0123 s, which is 1.23 internal steps"),
        ("start.velocity=nan", "override 'start.velocity=nan': start.velocity: got nan"),
        (
            "component.type=chian",
            "override 'component.type=chian': component.type: got 'chian', expected the name of a component",
        ),
    ],
)
def test_a_fault_of_an_override_is_not_blamed_on_the_file(good, override, said):
    with pytest.raises(ExperimentError) as caught:
        prepare_experiment(load_experiment(good, parse_assignments(["name=other", override])))
    lines = str(caught.value).splitlines()
    assert any(line.startswith(said) for line in lines)
    assert all(line.startswith("override ") for line in lines)


# -- stop rules -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rule", "value", "met"),
    [
        ({"above": 1.0}, 1.5, True),
        ({"above": 1.0}, 1.0, False),
        ({"below": 1.0}, 0.5, True),
        ({"above": 1.0}, [0.0, 2.0], True),
        ({"above": 1.0, "reduce": "min"}, [0.0, 2.0], False),
        ({"variable": "x[-1]", "above": 1.0}, [0.0, 2.0], True),
        ({"variable": "x[1,0]", "above": 1.0}, [[0.0, 0.0], [2.0, 0.0]], True),
        ({"below": 1.0, "reduce": "max"}, [0.0, 2.0], False),
    ],
)
def test_stop_rules_decide(rule, value, met):
    from granular_env.experiments.stop_rules import StopRule

    assert StopRule(**{"variable": "x", **rule}).is_met(np.array(value)) is met
