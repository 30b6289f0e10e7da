"""Planes in the viewer and on the page: cells, discs with spokes and cracks, colour scales, the film."""

from __future__ import annotations

import re

import numpy as np
import pytest
from support.rerun_tools import read_columns

import granular_env as ge
from granular_env.colours import colour_scales
from granular_env.components.drawables import Cells, Links, Points
from granular_env.components.variables import Variable
from granular_env.recording.event_places import event_place, position_text
from granular_env.viewing import LiveViewer, report, save_rrd
from granular_env.viewing.cracks import MOST_LINES, crack_lines
from granular_env.viewing.figures.keys import displacement_notes
from granular_env.viewing.figures.plane import load_plane
from granular_env.viewing.rerun.scene import whole_camera
from granular_env.viewing.scene_builder import load_scene, make_scene
from granular_env.viewing.scene_scales import make_scales

ROCK = {"density": 2700.0, "young": 6e10, "poisson": 0.25}
BRITTLE = {"name": "mohr_coulomb", "cohesion": 2e6, "internal_friction": 0.4, "tensile": 1e6}


def coupled_body(**automata):
    """Return a grid next to automata, with a moving left side."""
    part = {"name": "rectangle", "columns": 6, "rows": 4, "cell_size": 5e-3}
    beside = {"name": "rectangle", "width": 0.03, "height": 0.02}
    return ge.make(
        "coupled", origin=[0.03, 0.0],
        grid={"mesh": part, "material": ROCK, "boundaries": {"left": {"name": "velocity", "components": "x"}}},
        automata={"shape": beside, "diameter": 5e-3, "packing": "square", "material": ROCK, **automata},
    )  # fmt: skip


@pytest.fixture(scope="module")
def coupled_log(tmp_path_factory):
    """Return the log of a body pushed from the left."""
    path, coupled = tmp_path_factory.mktemp("coupled") / "coupled.mcap", coupled_body()
    variables = ["grid_speed", "grid_displacement", "automata_speed", "automata_displacement"]
    with ge.record(coupled, path, every=2e-6, variables=variables):
        coupled.step(1e-5, grid_left_velocity=[0.5, 0.0])
    return ge.open_log(path)


@pytest.fixture(scope="module")
def cracking_log(tmp_path_factory):
    """Return the log of a torn brittle specimen whose many automata would be hidden by intact links."""
    path = tmp_path_factory.mktemp("cracking") / "cracking.mcap"
    automata = ge.make(
        "automata", shape={"name": "rectangle", "width": 0.03, "height": 0.03}, diameter=2e-3, packing="square", material=ROCK,
        criterion=BRITTLE, boundaries={"bottom": "fixed", "top": "velocity"},
    )  # fmt: skip
    with ge.record(automata, path, every=2e-6, variables=["displacement", "rotation", "damage", "linked"]):
        automata.step(2e-5, top_velocity=[0.3, 2.0])
    return ge.open_log(path)


def test_a_grid_and_automata_are_drawn_side_by_side_in_the_same_colours(coupled_log, tmp_path):
    pytest.importorskip("rerun", reason="the extra `view` is not installed")
    scene_data = load_scene(coupled_log)
    scales = make_scales(scene_data)
    found, _ = read_columns(save_rrd(coupled_log, tmp_path / "scene.rrd"))
    cells, nodes = next(one for one in coupled_log.drawables if isinstance(one, Cells)), scene_data.meshes[0]
    drawn = np.array([row for row in found["scene/cells_grid"]["vertex_positions"] if row is not None])
    moved = coupled_log.series("grid_displacement")[1]
    np.testing.assert_allclose(drawn[:, :, :2], cells.nodes + scales.exaggeration * moved, atol=1e-7)
    triangles = next(row for row in found["scene/cells_grid"]["triangle_indices"] if row is not None)
    assert len(triangles) == 2 * len(cells.connectivity)
    # The nodes of the grid are not particles, both parts share one scale, and the legend explains it.
    assert scene_data.motion.name == "automata" and len(scene_data.motions) == 1 and nodes.located
    (scale,) = scales.colours
    assert scale.names == ("automata_speed", "grid_speed") and scale.unit == "m/s" and not scale.has_sign
    assert any(row is not None for row in found["legend"]["buffer"])
    words = next(row for row in found["caption"]["text"] if row is not None)[0]
    assert "Grid: 24 cells" in words and "automata" in words and "grid\\_speed" in words


def test_a_grid_alone_has_a_scene_also_while_it_runs(tmp_path):
    pytest.importorskip("rerun", reason="the extra `view` is not installed")
    mesh = {"name": "rectangle", "columns": 4, "rows": 3, "cell_size": 5e-3}
    grid = ge.make("grid", mesh=mesh, material=ROCK, boundaries={"left": {"name": "velocity", "components": "x"}})
    with LiveViewer(grid, save=tmp_path / "live.rrd"):
        grid.step(1e-5, left_velocity=[0.5, 0.0])
    found, _ = read_columns(tmp_path / "live.rrd")
    drawn = [row for row in found["scene/cells_grid"]["vertex_positions"] if row is not None]
    assert len(drawn) >= 2 and not any(name.startswith("scene/particles") for name in found)
    assert np.ptp(np.array(drawn[-1]), axis=0)[0] > 0.0 and make_scene(grid).motion is None


def test_cells_that_never_move_are_drawn_without_a_word_on_displacements(tmp_path):
    pytest.importorskip("rerun", reason="the extra `view` is not installed")
    tube = ge.make("detonation", cells=50)
    with ge.record(tube, tmp_path / "tube.mcap", every=2 * tube.step_size, variables=["pressure"]):
        tube.step(8 * tube.step_size)
    with ge.open_log(tmp_path / "tube.mcap") as log:
        found, _ = read_columns(save_rrd(log, tmp_path / "scene.rrd"))
        page = report(log, tmp_path / "report").read_text()
    colours = [row for row in found["scene/cells_tube"]["vertex_colors"] if row is not None]
    assert len(colours) == 5 and len(colours[0]) == 4 * 50  # one colour per cell, so corners are not shared
    words = next(row for row in found["caption"]["text"] if row is not None)[0]
    assert "isplacement" not in words and "isplacement" not in page.partition("Validity")[0]
    # The pressure is also drawn along x.
    assert ">Profiles: pressure" in page and ">Histories: pressure" in page and 'class="film"' in page


def test_cracks_lie_across_broken_links_while_their_ends_are_near():
    rest, up = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]]), np.array([0.0, 0.0, 1.0])
    places = rest + [[0.0, 0.0, 0.0], [0.2, 0.0, 0.0], [0.2, 0.0, 0.0], [3.0, 0.0, 0.0]]
    pairs = np.array([[0, 1], [1, 2], [2, 3]])
    assert crack_lines(places, rest, pairs, np.ones(3), up).shape == (0, 2, 3)
    (line,) = crack_lines(places, rest, pairs, np.array([0.0, 1.0, 0.0]), up)  # the other broken link has opened too far
    np.testing.assert_allclose(sorted(line.tolist()), [[0.6, -0.3, 0.0], [0.6, 0.3, 0.0]])


def test_cracked_automata_have_spokes_and_cracks_and_no_links_over_them(cracking_log, tmp_path):
    pytest.importorskip("rerun", reason="the extra `view` is not installed")
    found, _ = read_columns(save_rrd(cracking_log, tmp_path / "scene.rrd"))
    links = next(one for one in cracking_log.drawables if isinstance(one, Links))
    broken = np.count_nonzero(cracking_log.series("linked")[1] == 0.0, axis=1)
    cracks = [len(row) for row in found["scene/cracks_links"]["strips"] if row is not None]
    assert len(links.pairs) > MOST_LINES and "scene/links_links" not in found
    assert cracks[0] == 0 < max(cracks) and all(np.array(cracks) <= broken)
    turned = cracking_log.series("rotation")[1][-1]
    spokes = np.array(found["scene/spokes_automata"]["strips"][-1])
    along = spokes[:, 1] - spokes[:, 0]
    np.testing.assert_allclose(np.arctan2(along[:, 1], along[:, 0]), turned, atol=1e-4)
    # The cracks are in front of the discs, on the rays from the camera to their centres.
    scene_data = load_scene(cracking_log)
    scales = make_scales(scene_data)
    eye = np.array(whole_camera(scene_data, scales, None).position) / scales.magnification
    centres = np.array(found["scene/particles_automata"]["positions"][-1])
    rays, seen = spokes[:, 0] - eye, centres - eye
    assert (rays[:, 2] - seen[:, 2] >= scene_data.motion.radius).all()
    np.testing.assert_allclose(rays[:, :2] / rays[:, 2:], seen[:, :2] / seen[:, 2:], atol=1e-6)


def test_a_small_scene_is_magnified_for_the_viewer(cracking_log):
    scene_data = load_scene(cracking_log)
    scales = make_scales(scene_data, 1.0)
    assert scales.magnification == 10.0
    camera = whole_camera(scene_data, scales, None)
    assert camera.is_above and camera.width == pytest.approx(10.5 * (scales.high[0] - scales.low[0]))


def test_outputs_of_one_unit_share_a_scale_and_outstanding_values_do_not_set_it():
    speed, other = (Variable(name, "output", "m/s", (), "") for name in ("grid_speed", "automata_speed"))
    damage = Variable("damage", "output", "1", (), "")
    values = np.linspace(0.0, 1.0, 2001)
    shared, own = colour_scales([(speed, values), (damage, np.zeros(3)), (other, 2.0 * values)], is_plane=True)
    assert shared.names == ("grid_speed", "automata_speed") and shared.limit == 2.0 and not shared.is_exceeded
    assert own.names == ("damage",) and own.limit == 1.0
    (capped,) = colour_scales([(speed, np.append(values, 50.0))], is_plane=True)
    assert capped.is_exceeded and capped.limit == pytest.approx(1.0)
    (row,) = colour_scales([(speed, np.append(values, -50.0))])
    assert row.limit == 50.0 and row.has_sign and not row.is_exceeded


def test_the_page_has_a_film_with_events_on_its_time_axis_and_no_script(cracking_log, tmp_path):
    page = report(cracking_log, tmp_path / "report").read_text()
    frames = len(cracking_log.times("displacement"))
    instants = re.findall(r'type="radio" name="instant" aria-label="t = ([^"]+)"(?: checked)?><img src="data:image/png', page)
    assert len(instants) == frames and instants[0] == "0 \u00b5s" and instants[-1] == "20 \u00b5s"
    assert "<script" not in page and "img-src data:" in page
    events = cracking_log.events()
    strip = re.search(r'<svg class="events".*?</svg>', page, re.DOTALL)[0]
    times = [event.tick * cracking_log.step_size for event in events]
    counts, _ = np.histogram(times, cracking_log.times("displacement"))
    assert strip.count("<rect") == np.count_nonzero(counts)
    assert f"{sum(event.kind == 'tension_break' for event in events)} tension break" in page
    heads = re.search(r"<tr>(?=<th[^>]*>time \[s\])(.*?)</tr>", page)[1]
    expected = ["time [s]", "event", "index", "value", "limit", "unit", "element", "position [m]"]
    assert re.findall(r">([^<]+)</th>", heads) == expected
    place = event_place(events[0].index, cracking_log.event_details[events[0].kind], cracking_log.drawables)
    assert f"<td>Pa</td><td>{place.elements}</td><td>{position_text(place.position)}</td>" in page
    assert all(text.replace(">", "&gt;") in page for text in cracking_log.metadata["conclusions"])
    # Numbers in a packing do not determine positions, so there is no x-t diagram unless requested.
    assert ">Histories: " in page and "x-t diagram" not in page and "Profiles" not in page
    chosen = report(cracking_log, tmp_path / "chosen", variables=["damage"]).read_text()
    assert 'class="film"' not in chosen and "x-t diagram" in chosen


@pytest.mark.parametrize(
    ("component", "recorded", "colours", "notes"),
    [
        (coupled_body(criterion=BRITTLE), ["automata_damage", "grid_displacement"], {"automata": "automata_damage"}, ["grid"]),
        (coupled_body(), ["automata_displacement", "grid_pressure"], {"grid": "grid_pressure"}, ["automata"]),
        (ge.make("grid"), ["pressure"], {"grid": "pressure"}, []),
        (ge.make("discs"), ["displacement", "linked"], {}, ["discs"]),
        (ge.make("detonation"), ["velocity"], {"tube": "velocity"}, []),
        (ge.make("chain", grains=5), ["displacement", "contact_force"], {"grains": "displacement"}, []),
    ],
    ids=["coupled by damage", "coupled by pressure", "grid", "discs", "detonation", "chain"],
)
def test_what_was_recorded_colours_what_names_another_output(tmp_path, component, recorded, colours, notes):
    """All views take the colour from `from_log`; states of links and cells colour nothing; a note names uncoloured shapes."""
    pytest.importorskip("matplotlib", reason="the extra `view` is not installed")
    with ge.record(component, tmp_path / "one.mcap", variables=recorded):
        component.step(10 * component.step_size)
    with ge.open_log(tmp_path / "one.mcap") as log:
        scene_data = load_scene(log)
        plane = load_plane(log, scene_data)
        drawn = {one.name: one.colour_variable.name for one in scene_data.motions if one.colour is not None}
        drawn |= {one.name: one.field_variable.name for one in scene_data.meshes if one.field is not None}
        assert drawn == colours
        assert plane is None or {name for scale in plane.scales.colours for name in scale.names} <= set(colours.values())
        said = " ".join(scene_data.notes)
        assert all(f"was not recorded: {name} colours the {one}" in said for one, name in colours.items())
        grey = re.findall(r"nothing colours the (\w+)\. The recorded arrays are ([\w, ]*)", said)
        assert grey == [(one, ", ".join(sorted(recorded))) for one in notes]
        if plane is not None:
            movable = {
                one.name: one.displacement for one in log.drawables if isinstance(one, Points | Cells) and one.displacement
            }
            still = ", ".join(one.name for one in plane.scene.shapes if movable.get(one.name, recorded[0]) not in recorded)
            assert (displacement_notes(plane)[-1:] == [f"{still}: initial positions"]) == bool(still)
