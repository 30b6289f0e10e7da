"""What a report shows: everything that was measured, as it was asked for, on a page of the reader's colours."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from support import browser

from granular_env.cli import main
from granular_env.components.catalogue import component_class, make
from granular_env.components.discs import Discs
from granular_env.components.errors import ParameterError
from granular_env.documents import find, to_toml
from granular_env.experiments import load_experiment, shipped_experiments
from granular_env.recording import open_log, record
from granular_env.viewing import plot, report
from granular_env.viewing.curves import Curve
from granular_env.viewing.figures import drawing, run_figures
from granular_env.viewing.figures.drawing import page_svg
from granular_env.viewing.recorded_fields import load_field
from granular_env.viewing.reports import tables
from granular_env.viewing.reports.tables import file_size
from granular_env.viewing.scene_builder import from_log
from granular_env.viewing.unit_labels import label_with_unit, typeset

pytest.importorskip("matplotlib", reason="the extra `view` is not installed")

SHIPPED = "nesterenko-1983/3.4-piston-20"
VARIABLES = ["displacement", "velocity", "overlap", "contact_force", "kinetic_energy", "input_work", "energy_residual"]


@pytest.fixture(scope="module")
def log_path(tmp_path_factory):
    path = tmp_path_factory.mktemp("logs") / "piston.mcap"
    chosen = f"record.variables={VARIABLES}".replace("'", '"')
    command = ["run", SHIPPED, "--set", chosen, "--log", str(path), "--quiet"]
    assert main(command) == 0
    return path


@pytest.fixture
def log(log_path):
    with open_log(log_path) as opened:
        yield opened


@pytest.fixture(scope="module")
def whole(log_path, tmp_path_factory):
    """The page of all that was recorded, and what its progress told."""
    told = []
    with open_log(log_path) as opened:
        return report(opened, tmp_path_factory.mktemp("page"), progress=told.append), told


def headings(page):
    return re.findall(r"<h2[^>]*>([^<]*)</h2>", page.read_text())


def test_every_recorded_array_has_its_figures(whole):
    page, _ = whole
    found = headings(page)
    for name in (
        "x-t diagram",
        "Histories of chosen grains",
        "Contact force",
        "Contact force: histories",
        "Overlap",
        "Displacement",
    ):
        assert name in found
    assert (page.parent / "contact_force-space-time.png").stat().st_size > 1000


def test_a_report_shows_what_it_is_asked_for(log, tmp_path):
    command = [
        "report",
        str(log.path),
        "-o",
        str(tmp_path),
        "--variables",
        "contact_force",
        "--indices",
        "3,7",
        "--times",
        "5e-5",
    ]
    assert main(command) == 0
    html = (tmp_path / "report.html").read_text()
    found = headings(tmp_path / "report.html")
    assert found[:3] == ["Contact force", "Contact force: profiles", "Contact force: histories"] and "x-t diagram" not in found
    texts = re.findall(r"<text[^>]*>([^<]*)</text>", html)
    assert [text for text in texts if text.startswith("contact ") and text[8:].isdigit()] == ["contact 3", "contact 7"]
    assert [text for text in texts if text.startswith("t = ")] == ["t = 50 \u00b5s"]
    assert "contact force [N]" in texts


@pytest.mark.parametrize(
    ("chosen", "word"),
    [
        ({"variables": ["position"]}, "variables: 'position' was not recorded; this log holds .*contact_force"),
        ({"variables": "velocity"}, "variables: got 'velocity', expected a list"),
        ({"times": 1e-4}, "times: got 0.0001, expected a list"),
        ({"indices": 3}, "indices: got 3, expected a list"),
        ({"indices": ["3"]}, "indices: got '3', expected a whole number"),
        ({"times": ["now"]}, "times: got 'now'"),
        (
            {"variables": ["kinetic_energy"], "times": [1e-5]},
            "variables: none of the variables is a recorded array; leave times and indices out",
        ),
    ],
    ids=str,
)
def test_what_a_log_does_not_hold_is_refused_and_nothing_written(log, tmp_path, chosen, word):
    with pytest.raises(ParameterError, match=word):
        report(log, tmp_path / "page", **chosen)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("given", "word"), [(("a.mcap", "x"), "log: got str"), ((None, 3), "folder: got 3")])
def test_arguments_of_a_wrong_type_are_told(log, given, word):
    opened, folder = given
    with pytest.raises(ParameterError, match=word):
        report(opened or log, folder)


def test_the_experiment_stands_at_the_top_and_can_be_run_again(log, whole):
    html = whole[0].read_text()
    lead = html.partition("<nav>")[0]
    shipped = load_experiment(SHIPPED)
    assert " ".join(shipped.description.split())[:60] in " ".join(lead.split())
    assert f"Run report: {SHIPPED}" in lead and file_size(log.path.stat().st_size) in lead
    assert "did not verify it" in html
    # What the page prints as a file is the experiment that was run.
    from html import unescape

    text = next(part for part in map(unescape, re.findall(r"<pre>(.*?)</pre>", html, re.DOTALL)) if "[component]" in part)
    assert load_experiment(tomllib.loads(text)).to_dict() == load_experiment(log.metadata["experiment"]).to_dict()


@pytest.mark.parametrize("name", shipped_experiments())
def test_every_shipped_experiment_is_printed_as_a_file_that_gives_it_again(name):

    loaded = load_experiment(name)
    again = load_experiment(tomllib.loads(to_toml(loaded.to_dict())), folder=find(name, "experiment", "experiments").parent)
    assert again.to_dict() == loaded.to_dict()


def test_parameters_that_were_left_to_the_chain_have_values(log, whole):
    html = whole[0].read_text()
    rows = dict(re.findall(r"<tr><td>(\w+)</td><td[^>]*>([^<]*)</td>", html))
    mass = log.component().geometry.mass[0]
    assert rows["mass"] == f"automatic: {mass:.6g} (20 times)"
    assert rows["step_size"] == f"automatic: {log.step_size:.6g}" and rows["gap"] == "0"
    assert all(value for name, value in rows.items() if name in log.metadata["parameters"])


def test_tables_among_the_parameters_have_rows_of_their_own():
    """In a cell of their own they would be a heap of words."""
    with open_log(Path(__file__).parents[1] / "logs" / "golden" / "tube-burning.mcap") as opened:
        html = str(tables.parameters(opened))
    assert " = " not in re.sub(r"<td[^>]*>[^<]*</td></tr>", "", html), "meanings apart, the last of each row"
    for part in ("coupling", "gas", "gas.reaction", "gas.regions[0]", "shell.body", "shell.material"):
        assert f'<tr class="part"><th colspan="4">{part}</th></tr>' in html
    region = html.partition("gas.regions[0]")[2].partition('class="part"')[0]
    assert "<td>pressure</td><td>1.2e+06</td><td>Pa</td>" in region and "<td>x</td><td>0, 0.004</td><td>m</td>" in region
    body = html.partition("shell.body")[2].partition('class="part"')[0]
    assert "<td>notch</td><td>none</td>" in body and "wall" in body


def test_what_has_no_value_is_worked_out_or_absent():
    fields, values = component_class("tube").Parameters.model_fields, dict.fromkeys(["vent", "gas_steps", "step_size"])
    rows = tables._parameter_rows("", values, fields, None, {"step_size": 5e-8})
    assert [row[1] for row in rows] == ["none", "automatic", "automatic: 5e-08"]


def test_lists_of_tables_are_cut_where_they_are_long():
    values = {"a": [{"b": 1}] * 9, "c": [{"d": k} for k in range(20)]}
    rows = list(tables._parameter_rows("", values, {}, None, {}))
    assert rows[:3] == [["a[0] (9 times)"], ["b", "1", "", ""], ["c[0] (of 20)"]] and len(rows) == 2 + 2 * 8


def test_units_are_typeset():
    assert typeset("m/s^2") == "m/s\u00b2" and typeset("N/m^1.5") == "N/m\u00b9\u00b7\u2075" and typeset("1") == ""
    assert label_with_unit("contact_force", "N") == "contact force [N]" and label_with_unit("tau", "1") == "tau"


def test_a_log_whose_name_is_no_text_has_a_report(log_path, tmp_path):
    odd = tmp_path / "bad\udcff.mcap"
    odd.write_bytes(log_path.read_bytes())
    assert main(["report", str(odd), "-o", str(tmp_path / "page"), "--variables", "kinetic_energy"]) == 0
    assert "bad?.mcap" in (tmp_path / "page" / "report.html").read_text(encoding="utf-8")


def test_an_input_that_does_not_change_is_drawn_on_an_axis_with_zero(log):
    axes = run_figures.curves(list(from_log(log).inputs.values())[:1]).axes[0]
    low, high = axes.get_ylim()
    assert low == 0.0 and 5.0 < high <= 7.0
    times = np.array([0.0, 1.0])
    for value in (-3.0, 0.0):
        flat = Curve("force", "N", "", times, np.array([0, 1]), np.full(2, value))
        low, high = run_figures.curves([flat]).axes[0].get_ylim()
        assert low <= value <= high and low <= 0.0 <= high


def test_the_residual_stands_beside_the_largest_energy(log):
    scene_data = from_log(log)
    figure = run_figures.balance(scene_data)
    below = figure.axes[1]
    right = below.child_axes[0]
    drawing.png(figure)
    largest = np.abs(scene_data.curves["input_work"].values).max()
    np.testing.assert_allclose(np.array(right.get_ylim()) * largest, below.get_ylim(), rtol=1e-9)


def test_progress_goes_from_zero_to_one(whole):
    _, told = whole
    assert told == sorted(told) and told[-1] == 1.0 and len(told) > len(VARIABLES) / 2


def test_figures_are_returned_for_scripts_and_notebooks(log):
    from matplotlib.figure import Figure

    forces = plot(log, "contact_force", "histories", indices=[4])
    assert isinstance(forces, Figure)
    times, values = log.series("contact_force")
    np.testing.assert_array_equal(forces.axes[0].lines[0].get_ydata(), values[:, 4])
    assert forces.axes[0].get_ylabel() == "contact force [N]"
    profile = plot(log, "velocity", "profiles", times=[float(times[10])])
    np.testing.assert_array_equal(profile.axes[0].lines[0].get_ydata(), log.series("velocity")[1][10])
    assert plot(log, "velocity").axes[0].get_xlabel() == "grain (0 is the left end)"
    np.testing.assert_array_equal(plot(log, "kinetic_energy").axes[0].lines[0].get_ydata(), log.series("kinetic_energy")[1])
    assert plot(log, "left_velocity").axes[0].get_ylabel() == "left velocity [m/s]"


@pytest.mark.parametrize(
    ("given", "word"),
    [(("mass",), "variable: 'mass' was not recorded; this log holds"), (("velocity", "film"), "kind: got 'film'")],
)
def test_figures_of_what_there_is_not_are_refused(log, given, word):
    with pytest.raises(ParameterError, match=word):
        plot(log, *given)


def test_a_field_of_contacts_says_where_they_are(log):
    field = load_field(log, "contact_force", 100)
    assert field.place == "contact" and "of grain i" in field.axis and len(field.times) <= 100


def test_a_field_along_a_curve_stands_over_its_coordinate(tmp_path):
    tube = make("detonation", length=0.4, cells=40, regions=[{"x": [0.0, 0.05], "pressure": 3e6}])
    with record(tube, tmp_path / "x.mcap", every=1e-5):
        tube.step(round(1e-4 / tube.step_size) * tube.step_size)
    with open_log(tmp_path / "x.mcap") as opened:
        field = load_field(opened, "pressure", 100)
        np.testing.assert_allclose(field.across, 0.01 * (np.arange(40) + 0.5))
        assert field.ends == pytest.approx((0.0, 0.4))
        diagram = plot(opened, "pressure").axes[0]
        assert diagram.get_xlabel() == "x [m]" and diagram.get_xlim() == pytest.approx((0.0, 0.4))
        profile = plot(opened, "pressure", "profiles", times=[float(field.times[-1])]).axes[0]
        np.testing.assert_array_equal(profile.lines[0].get_xdata(), field.across)
        assert plot(opened, "pressure", "histories", indices=[7]).axes[0].get_legend().get_texts()[0].get_text() == (
            "cell 7, x = 0.075 m"
        )


def test_vectors_and_a_single_gauge_have_histories(tmp_path):
    """Displacements are seen in the pictures, and as histories where they are asked for."""
    grid, gas = make("grid", receivers=[[0.01, 0.01], [0.02, 0.02]]), make("detonation", gauges=[0.5])
    for name, component, recorded in (("grid", grid, ["receiver_velocity", "displacement"]), ("gas", gas, ["gauge_pressure"])):
        with record(component, tmp_path / f"{name}.mcap", variables=recorded):
            component.step(10 * component.step_size)
    with open_log(tmp_path / "grid.mcap") as log:
        report(log, tmp_path / "grid")
        report(log, tmp_path / "chosen", variables=["displacement"])
    with open_log(tmp_path / "gas.mcap") as log:
        report(log, tmp_path / "gas")
        assert "gauge_pressure" in from_log(log).curves
    assert {"receiver_velocity-histories.png"} == {one.name for one in (tmp_path / "grid").glob("*histories.png")}
    assert (tmp_path / "chosen" / "displacement-histories.png").exists() and (tmp_path / "gas" / "outputs.png").exists()


def test_a_drawing_in_a_page_has_no_colours_of_its_own_and_no_names_twice(log):
    scene_data = from_log(log)
    drawn = [
        drawing.svg(run_figures.space_time(scene_data.motion), "a"),
        drawing.svg(run_figures.histories(scene_data.motion), "b"),
    ]
    for svg in drawn:
        assert "currentColor" in svg and "#000000" not in svg and "#ffffff" not in svg
        assert "<style" not in svg and "<metadata" not in svg and "http" not in svg
    names = [set(re.findall(r' id="([^"]*)"', svg)) for svg in drawn]
    assert all(names) and not names[0] & names[1]
    assert "var(--c0)" in drawn[1]
    assert page_svg('<svg width="5pt"><path id="x" style="fill: #ffffff; stroke: #000000"/></svg>') == (
        '<svg><path style="fill: none; stroke: currentColor"/></svg>'
    )


@pytest.mark.skipif(browser.found() is None, reason="no Chromium here: make system-packages")
def test_figures_are_light_or_dark_with_the_page(log, tmp_path):
    page = report(log, tmp_path, variables=["velocity"])
    with browser.Browser() as chromium:
        for width in (1280, 390):
            for dark in (False, True):
                chromium.open(page, width=width, dark=dark)
                back = brightness(chromium.evaluate("getComputedStyle(document.body).backgroundColor"))
                words = brightness(chromium.evaluate("getComputedStyle(document.querySelector('.drawing svg text')).fill"))
                assert (back < 60) == dark and abs(back - words) > 120
                assert chromium.evaluate("document.documentElement.scrollWidth") <= width
                assert chromium.complaints() == []


def brightness(colour):
    return float(np.mean([float(part) for part in re.findall(r"[0-9.]+", colour)[:3]]))


def test_inputs_of_a_script_are_shown_without_an_experiment(tmp_path):
    oscillator = make("oscillator")
    with record(oscillator, tmp_path / "log.mcap"):
        oscillator.step(1.0, force=1.0)
    with open_log(tmp_path / "log.mcap") as opened:
        assert "Experiment" not in headings(report(opened, tmp_path / "page"))


class Overflowing(Discs):
    """Discs of which one output is infinite for a while."""

    def _outputs(self):
        def speed():
            return np.where((np.arange(8) == 3) & (self.tick > 5), np.inf, before["speed"]())

        before = super()._outputs()
        return before | {"speed": speed}


def test_an_infinite_number_is_no_obstacle(tmp_path):
    discs = Overflowing()
    with record(discs, tmp_path / "a.mcap", every=discs.step_size):
        for force in range(12):
            discs.step(discs.step_size, force=float(force))
    with open_log(tmp_path / "a.mcap") as log:
        field = load_field(log, "speed", 100)
        assert np.isinf(field.values).any()
        assert len(run_figures.default_indices(field)) == 5
        assert "Speed" in report(log, tmp_path / "page").read_text()
