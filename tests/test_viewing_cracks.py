"""A body in space with cracks as gaps, in a rerun scene, in pictures, and on a report page."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from support.rerun_tools import read_columns

import granular_env as ge
from granular_env.components.drawables import Cells, Links, Points
from granular_env.components.errors import ParameterError
from granular_env.recording.preview.visible_drawables import visible_cells, visible_points
from granular_env.viewing import report, save_rrd
from granular_env.viewing.figures.plane import load_plane, plane_text
from granular_env.viewing.scene_builder import load_scene, make_scene

RECORDED = ["surface_displacement", "surface_stress", "surface_plastic_strain", "surface_cells"]
ALONG, AROUND = 9, 24


def burst_tube() -> Any:
    """Return a short coarse tube that a pressure tears open at its weakest place."""
    return ge.make(
        "shell", body={"name": "tube", "length": 0.02, "along": ALONG, "around": AROUND}, material="thermoviscoplastic",
        fracture={"name": "principal_stress", "factor": 1.0, "scatter": 0.3, "seed": 1},
    )  # fmt: skip


@pytest.fixture(scope="module")
def burst_log(tmp_path_factory: pytest.TempPathFactory) -> Any:
    tube, path = burst_tube(), tmp_path_factory.mktemp("burst") / "burst.mcap"
    with ge.record(tube, path, every=80 * tube.step_size, variables=RECORDED):
        tube.step(480 * tube.step_size, pressure=2.5e7)
    return ge.open_log(path)


def present_values(rows: list[Any]) -> list[Any]:
    """Return the values of the non-empty rows."""
    return [one for one in rows if one is not None]


def test_cells_that_a_crack_crosses_fall_into_dark_pieces(burst_log: Any, tmp_path: Any) -> None:
    [mesh] = load_scene(burst_log).meshes
    assert mesh.is_solid and mesh.whole is not None
    assert mesh.whole.shape == (7, (ALONG - 1) * AROUND)
    kept = mesh.whole.sum(axis=1)
    assert mesh.whole[0].all() and kept[-1] < kept[0]
    pytest.importorskip("rerun", reason="the extra `view` is not installed")
    sent, _ = read_columns(save_rrd(burst_log, tmp_path / "burst.rrd"))
    triangles = present_values(sent["scene/cells_surface"]["triangle_indices"])
    assert [len(one) for one in triangles] == [2 * count for count in kept]
    # Cells share no corners across the gap, so each lip has separate edges.
    edges = present_values(sent["scene/edges_surface"]["strips"])
    assert len(edges) == 7 and len(edges[-1]) < len(edges[0])
    inside = present_values(sent["scene/inside_surface"]["triangle_indices"])
    assert [len(one) for one in inside] == [2 * count for count in kept]
    # A broken cell has a piece of two triangles for each corner.
    pieces = present_values(sent["scene/broken_surface"]["triangle_indices"])
    assert len(pieces[-1]) == 8 * (mesh.whole.shape[1] - kept[-1])


def test_pictures_show_the_outside_lit_and_the_inside_dark(burst_log: Any) -> None:
    plane = load_plane(burst_log, load_scene(burst_log))
    assert plane is not None and plane.scene.is_solid
    [mesh] = plane.scene.meshes
    assert "Cells crossed by a crack are dark pieces" in plane_text(plane) and "the inside is dark" in plane_text(plane)
    [surface] = visible_cells(burst_log.drawables)
    seen = plane.picture_coordinates(mesh, 0)
    # Rotated, not stretched.
    assert np.ptp(seen, axis=0).max() <= np.sqrt((np.ptp(surface.nodes, axis=0) ** 2).sum())
    assert np.allclose(plane.eye_axes.T @ plane.eye_axes, np.eye(3)) and np.linalg.det(plane.eye_axes) == pytest.approx(1.0)


def test_a_log_is_coloured_by_any_output_of_its_nodes(burst_log: Any) -> None:
    [mesh] = load_scene(burst_log, colour="surface_plastic_strain").meshes
    assert mesh.field_variable.name == "surface_plastic_strain"
    assert mesh.field is not None and np.array_equal(mesh.field[-1], burst_log.series("surface_plastic_strain")[1][-1])
    with pytest.raises(ParameterError, match="coloured by surface_stress, surface_plastic_strain, surface_cells"):
        load_scene(burst_log, colour="kinetic_energy")


def test_the_page_has_the_body_in_each_quantity_and_a_film(burst_log: Any, tmp_path: Any) -> None:
    page = report(burst_log, tmp_path / "page").read_text()
    assert 'class="film"' in page and "In space" in page and "coloured by mean plastic strain around the nodes" in page
    assert (tmp_path / "page" / "plane-surface_plastic_strain.png").is_file()
    assert ">Histories: mean plastic strain around the nodes" in page
    # The absolute size is stated too, because for a free body the largest entry may itself be rounding.
    assert re.search(r"; momentum \S+ of \S+ kg m/s", page)
    # Node numbers around a tube do not determine positions.
    assert not list((tmp_path / "page").glob("*space-time.png"))


def test_a_surface_hides_what_lies_below_it_and_what_lies_flat_beside_it() -> None:
    tube = burst_tube()
    drawn = tube.drawables()
    assert [type(one) for one in drawn] == [Cells, Points, Points, Links]
    assert visible_points(drawn) == [] and len(visible_cells(drawn)) == 1
    strip = Cells("gas", np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), np.array([[0, 1, 2, 3]]), "pressure")
    assert [one.name for one in visible_cells([*drawn, strip])] == ["surface"]
    balls = Points("balls", np.array([[0.0, 0.0, 1.0]]), np.ones(1), "moved")
    assert visible_points([*drawn, balls]) == [balls]
    [mesh] = make_scene(tube).meshes
    assert mesh.whole is not None and mesh.whole.all()
