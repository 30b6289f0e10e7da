"""Measured histories in CSV files: units are declared, and every fault is named by its line."""

import warnings
from pathlib import Path

import numpy as np
import pytest

from granular_env.components.csv_history import read_history
from granular_env.components.errors import ExperimentError, GranularWarning, ParameterError
from granular_env.components.profiles import Profile
from granular_env.experiments import load_experiment
from granular_env.experiments.inputs import CsvTable
from granular_env.experiments.preparation import prepare

GOOD = "# a drop hammer\ntime [us],temperature [K],force [kN]\n0,300,0.0\n10,301,1.5\n\n"


def read(tmp_path, text, time_unit=None, value_unit=None, columns=("time", "force"), unit="N", **options):
    path = tmp_path / "hammer.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    columns = dict(zip(("time_column", "value_column"), columns, strict=True))
    return read_history(path, **columns, time_unit=time_unit, value_unit=value_unit, unit=unit, **options)


def test_units_come_from_the_header(tmp_path):
    times, values = read(tmp_path, GOOD)
    # To the bit: 10 us is 1e-5 s and not 10 * 1e-6.
    assert times.tolist() == [0.0, 1e-5]
    assert values.tolist() == [0.0, 1500.0]


def test_units_may_be_declared_twice_where_they_agree(tmp_path):
    assert read(tmp_path, GOOD, "us", "kN")[1][1] == 1500.0


@pytest.mark.parametrize(
    ("text", "arguments"),
    [
        ("0 ; 0\n3;1.5\n", {"columns": (0, 1), "time_unit": "us", "value_unit": "kN", "delimiter": ";"}),
        ("\ufefftime [\u00b5s],force [kN]\r\n0,0\r\n3,1.5\r\n", {}),
        ('"time [us]","force [kN]"\n"0","0"\n"3","1.5"\n', {}),
        ("force [kN]\ttime [us]\n0\t0\n1.5\t3\n", {"delimiter": "\t"}),
        ("time [us],force [kN]\r0,0\r3,1.5\r", {}),
        ("t,f\n0,0\n3,1.5e0\n# the end\n", {"columns": ("t", "f"), "time_unit": "us", "value_unit": "kN"}),
    ],
)
def test_dialects(tmp_path, text, arguments):
    times, values = read(tmp_path, text, **arguments)
    assert times.tolist() == [0.0, 3e-6]
    assert values.tolist() == [0.0, 1500.0]


@pytest.mark.parametrize(
    ("text", "arguments"),
    [
        ("time (s),force (kN)\n0,0\n3e-6,1.5\n", {}),
        ("time (us),force (left) [kN]\n0,0\n3,1.5\n", {"columns": ("time (us)", "force (left)")}),
        ("time [\u00b5s],force [kN]\n# Pr\u00fcfstand 3\n0,0\n3,1.5\n".encode("latin-1"), {}),
        ("LECROYWS424,12345,Waveform\nSegments,1,\n\ntime [us],force [kN]\n0,0\n3,1.5\n", {"skip": 3}),
        ("time [us];force [kN]\n0;0\n3;1,5\n", {"delimiter": ";", "decimal": ","}),
        ('time [us],force [kN]\n"0","0"\n"3,0","1,5"\n', {"decimal": ","}),
        ("time [us],force [V]\n0,0\n3,3\n", {"scale": 500.0}),
        ("time [us]\tforce [kN]\r\n0\t0\r\n3\t1.5\r\n".encode("utf-16"), {"delimiter": "\t"}),
        ("t[us] f[kN]\n  0.0   0.0\n  3.0   1.5\n", {"columns": (0, 1), "delimiter": " "}),
        ("Time (usec),Force (kN)\n0,0\n3,1.5\n", {"columns": ("Time", "Force")}),
        ("time/s,force / kN\n0,0\n3e-6,1.5\n", {}),
        ("Time (sec),force [tonf]\n0,0\n3e-6,3\n", {"columns": ("Time", "force"), "scale": 500.0, "value_unit": "N"}),
        ("time [us],force\n0,0\n3,3000\n", {"scale": 500.0, "value_unit": "mV"}),
        ("time [us],force [kN]\n0,0\n3,1.5\n", {"columns": (0, 1), "unit": None}),
    ],
)
def test_what_oscilloscopes_and_spreadsheets_write(tmp_path, text, arguments):
    times, values = read(tmp_path, text, **arguments)
    assert times.tolist() == [0.0, 3e-6]
    assert values.tolist() == [0.0, 1500.0]


def test_velocities_have_their_own_units(tmp_path):
    text = "time [ms],speed [mm/s]\n0,0\n1,2500\n"
    assert read(tmp_path, text, columns=("time", "speed"), unit="m/s")[1].tolist() == [0.0, 2.5]


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


# Each: the text, further arguments, and what the message has to say besides the file's name.
FAULTS = [
    (GOOD.replace("10,301,1.5", "10,301,"), {}, ["line 4", "the value is empty", "a gap is not filled in"]),
    (GOOD.replace("10,301,1.5", ",301,1.5"), {}, ["line 4", "the time is empty"]),
    (GOOD.replace("0,300,0.0\n", "0,300,0.0\n\n"), {}, ["line 4", "empty, between samples"]),
    (GOOD.replace("1.5", "nan"), {}, ["line 4", "'nan'"]),
    (GOOD.replace("1.5", "inf"), {}, ["line 4", "'inf'"]),
    (GOOD.replace("1.5", "1e999"), {}, ["line 4", "'1e999'"]),
    (GOOD.replace("1.5", "1_5"), {}, ["line 4", "'1_5'"]),
    (GOOD.replace("1.5", "high"), {}, ["line 4", "'high'"]),
    (GOOD.replace("1.5", "1,5"), {}, ["line 4", "4 cells, expected 3"]),
    (GOOD.replace("10,301,1.5", "10,1.5"), {}, ["line 4", "2 cells, expected 3"]),
    (GOOD.replace("10,301,1.5", "0,301,1.5"), {}, ["line 4", "repeats", "line 3"]),
    (GOOD.replace("10,301,1.5", "-1,301,1.5"), {}, ["line 4", "goes back behind", "line 3"]),
    (GOOD.replace("10,301,1.5\n", ""), {}, ["1 samples, expected at least 2"]),
    (GOOD.replace("1.5", '"1.5'), {}, ["line 4"]),
    (GOOD.replace(" [us]", ""), {}, ["line 2", "no unit", "time_unit"]),
    (GOOD.replace(" [kN]", ""), {}, ["line 2", "no unit", "value_unit"]),
    (GOOD, {"time_unit": "ms"}, ["line 2", "the header says 'us'", "time_unit = 'ms'"]),
    (GOOD, {"value_unit": "N"}, ["line 2", "the header says 'kN'"]),
    (GOOD.replace("[us]", "[min]"), {}, ["line 2", "'min' is unknown", "s, ms, us, ns"]),
    (GOOD.replace("[kN]", "[tonf]"), {}, ["line 2", "'tonf' is unknown", "set value_unit, and scale"]),
    (GOOD.replace("[us]", "[kN]"), {}, ["line 2", "'kN' measures something else"]),
    (GOOD, {"unit": "m/s"}, ["line 2", "'kN' measures something else", "m/s"]),
    (GOOD, {"columns": ("tim", "force")}, ["line 2", "time_column = 'tim'", "did you mean 'time'?"]),
    (GOOD, {"columns": ("time", 7)}, ["line 2", "value_column = 7", "a column from 0 to 2"]),
    (GOOD, {"columns": ("time", "time")}, ["both name column 0"]),
    (GOOD.replace("temperature [K]", "force [N]"), {}, ["line 2", "more than once"]),
    ("0,1\n1,2\n", {"columns": ("time", "force")}, ["line 1", "no header line"]),
    (b"time [us],force [kN]\n0,0\n\xff,1\n", {}, ["line 3", "not UTF-8"]),
    ("", {}, ["no rows"]),
    ("# nothing\n\n", {}, ["no rows"]),
    ("time [us],force [kN]\n0,0\n1,1.7e308\n", {}, ["line 3", "overflows"]),
    (GOOD.replace(",", ";"), {}, ["line 2", "one column only", 'set delimiter = ";"']),
    (GOOD.replace(",", "\t"), {}, ["line 2", "one column only", 'set delimiter = "\\t"']),
    (GOOD, {"delimiter": ";"}, ["line 2", "one column only", 'set delimiter = ","']),
    (GOOD.replace(",", " "), {}, ["line 2", "one column only", 'set delimiter = " "']),
    ("0,0;1,5\n0,1;1,6\n", {"columns": (0, 1), "time_unit": "s", "value_unit": "N"}, ["line 1", 'set delimiter = ";"']),
    (GOOD.replace(",", ";").replace("1.5", "1,5"), {"delimiter": ";"}, ["line 4", "'1,5'", "write decimal points"]),
    (GOOD.replace("1.5", '"1.5'), {}, ["line 4", "a quotation mark is not closed"]),
    (GOOD.replace("1.5", '"1"5'), {}, ["line 4", "a quotation mark is not closed, or does not enclose a whole cell"]),
    (GOOD.replace("1.5", "9" * 200_000), {}, ["line 4", "a cell is too long"]),
    (GOOD.replace("1.5", "high").replace("\n", "\r"), {}, ["line 4", "'high'"]),
    (b"time [us],force [kN]\r0,0\r\xff,1\r", {}, ["line 3", "not UTF-8"]),
    ("time [us],force [kN]\n0,0\n".encode("utf-16") + b"\0", {}, ["line 3"]),
    (GOOD.replace("[kN]", "[V]"), {}, ["line 2", "'V' is a sensor's signal; set scale, in N for each volt"]),
    (GOOD.replace("[us]", "[V]"), {"scale": 2.0}, ["line 2", "time_unit: 'V' measures something else", "s, ms, us, ns"]),
    (GOOD.replace("[kN]", "(tonf)"), {"columns": (0, 2)}, ["line 2", "no unit; set value_unit"]),
    (GOOD.replace("1.5", "1.5 "), {"decimal": ","}, ["line 3", "'0.0'", "such as 1,5e-3", 'set decimal = "."']),
    (GOOD, {"skip": 7}, ["no rows"]),
    ("LECROYWS424,12345\nSegments,1\n" + GOOD, {}, ["line 1", "numbers begin in line 5", "set skip = 3"]),
    ("LECROYWS424,12345\n1,2\nSegments,1\n" + GOOD, {}, ["line 1", "numbers begin in line 6", "set skip = 4"]),
    ("LECROYWS424,12345,Waveform\n1,2,3\n0,0\n1,5\n3,6\n", {}, ["line 1", "samples begin in line 3", "set skip = 2"]),
]


@pytest.mark.parametrize(("text", "arguments", "said"), FAULTS, ids=[str(number) for number in range(len(FAULTS))])
def test_faults_name_file_and_line(tmp_path, text, arguments, said):
    with pytest.raises(ParameterError) as caught:
        read(tmp_path, text, **arguments)
    for words in [str(tmp_path / "hammer.csv"), *said]:
        assert words in str(caught.value)


@pytest.mark.parametrize("skip", [-1, True, 1.5, "2"])
def test_lines_to_skip_are_a_whole_number(tmp_path, skip):
    with pytest.raises(ParameterError, match="skip: got"):
        read(tmp_path, GOOD, skip=skip)


def sampled_at(*times) -> str:
    return "# of a logger\ntime [us],force [N]\n" + "".join(f"{time},{time}\n" for time in times)


def test_a_hole_in_the_sampling_is_refused_with_its_times_and_what_to_do(tmp_path):
    with pytest.raises(ParameterError) as caught:
        read(tmp_path, sampled_at(0, 1, 2, 3, 900, 901))
    for words in ("line 7", "from 3e-06 s (line 6) to 0.0009 s", "median step is 1e-06 s", 'set gaps = "bridge"'):
        assert words in str(caught.value)
    with pytest.raises(ParameterError, match="line 6: .*the first of 2 holes"):
        read(tmp_path, sampled_at(0, 1, 2, 30, 31, 60, 61, 62))


@pytest.mark.parametrize(("last", "fits"), [(13, True), (13.0001, False)])
def test_a_hole_begins_above_ten_median_steps(tmp_path, last, fits):
    text = sampled_at(0, 1, 2, 3, last)
    if fits:
        assert len(read(tmp_path, text)[0]) == 5
    else:
        with pytest.raises(ParameterError, match="line 7: a hole"):
            read(tmp_path, text)


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
    profile = prepare(load_experiment(experiment_with(tmp_path))).inputs["force"]
    assert [profile(time) for time in (0.0, 5e-6, 2e-5)] == pytest.approx([0.0, 750.0, 0.0], rel=1e-12, abs=0.0)


def test_scale_offset_and_what_comes_after(tmp_path):
    path = experiment_with(tmp_path, 'scale = -2.0\noffset_time = 1e-5\nafter = "hold"\n')
    profile = prepare(load_experiment(path)).inputs["force"]
    assert [profile(time) for time in (5e-6, 1.5e-5, 9e-5)] == pytest.approx([0.0, -1500.0, -3000.0], rel=1e-12, abs=0.0)


def test_a_hole_is_crossed_in_a_straight_line_where_the_experiment_says_so(tmp_path):
    path = experiment_with(tmp_path, 'gaps = "bridge"\n')
    (tmp_path / "hammer.csv").write_text(sampled_at(0, 1, 2, 3, 53, 54))
    profile = prepare(load_experiment(path)).inputs["force"]
    assert [profile(time * 1e-6) for time in (3, 28, 53)] == pytest.approx([3.0, 28.0, 53.0], rel=1e-12, abs=0.0)
    with pytest.raises(ExperimentError, match=r"hammer\.csv: line 7: a hole"):
        prepare(load_experiment(path, {"input.force.gaps": "refuse"}))


@pytest.mark.parametrize("word", ["file", "filename"])
def test_other_words_for_path_are_answered_with_path(tmp_path, word):
    path = experiment_with(tmp_path)
    path.write_text(path.read_text().replace("path =", f"{word} ="))
    with pytest.raises(ExperimentError) as caught:
        load_experiment(path)
    assert f"{path}: input.force.{word}: unknown; did you mean 'path'?" in str(caught.value).splitlines()


def test_samples_before_time_0_are_told_of_with_what_to_do(tmp_path):
    path = experiment_with(tmp_path)
    (tmp_path / "hammer.csv").write_text(sampled_at(-3, -2, -1, 0, 1))
    said = "3 of 5 breakpoints or samples lie before time 0 .*-3e-06 s.*add 3e-06 s to its times .offset_time"
    with pytest.warns(GranularWarning, match=said):
        prepare(load_experiment(path))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        prepare(load_experiment(path, {"input.force.offset_time": 3e-6}))


def test_a_run_that_ends_long_before_its_signal_is_told_of(tmp_path):
    path = experiment_with(tmp_path)
    (tmp_path / "hammer.csv").write_text(GOOD.replace("[us]", "[s]"))
    with pytest.warns(GranularWarning, match=r"input\.force: the run ends at 0.0001 s, after 0.001 % of the signal.* to 10 s"):
        prepare(load_experiment(path))


def test_python_reads_the_same_files(tmp_path):
    path = experiment_with(tmp_path, 'scale = -2.0\noffset_time = 1e-5\nafter = "hold"\n')
    by_file = prepare(load_experiment(path)).inputs["force"]
    options = {"time_column": "time", "value_column": "force", "scale": -2.0, "offset_time": 1e-5, "after": "hold"}
    by_hand = Profile.from_csv(tmp_path / "hammer.csv", **options)
    assert by_hand.starts.tobytes() == by_file.starts.tobytes()
    assert by_hand.coefficients.tobytes() == by_file.coefficients.tobytes()
    with pytest.raises(ParameterError, match="'kN' measures something else, expected m/s"):
        Profile.from_csv(tmp_path / "hammer.csv", value_column=2, unit="m/s")
    wrong_options = {"time_unit": 3, "unit": 3, "delimiter": "x", "decimal": ";", "gaps": "fill", "scale": "big"}
    wrong_options["offset_time"] = None
    for name, value in wrong_options.items():
        with pytest.raises(ParameterError, match=f"{name}: got"):
            Profile.from_csv(tmp_path / "hammer.csv", **{name: value})
    with pytest.raises(ParameterError, match="path: got 3"):
        Profile.from_csv(3)


def test_every_key_of_the_csv_table_is_in_the_docs():
    page = (Path(__file__).parents[1] / "docs" / "experiments.md").read_text()
    missing = [key for key in CsvTable.model_fields if f"`{key}" not in page]
    assert missing == []


def test_a_history_that_ends_before_the_run_begins_is_refused(tmp_path):
    with pytest.raises(ExperimentError, match=r"input\.force.*offset_time.*before time 0"):
        prepare(load_experiment(experiment_with(tmp_path, "offset_time = -1\n")))


def test_samples_between_steps_are_told_of(tmp_path):
    path = experiment_with(tmp_path)
    (tmp_path / "hammer.csv").write_text("time [us],force [N]\n0,0\n2.5,1\n10,2\n")
    with pytest.warns(UserWarning, match="1 of 3 breakpoints or samples lie between ticks"):
        prepare(load_experiment(path))


def test_the_file_and_line_reach_the_experiment_error(tmp_path):
    path = experiment_with(tmp_path)
    (tmp_path / "hammer.csv").write_text(GOOD.replace("1.5", ""))
    with pytest.raises(ExperimentError, match=r"hammer\.csv: line 4: the value is empty"):
        prepare(load_experiment(path))


def test_a_whole_measurement_survives_the_way_through_a_file(tmp_path):
    rng = np.random.default_rng(7)
    times, values = np.cumsum(rng.uniform(0.1, 1.0, 500)), rng.normal(size=500)
    rows = "".join(f"{t!r},{v!r}\n" for t, v in zip(times.tolist(), values.tolist(), strict=True))
    read_times, read_values = read(tmp_path, "time [s],force [N]\n" + rows)
    np.testing.assert_array_equal(read_times, times)
    np.testing.assert_array_equal(read_values, values)


def test_a_file_is_called_in_messages_as_it_is_in_the_document(tmp_path):
    path = tmp_path / "far" / "hammer.csv"
    path.parent.mkdir()
    path.write_text(GOOD.replace("10,301,1.5", "0,301,1.5"))
    table = CsvTable(profile="csv", path="far/hammer.csv", time_column="time", value_column="force")
    with pytest.raises(ParameterError, match=r"^far/hammer.csv: line 4: "):
        table.build(tmp_path, "N")
    path.unlink()
    # Where it was looked for is told where it is not found.
    with pytest.raises(ParameterError, match=str(path)):
        table.build(tmp_path, "N")
