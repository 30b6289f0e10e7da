"""Contents of a report: all recorded data, as requested, in the reader's colour theme."""

from __future__ import annotations

import re
import tomllib

import numpy as np
import pytest
from markupsafe import Markup
from support import browser

from granular_env.cli import main
from granular_env.components.catalogue import make
from granular_env.components.errors import ParameterError
from granular_env.experiments import load_experiment
from granular_env.output_files import size_text
from granular_env.recording import open_log, record
from granular_env.viewing import plot, report
from granular_env.viewing.figures.drawing import new_figure
from granular_env.viewing.html_page import Page
from granular_env.viewing.recorded_fields import load_fields
from granular_env.viewing.reports.figures import CaptionedFigure
from granular_env.viewing.reports.page import write_page
from granular_env.viewing.scene_builder import load_scene
from granular_env.viewing.unit_labels import label_with_unit, typeset_unit

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
    """Return the page with all recorded data, and the reported progress."""
    told = []
    with open_log(log_path) as opened:
        return report(opened, tmp_path_factory.mktemp("page"), progress=told.append), told


def headings(page):
    return re.findall(r"<h2[^>]*>([^<]*)</h2>", page.read_text())


def test_every_recorded_array_has_its_figures(whole):
    page, _ = whole
    assert headings(page)[:4] == ["Velocity", "Displacement", "Overlap", "Contact force"]
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
        "3",
        "--indices",
        "7",
        "--times",
        "5e-5",
    ]
    assert main(command) == 0
    html = (tmp_path / "report.html").read_text()
    found = headings(tmp_path / "report.html")
    assert found[:2] == ["Contact force", "Inputs"]
    texts = re.findall(r"<text[^>]*>([^<]*)</text>", html)
    assert [text for text in texts if text.startswith("contact ") and text[8:].isdigit()] == ["contact 3", "contact 7"]
    assert [text for text in texts if text.startswith("t = ")] == ["t = 50 \u00b5s"]
    assert "contact force [N]" in texts


def test_the_experiment_stands_at_the_top_and_can_be_run_again(log, whole):
    html = whole[0].read_text()
    lead = html.partition("<nav>")[0]
    shipped = load_experiment(SHIPPED)
    assert " ".join(shipped.description.split())[:60] in " ".join(lead.split())
    assert f"Run report: {SHIPPED}" in lead and size_text(log.path.stat().st_size) in lead
    assert "This page did not verify the log" in html
    # The experiment file on the page is the experiment that was run.
    from html import unescape

    text = next(part for part in map(unescape, re.findall(r"<pre>(.*?)</pre>", html, re.DOTALL)) if "[component]" in part)
    assert load_experiment(tomllib.loads(text)).to_dict() == load_experiment(log.metadata["experiment"]).to_dict()


def test_parameters_that_were_left_to_the_chain_are_named(log, whole):
    html = whole[0].read_text()
    rows = dict(re.findall(r"<tr><td>(\w+)</td><td[^>]*>([^<]*)</td>", html))
    assert rows["mass"] == "automatic" and rows["step_size"] == f"{log.step_size:.6g}" and rows["gap"] == "0"
    assert all(value for name, value in rows.items() if name in log.metadata["parameters"])


def test_units_are_typeset():
    assert (
        typeset_unit("m/s^2") == "m/s\u00b2" and typeset_unit("N/m^1.5") == "N/m\u00b9\u00b7\u2075" and typeset_unit("1") == ""
    )
    assert label_with_unit("contact_force", "N") == "contact force [N]" and label_with_unit("tau", "1") == "tau"


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
    profile = plot(log, "velocity", "profiles", at=float(times[10]))
    np.testing.assert_array_equal(profile.axes[0].lines[0].get_ydata(), log.series("velocity")[1][10])
    assert plot(log, "velocity").axes[0].get_xlabel() == "grain (numbered from 0)"
    np.testing.assert_array_equal(plot(log, "kinetic_energy").axes[0].lines[0].get_ydata(), log.series("kinetic_energy")[1])
    assert plot(log, "left_velocity").axes[0].get_ylabel() == "left velocity [m/s]"


def test_a_field_along_a_curve_stands_over_its_coordinate(tmp_path):
    tube = make("detonation", length=0.4, cells=40, regions=[{"x": [0.0, 0.05], "pressure": 3e6}])
    with record(tube, tmp_path / "x.mcap", every=1e-5):
        tube.step(round(1e-4 / tube.step_size) * tube.step_size)
    with open_log(tmp_path / "x.mcap") as opened:
        field = load_fields(opened, "pressure", 100)[0]
        np.testing.assert_allclose(field.coordinates, 0.01 * (np.arange(40) + 0.5))
        assert field.ends == pytest.approx((0.0, 0.4))
        diagram = plot(opened, "pressure").axes[0]
        assert diagram.get_xlabel() == "x [m]" and diagram.get_xlim() == pytest.approx((0.0, 0.4))
        profile = plot(opened, "pressure", "profiles", at=float(field.times[-1])).axes[0]
        np.testing.assert_array_equal(profile.lines[0].get_xdata(), field.coordinates)
        assert plot(opened, "pressure", "histories", indices=[7]).axes[0].get_legend().get_texts()[0].get_text() == (
            "cell 7, x = 0.075 m"
        )


def test_vectors_and_a_single_gauge_have_histories(tmp_path):
    """Displacements are visible in the pictures, and as histories on request."""
    grid, gas = make("grid", receivers=[0, 1], forced_nodes=[0]), make("detonation", gauges=[0.5])
    for name, component, recorded in (("grid", grid, ["receiver_velocity", "displacement"]), ("gas", gas, ["gauge_pressure"])):
        with record(component, tmp_path / f"{name}.mcap", variables=recorded):
            component.step(10 * component.step_size, **({"force": [[0.0, 1e3]]} if name == "grid" else {}))
    with open_log(tmp_path / "grid.mcap") as log:
        report(log, tmp_path / "grid")
        report(log, tmp_path / "chosen", variables=["displacement"])
    with open_log(tmp_path / "gas.mcap") as log:
        report(log, tmp_path / "gas")
        assert "gauge_pressure" in load_scene(log).curves
    assert {"receiver_velocity-histories.png"} == {one.name for one in (tmp_path / "grid").glob("*histories.png")}
    assert (tmp_path / "chosen" / "displacement-histories.png").exists() and (tmp_path / "gas" / "outputs.png").exists()
    page = (tmp_path / "grid" / "report.html").read_text()
    assert "Shown in the pictures alone: displacement. The curves are shown by --variables displacement." in page


def test_two_gauges_are_curves_and_zeros_are_a_line_of_text(tmp_path):
    gas = make("detonation", length=0.4, cells=40, gauges=[0.1, 0.2])
    recorded = ["pressure", "velocity", "temperature", "gauge_pressure", "gauge_velocity"]
    with record(gas, tmp_path / "gas.mcap", every=1e-5, variables=recorded):
        gas.step(round(1e-4 / gas.step_size) * gas.step_size)
    with open_log(tmp_path / "gas.mcap") as log:
        page = report(log, tmp_path / "page")
        assert not log.series("velocity")[1].any() and log.series("gauge_pressure")[1].any()
    files = {one.stem for one in page.parent.iterdir()}
    assert {"gauge_pressure-histories", "temperature-space-time", "temperature-profiles"} <= files
    assert "gauge_pressure-space-time" not in files and not any(name.startswith("velocity") for name in files)
    zero = re.search(r"<p>Always zero: ([^<]*)\.</p>", page.read_text())[1].split(", ")
    assert {"velocity", "gauge_velocity"} <= set(zero) and "pressure" not in zero


def test_a_report_replaces_the_earlier_one(log, tmp_path):
    report(log, tmp_path, variables=["velocity"])
    (tmp_path / "mine.png").write_bytes(b"a picture of the user")
    first = {one.name for one in tmp_path.iterdir()}
    report(log, tmp_path, variables=["overlap"], file_format="pdf")
    second = {one.name for one in tmp_path.iterdir()}
    assert "velocity-space-time.png" in first and first & second == {"mine.png", "report.html"}
    assert (tmp_path / "overlap-histories.pdf").read_bytes().startswith(b"%PDF")
    with pytest.raises(ParameterError, match="got 'gif', expected one of png, svg, pdf"):
        report(log, tmp_path, file_format="gif")


def test_no_name_from_a_log_or_an_earlier_page_leaves_the_folder(tmp_path):
    (tmp_path / "kept.png").touch()
    target, page = tmp_path / "page" / "report.html", Page("title", Markup(), [])
    target.parent.mkdir()
    target.write_text('<meta name="figures" content="../kept.png">')
    write_page(target, page, {"../../evil": CaptionedFigure("heading", new_figure(1.0, 1.0), "")}, "png")
    assert {one.name for one in tmp_path.rglob("*.png")} == {"kept.png", "evil.png"} and (target.parent / "evil.png").exists()


@pytest.mark.skipif(browser.find_browser() is None, reason="no Chromium here: make system-packages")
def test_figures_are_light_or_dark_with_the_page(log, tmp_path):
    page = report(log, tmp_path, variables=["velocity"])
    with browser.Browser() as chromium:
        for width in (1280, 390):
            for dark in (False, True):
                chromium.open_page(page, width=width, dark=dark)
                back = brightness(chromium.evaluate_script("getComputedStyle(document.body).backgroundColor"))
                words = brightness(
                    chromium.evaluate_script("getComputedStyle(document.querySelector('.drawing svg text')).fill")
                )
                assert (back < 60) == dark and abs(back - words) > 120
                assert chromium.evaluate_script("document.documentElement.scrollWidth") <= width
                assert chromium.console_errors() == []


def brightness(colour):
    return float(np.mean([float(part) for part in re.findall(r"[0-9.]+", colour)[:3]]))
