"""The viewpoint for a body in space, in the viewer and in reports: outside, on the side with most events."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from support.tube_tools import BODY, cracking_tube

import granular_env as ge
from granular_env.components.drawables import Cells, Points
from granular_env.components.events import Event, EventDetail
from granular_env.viewing.figures.plane import load_plane, plane_text
from granular_env.viewing.rerun.blueprint import make_blueprint
from granular_env.viewing.rerun.caption import make_caption
from granular_env.viewing.scene_builder import load_scene, make_scene
from granular_env.viewing.scene_scales import make_scales
from granular_env.viewing.viewpoint import USUAL, focus_normal, viewpoint

AROUND, ALONG = 36, 4


def tube(axis: int = 0, begin: float = 0.0, end: float = 2.0 * math.pi) -> Cells:
    """Return the surface of a tube, or a part of it, along an axis; angles are counted from the next axis but one."""
    x, turned = (part.ravel() for part in np.meshgrid(np.linspace(0.0, 6.0, ALONG + 1), np.linspace(begin, end, AROUND + 1),
                                                      indexing="ij"))  # fmt: skip
    nodes = np.roll(np.stack([x, np.sin(turned), np.cos(turned)], axis=1), axis, axis=1)
    first = np.add.outer((AROUND + 1) * np.arange(ALONG), np.arange(AROUND)).ravel()
    corners = np.stack([first, first + AROUND + 1, first + AROUND + 2, first + 1], axis=1)
    return Cells("surface", nodes, corners, "damage")


def outwards(angle: float, axis: int = 0) -> np.ndarray:
    """Return the normal of this tube at an angle."""
    return np.roll([0.0, math.sin(angle), math.cos(angle)], axis)


@dataclasses.dataclass
class FakeLog:
    """A log that has only events and drawables."""

    drawables: tuple[Any, ...]
    happened: list[Event]

    @property
    def event_details(self) -> dict[str, EventDetail]:
        return {"broken": EventDetail(counts="points"), "ignited": EventDetail(counts="gas"), "started": EventDetail()}

    def events(self) -> list[Event]:
        return self.happened

    def focus(self) -> np.ndarray | None:
        return focus_normal(self, self.drawables)


def log_of(surface: Cells, happened: list[Event] | None = None) -> FakeLog:
    """Return a log of a body with a point below the centre of each cell."""
    places = surface.nodes[surface.connectivity].mean(axis=1)
    flat = Cells("gas", np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), np.array([[0, 1, 2, 3]]), "damage")
    points = Points("points", places - 0.01 * places.mean(axis=0), np.full(len(places), 0.01), "moved")
    return FakeLog((surface, points, flat), happened or [])


def broken(cells: Any) -> list[Event]:
    """Return events at the given points."""
    return [Event(tick, "broken", int(cell), 1.0, 1.0) for tick, cell in enumerate(cells)]


def cell_at(angle: float) -> int:
    """Return the cell of a whole tube at an angle, halfway along the tube."""
    return ALONG // 2 * AROUND + int(angle / (2.0 * math.pi) * AROUND)


@pytest.mark.parametrize("axis", range(3))
def test_a_crack_anywhere_around_a_tube_is_seen(axis: int) -> None:
    surface = tube(axis)
    for angle in np.deg2rad(np.arange(5.0, 360.0, 10.0)):
        focus = log_of(surface, broken([cell_at(angle)])).focus()
        # The cells are flat, 10 degrees wide, and begin at 0.
        assert focus is not None and focus == pytest.approx(outwards(angle, axis), abs=1e-9)
        eye = viewpoint(focus)
        assert np.sqrt(eye @ eye) == pytest.approx(1.0)
        # The worst position has a small component on the hidden side: 0.6 cos(12 degrees) - 0.76 sin(12 degrees) = 0.43.
        assert eye @ outwards(angle, axis) > 0.42


def test_cracks_at_the_front_or_on_all_sides_are_seen_as_usual() -> None:
    surface = tube()
    everywhere = range(ALONG * AROUND)
    for log in (
        log_of(surface), log_of(surface, broken(everywhere)),
        log_of(surface, broken([cell_at(0.0)])), log_of(surface, broken([cell_at(5.0)])),
        log_of(surface, [Event(1, "ignited", 0, 1.0, 1.0), Event(2, "started", None, 1.0, 1.0)]),
    ):  # fmt: skip
        assert viewpoint(log.focus()) == pytest.approx(USUAL)


def test_part_of_a_tube_is_looked_at_from_its_outside() -> None:
    for begin in np.deg2rad(np.arange(0.0, 360.0, 15.0)):
        half = tube(begin=begin, end=begin + math.pi)
        facing = outwards(begin + 0.5 * math.pi)
        assert viewpoint(log_of(half).focus()) @ facing > 0.0


@pytest.fixture(scope="module")
def notched_log(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Return the log of a whole tube that cracks at a notch at the back and bottom."""
    notch = {"length": 0.003, "depth": 0.0004, "width": 0.0004, "around": 2.0, "columns": 1}
    body = ge.make(
        "shell", body={**BODY, "half": False, "along": 13, "around": 24, "notch": notch},
        fracture={"name": "principal_stress", "stress": 2.2e7}, boundaries={"start": "clamped", "end": "clamped"},
    )  # fmt: skip
    path = tmp_path_factory.mktemp("notched") / "notched.mcap"
    with ge.record(body, path, every=20 * body.step_size, variables=["surface_displacement", "surface_stress"]):
        while not body.events():
            body.step(20 * body.step_size, pressure=4e7)
    return ge.open_log(path)


def test_viewer_and_pictures_look_at_a_crack_behind_a_tube(notched_log: Any) -> None:
    scene_data = load_scene(notched_log)
    alone = load_plane(notched_log, scene_data)
    beside = load_plane(notched_log, scene_data, colour="surface_stress")
    assert alone is not None and beside is not None
    assert scene_data.viewpoint @ outwards(2.0) > 0.6
    for plane in (alone, beside):
        assert plane.eye_axes[:, 2] == pytest.approx(scene_data.viewpoint)
        assert "obliquely from below, x to the left" in plane_text(plane)
    scales = make_scales(scene_data)
    assert "Seen obliquely from below, x to the left" in make_caption(scene_data, scales, None)
    # Before any event, a live view uses the usual viewpoint.
    assert make_scene(cracking_tube()).focus_normal is None


def test_the_viewers_eye_has_all_of_the_body_in_sight(notched_log: Any) -> None:
    pytest.importorskip("rerun", reason="the extra `view` is not installed")
    scene_data = load_scene(notched_log)
    scales = make_scales(scene_data)
    assert scales is not None
    layout = make_blueprint(scene_data, scales, None, 1.0)
    [whole] = [pane for pane in panes(layout.root_container) if pane.name.startswith("In space")]
    eye = whole.properties["EyeControls3D"]
    position, target = (np.array(getattr(eye, name).as_arrow_array().to_pylist()[0]) for name in ("position", "look_target"))
    away = position - target
    distance = float(np.sqrt(away @ away))
    assert away / distance == pytest.approx(scene_data.viewpoint, abs=1e-6)
    [mesh] = scene_data.meshes
    drawn = scales.magnification * (mesh.nodes + scales.exaggeration * mesh.displacement[-1]) - position
    depth = -drawn @ away / distance
    # The field of view of rerun's eye is 55 degrees.
    assert (np.arccos(depth / np.sqrt((drawn**2).sum(axis=1))) <= np.deg2rad(27.6)).all()


def panes(container: Any) -> list[Any]:
    """Return all views of a layout."""
    contents = getattr(container, "contents", None)
    if not isinstance(contents, (list, tuple)) or any(isinstance(one, str) for one in contents):
        return [container]
    return [pane for one in contents for pane in panes(one)]
