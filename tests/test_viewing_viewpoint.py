"""From where a body in space is seen: its outside, on the side where most happens, in the viewer as in a report's pictures."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.tube_tools import BODY, cracking_tube

import granular_env as ge
from granular_env.components.drawables import Cells, Points
from granular_env.components.events import Event, EventDetail
from granular_env.components.variables import Variable
from granular_env.viewing.figures.plane import Plane, load_plane, words
from granular_env.viewing.rerun.blueprint import blueprint
from granular_env.viewing.rerun.caption import caption
from granular_env.viewing.scene_data import from_component, from_log
from granular_env.viewing.scene_scales import scales_of
from granular_env.viewing.viewpoint import focus_normal, viewpoint, viewpoint_words

# Of a body to which nothing happens: from before, above, and a little from the left.
USUAL = np.array([-0.25, -0.6, 0.76]) / math.sqrt(0.0625 + 0.36 + 0.5776)
AROUND, ALONG = 36, 4


def tube(axis: int = 0, begin: float = 0.0, end: float = 2.0 * math.pi) -> Cells:
    """Return the surface of a tube, or of a part of one, along an axis; angles are counted from the next axis but one."""
    x, turned = (part.ravel() for part in np.meshgrid(np.linspace(0.0, 6.0, ALONG + 1), np.linspace(begin, end, AROUND + 1),
                                                      indexing="ij"))  # fmt: skip
    nodes = np.roll(np.stack([x, np.sin(turned), np.cos(turned)], axis=1), axis, axis=1)
    first = np.add.outer((AROUND + 1) * np.arange(ALONG), np.arange(AROUND)).ravel()
    corners = np.stack([first, first + AROUND + 1, first + AROUND + 2, first + 1], axis=1)
    return Cells("surface", nodes, corners, "damage")


def outwards(angle: float, axis: int = 0) -> np.ndarray:
    """Return the normal of that tube at an angle."""
    return np.roll([0.0, math.sin(angle), math.cos(angle)], axis)


@dataclasses.dataclass
class FakeLog:
    """What a viewpoint is found from: events, and the last frame of a field."""

    drawables: tuple[Any, ...]
    happened: list[Event] = dataclasses.field(default_factory=list)
    last: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros(AROUND * ALONG))

    @property
    def variables(self) -> dict[str, Variable]:
        return {"damage": Variable("damage", "output", "1", self.last.shape, "damage")}

    @property
    def event_details(self) -> dict[str, EventDetail]:
        return {"broken": EventDetail(counts="points"), "ignited": EventDetail(counts="gas"), "started": EventDetail()}

    def events(self) -> list[Event]:
        return self.happened

    def times(self, name: str) -> np.ndarray:
        return np.array([0.0, 1.0])

    def get(self, name: str, time: float) -> np.ndarray:
        return self.last if time == 1.0 else np.zeros_like(self.last)

    def focus(self) -> np.ndarray | None:
        return focus_normal(self, self.drawables)


def log_of(surface: Cells, happened: list[Event] | None = None, last: Any = None) -> FakeLog:
    """Return a log of a body with a point below the middle of each cell."""
    places = surface.nodes[surface.connectivity].mean(axis=1)
    flat = Cells("gas", np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), np.array([[0, 1, 2, 3]]), "damage")
    points = Points("points", places - 0.01 * places.mean(axis=0), np.full(len(places), 0.01), "moved")
    drawn = (surface, points, flat)
    return FakeLog(drawn, happened or []) if last is None else FakeLog(drawn, happened or [], last)


def broken(cells: Any) -> list[Event]:
    """Return an event at each of some points."""
    return [Event(tick, "broken", int(cell), 1.0, 1.0) for tick, cell in enumerate(cells)]


def cell_at(angle: float) -> int:
    """Return the cell of a whole tube around an angle, halfway along it."""
    return ALONG // 2 * AROUND + int(angle / (2.0 * math.pi) * AROUND)


@pytest.mark.parametrize("axis", range(3))
def test_a_crack_anywhere_around_a_tube_is_seen(axis: int) -> None:
    surface = tube(axis)
    for angle in np.deg2rad(np.arange(5.0, 360.0, 10.0)):
        focus = log_of(surface, broken([cell_at(angle)])).focus()
        # The cells are flat, 10 degrees wide, and begin at 0.
        assert focus is not None and focus == pytest.approx(outwards(angle, axis), abs=1e-9)
        eye = viewpoint([surface], focus)
        assert np.sqrt(eye @ eye) == pytest.approx(1.0)
        # Seen least well is what lies between two eyes: 53 degrees from each, around an upright tube 63 degrees.
        assert eye @ outwards(angle, axis) > (0.45 if axis == 2 else 0.59)


def test_what_is_at_the_front_or_nowhere_is_seen_as_usual() -> None:
    surface = tube()
    everywhere = range(ALONG * AROUND)
    for log in (
        log_of(surface), log_of(surface, broken(everywhere)), log_of(surface, last=np.ones(ALONG * AROUND)),
        log_of(surface, broken([cell_at(0.0)])), log_of(surface, broken([cell_at(5.0)])),
        log_of(surface, [Event(1, "ignited", 0, 1.0, 1.0), Event(2, "started", None, 1.0, 1.0)]),
    ):  # fmt: skip
        assert viewpoint([surface], log.focus()) == pytest.approx(USUAL)
    assert viewpoint([]) == pytest.approx(USUAL)
    assert viewpoint_words(USUAL) == "obliquely from above, x to the right"


def test_without_events_a_body_is_seen_where_its_colour_is_fullest_at_the_end() -> None:
    surface, values = tube(), np.full(ALONG * AROUND, 0.1)
    values[cell_at(2.0)] = -1.0
    focus = log_of(surface, last=values).focus()
    assert focus is not None and focus @ outwards(2.0) > 0.99
    assert viewpoint_words(viewpoint([surface], focus)) == "obliquely from below, x to the left"
    # Of nodes each cell has the mean; what is no number counts for nothing.
    of_nodes = np.zeros(len(surface.nodes))
    of_nodes[surface.connectivity[cell_at(1.0)]] = 1.0
    of_nodes[surface.connectivity[cell_at(4.0)]] = np.nan
    focus = log_of(surface, last=of_nodes).focus()
    assert focus is not None and focus @ outwards(1.0) > 0.98
    # Events come first.
    focus = log_of(surface, broken([cell_at(3.0)]), values).focus()
    assert focus is not None and focus @ outwards(3.0) > 0.99


def test_part_of_a_tube_is_looked_at_from_its_outside() -> None:
    for begin in np.deg2rad(np.arange(0.0, 360.0, 15.0)):
        half = tube(begin=begin, end=begin + math.pi)
        facing = outwards(begin + 0.5 * math.pi)
        for focus in (None, *(outwards(begin + part * math.pi) for part in np.linspace(0.0, 1.0, 7))):
            # The mean of its normals is 2 / pi long; seen from aside, as much of the outside is in sight as of the inside.
            assert viewpoint([half], focus) @ facing * 2.0 / math.pi > -0.1
    for sign, begin in ((1.0, 0.0), (-1.0, math.pi)):
        plane = Plane((tube(begin=begin, end=begin + math.pi),), np.zeros(1), {}, 1.0, ())
        assert plane.eye[1, 2] * sign > 0.0 and plane.eye[2, 2] > 0.0
        assert np.allclose(plane.eye.T @ plane.eye, np.eye(3)) and np.linalg.det(plane.eye) == pytest.approx(1.0)
        assert f"x to the {'left' if sign > 0.0 else 'right'}" in words(plane)


@pytest.fixture(scope="module")
def notched_log(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Return the log of a whole tube that cracks at its notch, behind and below."""
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
    scene_data, alone = from_log(notched_log), load_plane(notched_log, None)
    beside = load_plane(notched_log, scene_data, colour="surface_stress")
    assert alone is not None and beside is not None
    assert scene_data.viewpoint @ outwards(2.0) > 0.6
    for plane in (alone, beside):
        assert plane.eye[:, 2] == pytest.approx(scene_data.viewpoint)
        assert "obliquely from below, x to the left" in words(plane)
    scales = scales_of(scene_data)
    assert "The first view looks obliquely from below, x to the left." in caption(scene_data, scales, None)
    # Before anything has happened, a live view looks as usual.
    assert from_component(cracking_tube()).focus_normal is None


def test_the_viewers_eye_has_all_of_the_body_in_sight(notched_log: Any) -> None:
    pytest.importorskip("rerun", reason="the extra `view` is not installed")
    scene_data = from_log(notched_log)
    scales = scales_of(scene_data)
    assert scales is not None
    layout = blueprint(scene_data, scales, None, 1.0)
    [whole] = [pane for pane in panes(layout.root_container) if pane.name.startswith("In space")]
    eye = whole.properties["EyeControls3D"]
    position, target = (np.array(getattr(eye, name).as_arrow_array().to_pylist()[0]) for name in ("position", "look_target"))
    away = position - target
    distance = float(np.sqrt(away @ away))
    assert away / distance == pytest.approx(scene_data.viewpoint, abs=1e-6)
    [mesh] = scene_data.meshes
    drawn = scales.magnification * (mesh.nodes + scales.exaggeration * mesh.displacement[-1]) - position
    depth = -drawn @ away / distance
    # Rerun's own eye opens 55 degrees.
    assert (np.arccos(depth / np.sqrt((drawn**2).sum(axis=1))) <= np.deg2rad(27.6)).all()


def panes(container: Any) -> list[Any]:
    """Return all views of a layout."""
    contents = getattr(container, "contents", None)
    if not isinstance(contents, (list, tuple)) or any(isinstance(one, str) for one in contents):
        return [container]
    return [pane for one in contents for pane in panes(one)]


def test_a_log_that_was_cut_is_seen_from_where_it_got_to(notched_log: Any, tmp_path: Path) -> None:
    data = Path(notched_log.path).read_bytes()
    for part in (0.5, 0.8, 0.95):
        (tmp_path / "cut.mcap").write_bytes(data[: int(part * len(data))])
        with ge.open_log(tmp_path / "cut.mcap") as log:
            assert not log.complete
            expected = outwards(2.0) if log.events() else USUAL
            assert from_log(log).viewpoint @ expected > 0.6
