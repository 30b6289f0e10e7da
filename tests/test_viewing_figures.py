"""Figures and reports: complete, self-contained, and safe for any log content."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from granular_env import colours
from granular_env.components.catalogue import make
from granular_env.components.errors import LogError, ParameterError, StepError
from granular_env.recording import open_log, record
from granular_env.recording.preview.displacement_scale import choose_exaggeration
from granular_env.viewing import plot, report
from granular_env.viewing.figures import drawing, run_figures
from granular_env.viewing.recorded_fields import to_field
from granular_env.viewing.scene_builder import load_scene, make_scene
from granular_env.viewing.unit_labels import scaled_unit

HOSTILE = "<script>alert(1)</script><img src=https://example.org/x.png onerror=\"x\"> & 'more' $\\frac$"
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
    assert diagram.get_xlabel() == "grain (numbered from 0)" and diagram.get_ylabel() == "time [\u00b5s]"
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
        "Velocity", "Displacement", "Outputs without a figure", "Inputs", "Balances", "Validity", "Parameters", "Environment",
        "Replay it",
    ]  # fmt: skip
    assert "default-src &#x27;none&#x27;" in html or "default-src 'none'" in html
    assert html.count("<svg") == html.count("<figure>") == 8
    assert (
        "peak contact pressure" in html
        and "replay" in html
        and "--verify" in html
        and chain_log.metadata["versions"]["numpy"] in html
    )
    for name in ("velocity-space-time", "velocity-profiles", "velocity-histories", "balance-energy", "inputs-left_velocity"):
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
    for caption in (">x-t diagram: ", ">Profiles: ", ">Histories: "):
        assert caption in html
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


@pytest.fixture(scope="module")
def sheet_log(tmp_path_factory):
    """A sheet of nine nodes that is pushed at one of them, with two receivers."""
    path = tmp_path_factory.mktemp("logs") / "sheet.mcap"
    grid = make(
        "grid",
        mesh={"name": "rectangle", "columns": 4, "rows": 4, "cell_size": 0.01, "centre": [0.0, 0.0]},
        material={"young": 6e10, "poisson": 0.25, "density": 2700.0},
        receivers=[[0.0, 0.01], [0.01, 0.0]], forced_nodes=[[0.02, 0.0]],
    )  # fmt: skip
    with record(grid, path, every=grid.step_size, variables=["speed", "velocity", "displacement", "receiver_velocity"]):
        grid.step(30 * grid.step_size, force=[[-1e3, 0.0]])
    return open_log(path)


@pytest.fixture(scope="module")
def dimer_log(tmp_path_factory):
    """A precompressed chain of two alternating grains after a weak push."""
    path = tmp_path_factory.mktemp("logs") / "dimer.mcap"
    chain = make(
        "chain", grains=61, arrangement={"name": "dimer", "radius": 9.525e-3, "material": ["steel", "aluminium"]},
        precompression=1.0, left="free", right="free", velocity_scale=0.5, step_size=2e-6,
    )  # fmt: skip
    with record(chain, path, every=2e-5, variables=["velocity"]):
        chain.step(2e-5, left_force=5e-3)
        chain.step(1.998e-2, left_force=0.0)
    return open_log(path)


def _texts(figure):
    return [text.get_text() for axes in figure.axes for text in (axes.get_legend().get_texts() if axes.get_legend() else ())]


def _pictures(figure):
    return [axes for axes in figure.axes if axes.get_title(loc="left").startswith("t = ")]


def test_the_default_kind_follows_from_the_variable(chain_log, sheet_log):
    assert [axes.get_ylabel() for axes in plot(chain_log, "velocity").axes] == ["time [\u00b5s]", "velocity [m/s]"]
    assert len(plot(chain_log, "energy").axes) == 2  # a balance and its residual
    assert len(plot(chain_log, "energy_residual", "balances").axes) == 2
    assert len(_pictures(plot(sheet_log, "speed"))) == 4
    assert len(_pictures(plot(sheet_log, "speed", at=0.0))) == len(_pictures(plot(sheet_log, "velocity", at=0.0))) == 1
    receivers = plot(sheet_log, "receiver_velocity")
    assert [axes.get_ylabel().partition(" [")[0] for axes in receivers.axes] == ["receiver velocity x", "receiver velocity y"]


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("speed", {"kind": "space-time"}, "kind: got 'space-time', expected one of map, histories, spectrum"),
        ("speed", {"kind": "films"}, "kind: got 'films'"),
        ("energy", {"kind": "map"}, "expected one of balances"),
        ("speed", {"indices": [1]}, "indices: does not apply to map, expected kind='histories' or 'spectrum'"),
        ("speed", {"kind": "histories", "at": 0.0}, "at: does not apply to histories"),
        ("speed", {"at": 1.0}, "at: got 1 s"),
        ("speed", {"at": "1 ms"}, "at: got '1 ms'"),
        ("speed", {"kind": "histories", "indices": [25]}, "indices: got 25"),
        ("speed", {"kind": "spectrum", "indices": [25]}, "indices: got 25"),
        ("speed", {"kind": "histories", "indices": []}, "indices: got no values"),
        ("speed", {"at": []}, "at: got no values"),
        ("kinetic_energy", {"indices": [3]}, "indices: all elements of 'kinetic_energy' are drawn"),
        ("sped", {}, "name: 'sped' was not recorded"),
        (["speed"], {}, "was not recorded"),
    ],
)
def test_plot_refuses_what_does_not_apply(sheet_log, name, options, words):
    with pytest.raises(ParameterError, match=re.escape(words)):
        plot(sheet_log, name, **options)


def test_a_closed_log_is_refused_as_closed(tmp_path):
    oscillator = make("oscillator")
    with record(oscillator, tmp_path / "o.mcap"):
        oscillator.step(0.1)
    with open_log(tmp_path / "o.mcap") as log:
        pass
    with pytest.raises(LogError, match="the log is closed"):
        plot(log, "position")


def test_axes_have_units_with_prefixes(chain_log, sheet_log):
    overlap = plot(chain_log, "displacement", "histories", indices=[3]).axes[0]
    assert overlap.get_ylabel() == "displacement [\u00b5m]"
    assert len(plot(chain_log, "displacement", "histories", indices=np.int64(3)).axes[0].lines) == 1
    np.testing.assert_array_equal(overlap.lines[0].get_ydata(), 1e6 * chain_log.series("displacement")[1][:, 3])
    assert plot(sheet_log, "force").axes[0].get_ylabel() == "force [N]"


def test_legends_name_directions_and_positions(chain_log, sheet_log):
    assert _texts(plot(chain_log, "velocity", "histories", indices=[2])) == ["grain 2, x = 0.012 m"]
    receivers = _texts(plot(sheet_log, "receiver_velocity"))[:2]
    assert receivers == [
        "receiver 0, x = 0 mm, y = 10 mm",
        "receiver 1, x = 10 mm, y = 0 mm",
    ]
    assert _texts(plot(sheet_log, "force")) == ["force x, forced node 0, x = 20 mm, y = 0 mm"]
    # Nodes are numbered from the corner x = y = -0.02 m along x.
    assert _texts(plot(sheet_log, "velocity", "histories", indices=[6]))[0] == "node 6, x = -10 mm, y = -10 mm"


def test_the_spectrum_of_a_sine_is_a_line_of_its_amplitude(tmp_path):
    # m u'' = -k u from u = 1: leapfrog oscillates with sin(w h / 2) = (h / 2) sqrt(k / m); 40 ticks are a period.
    step = 2.0 * np.sin(np.pi / 40.0)
    oscillator = make("oscillator", mass=1.0, stiffness=1.0, step_size=step)
    with record(oscillator, tmp_path / "o.mcap", every=step):
        oscillator.reset(position=2.0)
        oscillator.step(799 * step)
    with open_log(tmp_path / "o.mcap") as log:
        line = plot(log, "position", "spectrum").axes[0].lines[0]
        frequency, amplitude = line.get_data()
        # 800 frames are 20 periods.
        assert frequency[np.argmax(amplitude)] == pytest.approx(1.0 / (40.0 * step), rel=1e-12)
        assert amplitude.max() == pytest.approx(2.0, rel=1e-9) and np.sort(amplitude)[-2] < 1e-9
        oscillator.reset()


def test_a_spectrum_needs_frames_at_even_intervals(tmp_path):
    chain = make("chain", grains=20, left="piston")
    with record(chain, tmp_path / "cut.mcap", every=1e-6):
        chain.step(2e-5, left_velocity=5.0)
        chain.reset()
        chain.step(2e-5, left_velocity=5.0)
    with open_log(tmp_path / "cut.mcap") as log, pytest.raises(ParameterError, match="no common interval.*`every`"):
        plot(log, "velocity", "spectrum")


def test_the_measured_dispersion_of_a_dimer_is_that_of_the_theory(dimer_log):
    axes = plot(dimer_log, "velocity", "dispersion").axes[0]
    assert _texts(axes.figure) == ["theory, acoustic", "theory, optical"]
    mesh = axes.collections[0]
    decibels = np.asarray(mesh.get_array())
    phases, frequencies = (
        0.5 * (edges[1:] + edges[:-1]) for edges in (mesh.get_coordinates()[0, :, 0], mesh.get_coordinates()[:, 0, 1])
    )
    gap = frequencies[1] - frequencies[0]
    acoustic, optical = (np.interp(phases, *line.get_data()) for line in axes.lines)
    middle = 0.5 * (acoustic.max() + optical.min())
    for branch, own in ((acoustic, frequencies < middle), (optical, frequencies > middle)):
        peaks = frequencies[own][np.argmax(decibels[own], axis=0)]
        strong = decibels[own].max(axis=0) > -40.0
        # A Hann window of 61 grains has zeros at two phases of 2 pi / 61; the steepest slope is 3 kHz / (pi / 2) x pi / 2.
        assert strong.sum() > 20 and np.abs(peaks - branch)[strong].max() < 2.0 * gap + 2.0 * 2.0 * np.pi / 61.0 * 3.0


def test_a_chain_without_precompression_has_no_theoretical_dispersion(chain_log):
    assert not plot(chain_log, "velocity", "dispersion").axes[0].lines


@pytest.mark.filterwarnings("ignore:constrained_layout not applied")  # the title is longer than the figure
def test_several_logs_share_their_axes(chain_log, tmp_path):
    branch = chain_log.branch(5e-5)
    with record(branch.component, tmp_path / "branch.mcap", every=1e-6):
        branch.component.step(5e-5, left_velocity=2.5)
    with open_log(tmp_path / "branch.mcap") as other:
        logs = [chain_log, other]
        histories = plot(logs, "velocity", "histories", indices=[0, 5])
        assert _texts(histories)[:2] == [f"{HOSTILE}: grain 0, x = 0 m", "branch (chain): grain 0, x = 0 m"]
        assert len(histories.axes[0].lines) == 4 and drawing.to_png(histories).startswith(PNG)
        assert len(plot(logs, "velocity", "profiles", at=[6e-5, 1e-4]).axes[0].lines) == 2
        assert len(plot(logs, "velocity", "spectrum", indices=[0]).axes[0].lines) == 2
        assert _texts(plot(logs, "kinetic_energy"))[0] == f"{HOSTILE}: kinetic energy"
        assert _texts(plot([other, other], "kinetic_energy"))[0].endswith("branch.mcap: kinetic energy")
        with pytest.raises(
            ParameterError, match="expected one of profiles, histories, spectrum for 'velocity' of several logs"
        ):
            plot(logs, "velocity", "space-time")


def test_a_figure_shows_itself_in_a_notebook(chain_log):
    assert plot(chain_log, "velocity")._repr_png_().startswith(PNG)


def test_the_history_of_a_tensor_shows_the_entries_of_one_element():
    with open_log(Path(__file__).resolve().parent.parent / "logs" / "golden" / "grid-edges.mcap") as log:
        values = log.series("stress")[1]
        panels = plot(log, "stress", "histories", indices=[5]).axes
        assert [axes.get_ylabel().split(" [")[0] for axes in panels] == ["stress xx", "stress yy", "stress zz", "stress xy"]
        for entry, axes in enumerate(panels):
            drawn = np.ravel(axes.lines[0].get_ydata())
            np.testing.assert_allclose(drawn / np.abs(drawn).max(), values[:, 5, entry] / np.abs(values[:, 5, entry]).max())


def test_the_history_of_a_recorded_input_has_both_values_at_a_jump(tmp_path):
    chain = make("chain", grains=5, left="piston")
    with record(chain, tmp_path / "a.mcap", every=1e-6):
        chain.step(1e-5, left_velocity=1.0)
        chain.step(1e-5, left_velocity=5.0)
    with open_log(tmp_path / "a.mcap") as log:
        assert "left_velocity" in log.variables
        [line] = plot(log, "left_velocity").axes[0].lines
        assert np.unique(line.get_ydata()).tolist() == [1.0, 5.0]


def test_objects_have_tables_in_a_notebook(chain_log):
    component = make("discs", rows=1, columns=2)
    for shown, words in ((chain_log, ["velocity", "101"]), (component, ["breaking_strain", "0.01"])):
        html = shown._repr_html_()
        assert all(word in html for word in words) and "<script" not in html
    assert "&lt;script&gt;" in chain_log._repr_html_()
    assert len(repr(chain_log.drawables)) < 300
