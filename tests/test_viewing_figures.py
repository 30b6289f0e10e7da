"""Figures and reports: complete, self-contained, and harmless whatever a log says."""

import re
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from granular_env import colours, viewing
from granular_env.components.catalogue import make
from granular_env.components.errors import GranularError, MissingExtraError, ParameterError, StepError
from granular_env.domains.chain.viewing.space_time_diagram import space_time_picture
from granular_env.recording import open_log, record
from granular_env.recording.preview.displacement_scale import choose_exaggeration
from granular_env.viewing import report
from granular_env.viewing.colour_scales import ColourScale
from granular_env.viewing.figures import drawing, run_figures
from granular_env.viewing.figures.colour_bar import add_bar
from granular_env.viewing.reports.run_incidents import incident_sentences
from granular_env.viewing.scene_builder import from_component, from_log

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
    scene_data = from_log(chain_log)
    times, velocity = chain_log.series("velocity")
    assert scene_data.title == HOSTILE
    np.testing.assert_array_equal(scene_data.motion.times, times)
    np.testing.assert_array_equal(scene_data.motion.colour, velocity)
    np.testing.assert_array_equal(scene_data.motion.displacement[..., 0], chain_log.to_numpy("displacement"))
    assert not scene_data.motion.displacement[..., 1:].any()
    assert scene_data.inputs["left_velocity"].unit == "m/s" and scene_data.inputs["left_velocity"].values[-1] == 5.0


def test_overlaps_stand_in_for_forces_that_were_not_recorded(chain_log):
    motion = from_log(chain_log).motion
    u = chain_log.to_numpy("displacement")
    assert (motion.contact_name, motion.contact_unit) == ("overlap", "\u00b5m")
    # Less than 1e-12 of a radius, 3e-9 um, is shown as a mere touch; rounding of positions up to 0.1 m is 1e-11 um.
    np.testing.assert_allclose(motion.contact, np.maximum(u[:, :-1] - u[:, 1:], 0.0) * 1e6, rtol=1e-7, atol=3.1e-9)


def test_scene_data_is_thinned_but_keeps_both_ends(chain_log):
    motion = from_log(chain_log, frames=7).motion
    times = chain_log.times("velocity")
    assert len(motion.times) == 7 and (motion.times[0], motion.times[-1]) == (times[0], times[-1])


def test_a_live_component_gives_the_same_picture_as_its_log(chain_log):
    chain = make("chain", grains=20, left="piston")
    chain.step(1e-4, left_velocity=5.0)
    live, logged = from_component(chain).motion, from_log(chain_log).motion
    np.testing.assert_array_equal(live.displacement[0], logged.displacement[-1])
    np.testing.assert_array_equal(live.colour[0], logged.colour[-1])
    np.testing.assert_array_equal(live.contact[0], chain.get("contact_force")[1:-1])


def test_exaggeration_shows_the_wave_and_lets_no_grains_pass(chain_log):
    motion = from_log(chain_log).motion
    factor = choose_exaggeration(motion.reference, motion.radius, motion.displacement)
    drawn = motion.reference[:, 0] + factor * motion.displacement[..., 0]
    overlap = motion.radius[1:] + motion.radius[:-1] - np.diff(drawn, axis=1)
    assert factor > 1.0 and re.fullmatch(r"[125]0*", f"{factor:.0f}")
    # Half a radius, or less by the rounding to 1, 2, 5 (a factor of up to 2.5).
    assert 0.2 * 3e-3 <= overlap.max() <= 0.5 * 3e-3 * (1 + 1e-9)


def test_exaggeration_closes_gaps_without_passing():
    reference = np.array([[0.0, 0, 0], [2.5, 0, 0]])
    displacement = np.zeros((2, 2, 3))
    displacement[1, 0, 0] = 0.01
    assert choose_exaggeration(reference, np.ones(2), displacement) == 100.0
    assert choose_exaggeration(reference, np.ones(2), np.zeros((2, 2, 3))) == 1.0


def test_exaggeration_in_a_plane_looks_at_those_that_nearly_touch():
    """Two discs above each other, and one far away at nearly the same x, which may pass."""
    reference = np.array([[0.0, 0, 0], [0, 2.0, 0], [0.1, 40.0, 0]])
    displacement = np.zeros((2, 3, 3))
    displacement[1, 1, 1] = -0.004  # towards the first; half a radius of overlap is reached at 125 times
    displacement[1, 2, 0] = -0.1
    assert choose_exaggeration(reference, np.ones(3), displacement) == 100.0


def perceived(names):
    """CIE L*, a*, b* under daylight of colours such as #0072b2, shape (n, 3)."""
    part = np.array([colours.rgb(name) for name in names]) / 255.0
    linear = np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    cubic = np.cbrt(linear @ to_xyz.T / [0.9505, 1.0, 1.089])  # of colours that are not all but black
    x, y, z = cubic.T
    return np.column_stack([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])


def test_ten_colours_are_told_apart_in_files_and_on_pages():
    """Distances of some 2 are just seen side by side; a legend is not beside what it names."""
    palettes = [colours.PALETTE]
    sheet = next(Path(viewing.__file__).parent.glob("templates/*.css")).read_text()
    numbers, names = zip(*re.findall(r"--c(\d+): (#[0-9a-f]{6})", sheet), strict=True)
    assert list(numbers) == [str(place) for place in range(len(colours.PALETTE))] * 2, "by day and by night"
    palettes += [names[: len(colours.PALETTE)], names[len(colours.PALETTE) :]]
    for names in palettes:
        places = perceived(names)
        distances = np.linalg.norm(places[:, None] - places, axis=-1)[np.triu_indices(len(names), 1)]
        assert len(names) >= 10 and distances.min() >= 15.0


def test_events_of_eight_kinds_have_eight_colours():
    figure = run_figures.event_counts([(0.1 * k, f"kind {k}") for k in range(8)], (0.0, 1.0))
    assert len({container.patches[0].get_facecolor() for container in figure.axes[0].containers}) == 8


def test_colours_are_symmetric_about_white():
    ends = colours.diverging(np.array([-2.0, 0.0, 2.0, 9.0]), 2.0)
    assert [tuple(row) for row in ends] == [colours.rgb(name) for name in ("#2166ac", "#f7f7f7", "#b2182b", "#b2182b")]
    assert colours.symmetric_limit([-4.91, 3.0]) == 5.0 and colours.symmetric_limit([0.0]) == 1.0


def test_figures_are_pictures_and_leave_matplotlib_alone(chain_log):
    import matplotlib

    before = dict(matplotlib.rcParams)
    scene_data = from_log(chain_log)
    for figure in (
        run_figures.headline(scene_data.motion, "a title"),
        run_figures.balance(scene_data),
        run_figures.space_time(scene_data.motion),
    ):
        assert drawing.png(figure).startswith(PNG)
    assert dict(matplotlib.rcParams) == before


def test_axes_say_what_and_in_which_unit(chain_log):
    motion = from_log(chain_log).motion
    above, below = run_figures.headline(motion).axes[:2]
    assert above.get_ylabel() == "velocity [m/s]" and below.get_ylabel() == "time [\u00b5s]"
    np.testing.assert_array_equal(above.lines[0].get_ydata(), motion.colour[-1])


def test_histories_and_profiles_show_what_was_asked_for(chain_log):
    motion = from_log(chain_log).motion
    line = run_figures.histories(motion, indices=[-1]).axes[0].lines[0]
    np.testing.assert_array_equal(line.get_ydata(), motion.colour[:, 19])
    panel = run_figures.profiles(motion, times=[5e-5]).axes[0]
    np.testing.assert_array_equal(panel.lines[0].get_ydata(), motion.colour[50])


@pytest.mark.parametrize(("chosen", "word"), [({"times": [1.0]}, "times: got 1 s"), ({"indices": [20]}, "indices: got 20")])
def test_what_the_log_does_not_have_is_refused_and_nothing_written(chain_log, tmp_path, chosen, word):
    with pytest.raises(ParameterError, match=word):
        report(chain_log, tmp_path / "report", **chosen)
    assert not (tmp_path / "report").exists()


def test_the_rows_of_the_picture_are_the_instants(chain_log):
    motion = from_log(chain_log).motion
    picture = space_time_picture(motion, 10.0)
    rows = picture.rows(motion.times)
    assert (rows[0], rows[-1]) == pytest.approx((picture.bottom, picture.top))
    assert 0 < picture.top < picture.bottom < picture.pixels.shape[0] and picture.right < picture.pixels.shape[1]


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
    # Every address in an attribute is a picture of the page's own or a place on it.
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
        motion = from_log(log).motion
        np.testing.assert_array_equal(motion.colour, log.to_numpy("velocity"))
        # No overlaps are made up from displacements that nobody knows.
        assert not motion.displacement.any() and motion.contact is None
        html = report(log, tmp_path).read_text()
    for heading in ("x-t diagram", "Profiles at chosen times", "Histories of chosen grains"):
        assert heading in html
    assert "positions at the start" in html


def test_failures_and_segments_stand_at_the_top_and_break_the_lines(tmp_path):
    chain = make("chain", grains=20, left="piston")
    with record(chain, tmp_path / "cut.mcap", every=1e-6):
        chain.step(2e-5, left_velocity=5.0)
        chain.reset()
        chain.step(1e-5, left_velocity=2.0)
        with pytest.raises(StepError):
            chain.step(1e-3, left_velocity=1e6)
    with open_log(tmp_path / "cut.mcap") as log:
        scene_data = from_log(log)
        for drawn in (scene_data.motion, scene_data.curves["kinetic_energy"]):
            assert [drawn.ticks[cut] for cut in drawn.cuts] == [log.segments[0].end]
        html = report(log, tmp_path).read_text()
    line = run_figures.histories(scene_data.motion, indices=[0]).axes[0].lines[0]
    assert np.flatnonzero(np.isnan(line.get_ydata())).tolist() == scene_data.motion.cuts.tolist()
    energies = run_figures.balance(scene_data).axes[0].lines[0]
    assert np.isnan(energies.get_ydata()).sum() == 1
    top = html.partition("<nav>")[0]
    assert "A step failed: StepError: " in top and "The log has 2 segments" in top


def test_steps_that_were_written_and_undone_are_told():
    from types import SimpleNamespace

    def told(**incident):
        return incident_sentences(SimpleNamespace(incidents=[incident], segments=[1]))

    assert told(incident="failed", kind="StepError", message="too fast", undone_ticks=12) == [
        "A step failed: StepError: too fast; 12 internal steps of it, which had been written already, were undone"
    ]
    assert told(incident="interrupted", kind="KeyboardInterrupt", message="") == ["A step was interrupted (KeyboardInterrupt)"]
    assert told(incident="unrecorded", message="what happened between 1 s and 2 s is not in the log") == [
        "Steps are missing: what happened between 1 s and 2 s is not in the log."
    ]
    assert told(incident="something") == []


def test_histories_are_of_grains_that_the_wave_reached(tmp_path):
    chain = make("chain", grains=200, left="piston")
    with record(chain, tmp_path / "a.mcap", every=1e-6):
        chain.step(1e-4, left_velocity=5.0)
    with open_log(tmp_path / "a.mcap") as log:
        motion = from_log(log).motion
    chosen = run_figures.default_indices(motion)
    assert len(chosen) == 5 and chosen[0] == 0 and chosen[-1] < 100
    assert np.abs(motion.colour[:, chosen]).max(axis=0).min() > 0.1


def test_a_folder_that_cannot_be_written_is_named(oscillator_log, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(GranularError, match="file"):
        report(oscillator_log, tmp_path / "file")


def test_missing_matplotlib_says_what_to_install(oscillator_log, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "matplotlib", None)
    with pytest.raises(MissingExtraError, match="pip install"):
        report(oscillator_log, tmp_path)


def test_a_motion_without_colour_is_refused_by_name(chain_log):
    motion = replace(from_log(chain_log).motion, colour=None)
    with pytest.raises(ParameterError, match="'velocity' was not recorded"):
        run_figures.space_time(motion)


def test_the_legend_of_a_vectors_residual_names_its_directions_and_lies_within_the_figure():
    golden = Path(__file__).resolve().parent.parent / "logs" / "golden" / "shell-cracking.mcap"
    with open_log(golden) as log:
        figure = run_figures.balance(from_log(log), "momentum")
    renderer = drawing.canvas(figure, 100).get_renderer()
    below = figure.axes[1].get_legend()
    assert [text.get_text() for text in below.get_texts()] == ["x", "y", "z"]
    for axes in figure.axes[:2]:
        assert axes.get_legend().get_window_extent(renderer).x1 <= figure.bbox.x1


@pytest.mark.parametrize("limit", [4.3e8, 350e6, 9999.0, 0.0047, 3e-7])
@pytest.mark.parametrize("has_sign", [False, True])
def test_the_numbers_of_a_colour_bar_stand_apart(limit, has_sign):
    figure = drawing.new_figure(8.0, 4.0)
    add_bar(figure, ColourScale(("stress",), "Pa", limit, has_sign), ax=figure.subplots(), shrink=0.5, aspect=40)
    renderer = drawing.canvas(figure, 100).get_renderer()
    labels = [label for label in figure.axes[1].get_xticklabels() if label.get_text()]
    boxes = [label.get_window_extent(renderer) for label in labels]
    assert len(boxes) >= 3
    assert all(before.x1 + 3.0 < after.x0 for before, after in zip(boxes[:-1], boxes[1:], strict=True))


def test_names_with_missing_glyphs_print_no_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for draw in (drawing.png, lambda figure: drawing.svg(figure, "a"), lambda figure: drawing.canvas(figure, 80)):
            figure = drawing.new_figure(2.0, 1.0)
            figure.add_subplot().set_title("a\x1b[2Jb\u202ec")
            draw(figure)
