"""Figures and reports: complete, self-contained, and safe for any log content."""

import re
import subprocess
import sys

import numpy as np
import pytest

from granular_env import colours
from granular_env.components.catalogue import make
from granular_env.components.errors import ParameterError, StepError
from granular_env.recording import open_log, record
from granular_env.recording.preview.displacement_scale import choose_exaggeration
from granular_env.viewing import report
from granular_env.viewing.figures import drawing, run_figures
from granular_env.viewing.recorded_fields import to_field
from granular_env.viewing.scene_builder import load_scene, make_scene
from granular_env.viewing.unit_labels import scaled_unit

HOSTILE = "<script>alert(1)</script><img src=https://example.org/x.png onerror=\"x\"> & 'more'"
PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture(scope="module")
def chain_log(tmp_path_factory):
    path = tmp_path_factory.mktemp("logs") / "chain <b>.mcap"
    chain = make("chain", grains=20, left="piston")
    with record(chain, path, every=1e-6, experiment={"name": HOSTILE, "duration": 1e-4}):
        chain.step(1e-4, left_velocity=5.0)
    return open_log(path)


@pytest.fixture(scope="module")
def oscillator_log(tmp_path_factory):
    path = tmp_path_factory.mktemp("logs") / "oscillator.mcap"
    oscillator = make("oscillator")
    with record(oscillator, path):
        oscillator.reset(position=1.0)
        for _ in range(10):
            oscillator.step(0.1, force=0.5)
    return open_log(path)


def test_scene_data_holds_what_was_recorded(chain_log):
    scene_data = load_scene(chain_log)
    times, velocity = chain_log.series("velocity")
    assert scene_data.title == HOSTILE
    np.testing.assert_array_equal(scene_data.motion.times, times)
    np.testing.assert_array_equal(scene_data.motion.colour, velocity)
    np.testing.assert_array_equal(scene_data.motion.displacement[..., 0], chain_log.series("displacement")[1])
    assert not scene_data.motion.displacement[..., 1:].any()
    assert scene_data.inputs["left_velocity"].unit == "m/s" and scene_data.inputs["left_velocity"].values[-1] == 5.0


def test_scene_data_is_thinned_but_keeps_both_ends(chain_log):
    motion = load_scene(chain_log, frames=7).motion
    times = chain_log.times("velocity")
    assert len(motion.times) == 7 and (motion.times[0], motion.times[-1]) == (times[0], times[-1])


def test_a_live_component_gives_the_same_picture_as_its_log(chain_log):
    chain = make("chain", grains=20, left="piston")
    chain.step(1e-4, left_velocity=5.0)
    live, logged = make_scene(chain).motion, load_scene(chain_log).motion
    np.testing.assert_array_equal(live.displacement[0], logged.displacement[-1])
    np.testing.assert_array_equal(live.colour[0], logged.colour[-1])
    np.testing.assert_array_equal(live.contact[0], chain.get("contact_force")[1:-1])


def test_exaggeration_shows_the_wave_and_lets_no_grains_pass(chain_log):
    motion = load_scene(chain_log).motion
    factor = choose_exaggeration(motion.reference, motion.radius, motion.displacement)
    drawn = motion.reference[:, 0] + factor * motion.displacement[..., 0]
    overlap = motion.radius[1:] + motion.radius[:-1] - np.diff(drawn, axis=1)
    assert factor > 1.0 and re.fullmatch(r"[125]0*", f"{factor:.0f}")
    # Half a radius, reduced by rounding to 1, 2, 5 (a factor of up to 2.5).
    assert 0.2 * 3e-3 <= overlap.max() <= 0.5 * 3e-3 * (1 + 1e-9)


def test_colours_are_symmetric_about_white():
    ends = colours.diverging_colours(np.array([-2.0, 0.0, 2.0, 9.0]), 2.0)
    assert [tuple(row) for row in ends] == [colours.parse_rgb(name) for name in ("#2166ac", "#f7f7f7", "#b2182b", "#b2182b")]
    assert colours.symmetric_limit([-4.91, 3.0]) == 5.0 and colours.symmetric_limit([0.0]) == 1.0


def test_figures_are_pictures_and_leave_matplotlib_alone(chain_log):
    import matplotlib

    before = dict(matplotlib.rcParams)
    scene_data = load_scene(chain_log)
    for figure in (
        run_figures.draw_balance(scene_data),
        run_figures.draw_fields([to_field(scene_data.motion)], "space-time"),
    ):
        assert drawing.to_png(figure).startswith(PNG)
    assert dict(matplotlib.rcParams) == before


def test_axes_say_what_and_in_which_unit(chain_log):
    motion = load_scene(chain_log).motion
    diagram = run_figures.draw_fields([to_field(motion)], "space-time").axes[0]
    assert diagram.get_xlabel() == "grain (0 is the left end)" and diagram.get_ylabel() == "time [\u00b5s]"
    profile = run_figures.draw_fields([to_field(motion)], "profiles", times=[motion.times[-1].item()])
    assert profile.axes[0].get_title(loc="left") == "t = 100 \u00b5s"
    np.testing.assert_array_equal(profile.axes[0].lines[0].get_ydata(), motion.colour[-1])


@pytest.mark.parametrize(("chosen", "word"), [({"times": [1.0]}, "times: got 1 s"), ({"indices": [20]}, "indices: got 20")])
def test_what_the_log_does_not_have_is_refused_and_nothing_written(chain_log, tmp_path, chosen, word):
    with pytest.raises(ParameterError, match=word):
        report(chain_log, tmp_path / "report", **chosen)
    assert not (tmp_path / "report").exists()


def test_report_of_a_chain_is_complete_and_self_contained(chain_log, tmp_path):
    html = report(chain_log, tmp_path / "new" / "folder").read_text()
    headings = re.findall(r"<h2[^>]*>([^<]*)</h2>", html)
    assert headings == [
        "x-t diagram", "Profiles at chosen times", "Histories of chosen grains", "Displacement", "Displacement: histories",
        "Inputs", "Balances", "Validity", "Parameters", "Environment", "Replay it",
    ]  # fmt: skip
    assert "default-src &#x27;none&#x27;" in html or "default-src 'none'" in html
    assert html.count("<svg") == html.count("<figure>") == 8
    assert (
        "peak contact pressure" in html
        and "replay" in html
        and "--verify" in html
        and chain_log.metadata["versions"]["numpy"] in html
    )
    for name in ("space-time", "profiles", "histories", "balance-energy", "inputs", "displacement-space-time"):
        assert (tmp_path / "new" / "folder" / f"{name}.png").read_bytes().startswith(PNG)


def test_report_escapes_what_a_log_says(chain_log, tmp_path):
    html = report(chain_log, tmp_path).read_text()
    assert "&lt;script&gt;alert(1)" in html
    tags = {tag.lower() for tag in re.findall(r"<\s*/?\s*([a-zA-Z0-9]+)", html)}
    assert not tags & {"script", "iframe", "object", "embed", "link", "base", "form", "b"}
    assert "http:" not in html and "https:" not in html.replace("https://example.org/x.png", "")
    # Every address in an attribute is an embedded picture or an anchor of the page.
    assert all(
        address.startswith(("data:image/png;base64,", "#")) for address in re.findall(r"(?:src|href)=\"([^\"]*)\"", html)
    )


def test_report_of_a_component_without_particles(oscillator_log, tmp_path):
    html = report(oscillator_log, tmp_path).read_text()
    headings = re.findall(r"<h2[^>]*>([^<]*)</h2>", html)
    assert headings == ["Outputs", "Inputs", "Balances", "Validity", "Parameters", "Environment", "Replay it"]
    with pytest.raises(ParameterError, match="none of the variables is a recorded array"):
        report(oscillator_log, tmp_path, indices=[0])


def test_a_log_of_velocities_alone_is_drawn_at_the_positions_at_the_start(tmp_path):
    chain = make("chain", grains=20, left="piston")
    with record(chain, tmp_path / "v.mcap", every=1e-6, variables=["velocity"]):
        chain.step(5e-5, left_velocity=5.0)
    with open_log(tmp_path / "v.mcap") as log:
        motion = load_scene(log).motion
        np.testing.assert_array_equal(motion.colour, log.series("velocity")[1])
        # Unknown displacements give no overlaps.
        assert not motion.displacement.any() and motion.contact is None
        html = report(log, tmp_path).read_text()
    for heading in ("x-t diagram", "Profiles at chosen times", "Histories of chosen grains"):
        assert heading in html
    assert "at the initial positions" in html


def test_failures_and_segments_stand_at_the_top_and_break_the_lines(tmp_path):
    chain = make("chain", grains=20, left="piston")
    with record(chain, tmp_path / "cut.mcap", every=1e-6):
        chain.step(2e-5, left_velocity=5.0)
        chain.reset()
        chain.step(1e-5, left_velocity=2.0)
        with pytest.raises(StepError):
            chain.step(1e-3, left_velocity=1e6)
    with open_log(tmp_path / "cut.mcap") as log:
        scene_data = load_scene(log)
        for drawn in (scene_data.motion, scene_data.curves["kinetic_energy"]):
            assert [drawn.ticks[cut] for cut in drawn.cuts] == [log.segments[0].end]
        html = report(log, tmp_path).read_text()
    line = run_figures.draw_fields([to_field(scene_data.motion)], "histories", indices=[0]).axes[0].lines[0]
    assert np.flatnonzero(np.isnan(line.get_ydata())).tolist() == scene_data.motion.cuts.tolist()
    energies = run_figures.draw_balance(scene_data).axes[0].lines[0]
    assert np.isnan(energies.get_ydata()).sum() == 1
    top = html.partition("<nav>")[0]
    assert "A step failed: StepError: " in top and "The log has 2 segments" in top


WITHOUT_MATPLOTLIB = """
import sys
sys.modules["matplotlib"] = None
import granular_env as ge
try:
    ge.viewing.report
except ge.GranularError as error:
    print(type(error).__name__, error)
"""


def test_missing_matplotlib_says_what_to_install():
    told = subprocess.run([sys.executable, "-c", WITHOUT_MATPLOTLIB], capture_output=True, text=True, check=True).stdout
    assert told.startswith("MissingExtraError") and "pip install" in told


@pytest.mark.parametrize(
    ("unit", "largest", "factor", "text"),
    [
        ("s", 1e-4, 1e6, "\u00b5s"), ("s", 0.001 * (1 - 1e-12), 1e3, "ms"), ("s", 0.5, 1.0, "s"), ("m", 2e-6, 1e6, "\u00b5m"),
        ("Pa", 3.4e6, 1e-6, "MPa"), ("N", 2e4, 1e-3, "kN"), ("m/s", 0.02, 1e3, "mm/s"), ("m/s", 1500.0, 1.0, "m/s"),
        ("m^2", 1e-4, 1e6, "mm\u00b2"), ("kg m/s", 2e-6, 1e6, "10\u207b\u2076 kg m/s"), ("1", 2e-3, 1e3, "10\u207b\u00b3"),
        ("K", 3e4, 1e-3, "10\u00b3 K"), ("m/s^2", 2e6, 1e-6, "10\u2076 m/s\u00b2"),
        ("N/m^1.5", 2e10, 1e-9, "GN/m\u00b9\u00b7\u2075"),
        ("1", 0.0, 1.0, ""), ("Pa", np.nan, 1.0, "Pa"), ("J", 5e-324, 1e300, "10\u207b\u00b3\u2070\u2070 J"),
    ],
)  # fmt: skip
def test_units_have_the_prefix_that_suits_the_values(unit, largest, factor, text):
    assert scaled_unit(unit, largest) == (factor, text)
