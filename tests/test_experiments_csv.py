"""Measured histories in CSV files: declared units, and error messages with line numbers."""

import os
import warnings

import pytest

from granular_env.components.csv_history import read_history, read_limited_file
from granular_env.components.errors import ExperimentError, GranularWarning, ParameterError
from granular_env.components.profiles import Profile
from granular_env.experiments import load_experiment
from granular_env.experiments.inputs import CsvTable
from granular_env.experiments.preparation import prepare_experiment

GOOD = "# a drop hammer\ntime [us],temperature [K],force [kN]\n0,300,0.0\n10,301,1.5\n\n"


def read(tmp_path, text, time_unit=None, value_unit=None, columns=("time", "force"), unit="N", **options):
    path = tmp_path / "hammer.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    columns = dict(zip(("time_column", "value_column"), columns, strict=True))
    return read_history(path, **columns, time_unit=time_unit, value_unit=value_unit, unit=unit, **options)


def test_units_come_from_the_header(tmp_path):
    times, values = read(tmp_path, GOOD)
    # Bitwise: 10 us is 1e-5 s, not 10 * 1e-6.
    assert times.tolist() == [0.0, 1e-5]
    assert values.tolist() == [0.0, 1500.0]


@pytest.mark.parametrize(
    ("text", "arguments"),
    [
        ("0 ; 0\n3;1.5\n", {"columns": (0, 1), "time_unit": "us", "value_unit": "kN", "delimiter": ";"}),
        ("\ufefftime [\u00b5s],force [kN]\r\n0,0\r\n3,1.5\r\n", {}),
        ('"time [us]","force [kN]"\n"0","0"\n"3","1.5"\n', {}),
        ("force [kN]\ttime [us]\n0\t0\n1.5\t3\n", {"delimiter": "\t"}),
        ("time (us),force (left) [kN]\n0,0\n3,1.5\n", {"columns": ("time (us)", "force (left)")}),
        ("LECROYWS424,12345,Waveform\nSegments,1,\n\ntime [us],force [kN]\n0,0\n3,1.5\n", {"skip": 3}),
        ("time [us];force [kN]\n0;0\n3;1,5\n", {"delimiter": ";", "decimal": ","}),
        ("time [us],force [V]\n0,0\n3,3\n", {"scale": 500.0}),
        ("t[us] f[kN]\n  0.0   0.0\n  3.0   1.5\n", {"columns": (0, 1), "delimiter": " "}),
        ("time/s,force / kN\n0,0\n3e-6,1.5\n", {}),
        ("Time (sec),force [tonf]\n0,0\n3e-6,3\n", {"columns": ("Time", "force"), "scale": 500.0, "value_unit": "N"}),
        ("time [us],force [kN]\n0,0\n3,1.5\n", {"columns": (0, 1), "unit": None}),
    ],
)
def test_files_of_oscilloscopes_and_spreadsheets_are_read(tmp_path, text, arguments):
    times, values = read(tmp_path, text, **arguments)
    assert times.tolist() == [0.0, 3e-6]
    assert values.tolist() == [0.0, 1500.0]


@pytest.mark.parametrize(
    ("written", "unit", "value"),
    [("lbf", "N", 4.4482216152605), ("kgf", "N", 9.80665), ("g", "m/s^2", 9.80665), ("sec", "s", 1.0)],
)
def test_units_of_instruments(tmp_path, written, unit, value):
    text = f"time/sec,reading [{written}]\n0,0\n1,1\n"
    assert read(tmp_path, text, columns=("time", "reading"), unit=unit)[1].tolist() == [0.0, value]


def test_a_unit_over_a_unit_is_not_a_name_over_a_unit(tmp_path):
    text = "time [s],speed m/s\n0,0\n1,2\n"
    assert read(tmp_path, text, columns=("time", "speed m/s"), value_unit="m/s", unit="m/s")[1].tolist() == [0.0, 2.0]


# Each: text, further arguments, and expected content of the message in addition to the file name.
FAULTS = [
    (GOOD.replace("10,301,1.5", "10,301,"), {}, ["line 4", "the value is ''"]),
    (GOOD.replace("1.5", "nan"), {}, ["line 4", "'nan'"]),
    (GOOD.replace("10,301,1.5", "10,1.5"), {}, ["line 4", "2 cells, expected 3"]),
    (GOOD.replace("10,301,1.5", "0,301,1.5"), {}, ["line 4", "follows", "line 3"]),
    (GOOD.replace("10,301,1.5\n", ""), {}, ["1 samples, expected at least 2"]),
    (GOOD.replace(" [us]", ""), {}, ["line 2", "no unit", "time_unit"]),
    (GOOD, {"time_unit": "ms"}, ["line 2", "the unit in the header is 'us'", "time_unit = 'ms'"]),
    (GOOD, {"unit": "m/s"}, ["line 2", "'kN'", "expected m/s"]),
    (GOOD, {"columns": ("tim", "force")}, ["line 2", "time_column = 'tim'", "did you mean 'time'?"]),
    ("0,1\n1,2\n", {"columns": ("time", "force")}, ["line 1", "without a header"]),
    (b"time [us],force [kN]\n0,0\n\xff,1\n", {}, ["not UTF-8"]),
    (GOOD.replace(",", ";"), {}, ["line 2", "the delimiter is ','", "set delimiter"]),
]


@pytest.mark.parametrize(("text", "arguments", "said"), FAULTS, ids=[str(number) for number in range(len(FAULTS))])
def test_faults_name_file_and_line(tmp_path, text, arguments, said):
    with pytest.raises(ParameterError) as caught:
        read(tmp_path, text, **arguments)
    for words in [str(tmp_path / "hammer.csv"), *said]:
        assert words in str(caught.value)


def sampled_at(*times) -> str:
    return "# of a logger\ntime [us],force [N]\n" + "".join(f"{time},{time}\n" for time in times)


def test_a_hole_in_the_sampling_is_refused_with_its_times_and_what_to_do(tmp_path):
    with pytest.raises(ParameterError) as caught:
        read(tmp_path, sampled_at(0, 1, 2, 3, 900, 901))
    for words in ("line 7", "from 3e-06 s to 0.0009 s", "median step is 1e-06 s", 'set gaps = "bridge"'):
        assert words in str(caught.value)
    with pytest.raises(ParameterError, match="line 6: .*the first of 2"):
        read(tmp_path, sampled_at(0, 1, 2, 30, 31, 60, 61, 62))


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ParameterError, match="cannot be read"):
        read_history(tmp_path / "none.csv")
    with pytest.raises(ParameterError, match="it is a folder"):
        read_history(tmp_path)


# -- in an experiment -----------------------------------------------------------------------------------------------


def experiment_with(tmp_path, extra=""):
    (tmp_path / "hammer.csv").write_text(GOOD)
    path = tmp_path / "hit.toml"
    path.write_text(
        'name = "hit"\nduration = 1e-4\n[component]\ntype = "oscillator"\nstep_size = 1e-6\n'
        '[input.force]\nprofile = "csv"\npath = "hammer.csv"\ntime_column = "time"\nvalue_column = "force"\n' + extra
    )
    return path


def test_the_path_is_relative_to_the_experiment_and_the_profile_is_the_history(tmp_path):
    profile = prepare_experiment(load_experiment(experiment_with(tmp_path))).inputs["force"]
    assert [profile(time) for time in (0.0, 5e-6, 2e-5)] == pytest.approx([0.0, 750.0, 0.0], rel=1e-12, abs=0.0)


def test_scale_offset_and_what_comes_after(tmp_path):
    path = experiment_with(tmp_path, 'scale = -2.0\noffset_time = 1e-5\nafter = "hold"\n')
    profile = prepare_experiment(load_experiment(path)).inputs["force"]
    assert [profile(time) for time in (5e-6, 1.5e-5, 9e-5)] == pytest.approx([0.0, -1500.0, -3000.0], rel=1e-12, abs=0.0)


def test_a_hole_is_crossed_in_a_straight_line_where_the_experiment_says_so(tmp_path):
    path = experiment_with(tmp_path, 'gaps = "bridge"\n')
    (tmp_path / "hammer.csv").write_text(sampled_at(0, 1, 2, 3, 53, 54))
    profile = prepare_experiment(load_experiment(path)).inputs["force"]
    assert [profile(time * 1e-6) for time in (3, 28, 53)] == pytest.approx([3.0, 28.0, 53.0], rel=1e-12, abs=0.0)
    with pytest.raises(ExperimentError, match=r"hammer\.csv: line 7: a gap"):
        prepare_experiment(load_experiment(path, {"input.force.gaps": "refuse"}))


def test_samples_before_time_0_are_told_of_with_what_to_do(tmp_path):
    path = experiment_with(tmp_path)
    (tmp_path / "hammer.csv").write_text(sampled_at(-3, -2, -1, 0, 1))
    said = "3 of 5 breakpoints or samples lie before time 0 .*-3e-06 s.*add 3e-06 s to its times .offset_time"
    with pytest.warns(GranularWarning, match=said):
        prepare_experiment(load_experiment(path))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        prepare_experiment(load_experiment(path, {"input.force.offset_time": 3e-6}))


def test_python_reads_the_same_files(tmp_path):
    path = experiment_with(tmp_path, 'scale = -2.0\noffset_time = 1e-5\nafter = "hold"\n')
    by_file = prepare_experiment(load_experiment(path)).inputs["force"]
    options = {"time_column": "time", "value_column": "force", "scale": -2.0, "offset_time": 1e-5, "after": "hold"}
    by_hand = Profile.from_csv(tmp_path / "hammer.csv", **options)
    assert by_hand.starts.tobytes() == by_file.starts.tobytes()
    assert by_hand.coefficients.tobytes() == by_file.coefficients.tobytes()
    with pytest.raises(ParameterError, match="'kN', expected m/s"):
        Profile.from_csv(tmp_path / "hammer.csv", value_column=2, unit="m/s")
    wrong_options = {"time_unit": 3, "unit": 3, "delimiter": "x", "decimal": ";", "gaps": "fill", "scale": "big"}
    wrong_options["offset_time"] = None
    for name, value in wrong_options.items():
        with pytest.raises(ParameterError, match=f"{name}: got"):
            Profile.from_csv(tmp_path / "hammer.csv", **{name: value})
    with pytest.raises(ParameterError, match="path: got 3"):
        Profile.from_csv(3)


def test_a_history_that_ends_before_the_run_begins_is_refused(tmp_path):
    with pytest.raises(ExperimentError, match=r"input\.force.*offset_time.*before time 0"):
        prepare_experiment(load_experiment(experiment_with(tmp_path, "offset_time = -1\n")))


def test_a_file_is_called_in_messages_as_it_is_in_the_document(tmp_path):
    path = tmp_path / "far" / "hammer.csv"
    path.parent.mkdir()
    path.write_text(GOOD.replace("10,301,1.5", "0,301,1.5"))
    table = CsvTable(profile="csv", path="far/hammer.csv", time_column="time", value_column="force")
    with pytest.raises(ParameterError, match=r"^far/hammer.csv: line 4: "):
        table.make_profile(tmp_path, "N")
    path.unlink()
    # The message contains the path that was searched.
    with pytest.raises(ParameterError, match=str(path)):
        table.make_profile(tmp_path, "N")


def test_only_regular_files_of_a_bounded_size_are_read(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for name, what in (("pipe", "a pipe"), (".", "a folder")):
        with pytest.raises(ParameterError, match=what):
            read_limited_file(tmp_path / name, 10, "")
    (tmp_path / "a").write_bytes(b"x" * 11)
    assert read_limited_file(tmp_path / "a", 11, "") == b"x" * 11
    with pytest.raises(ParameterError, match="more than 10 bytes; thin it out"):
        read_limited_file(tmp_path / "a", 10, "thin it out")
