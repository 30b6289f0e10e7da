"""Distant cameras, for which spheres stay round.

Rerun's 3D camera has a field of view of 55 degrees, so a pane much wider than high would stretch the shapes at its ends. A
distant pinhole camera is nearly a parallel projection, shows the same entities, and always fits its pane.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

# Distance of the camera in widths of its picture, whose ends are then at 18 degrees; if larger, single precision distorts.
_DISTANCE = 1.5
_PIXELS = 2000.0
# Smallest distance of the camera [m]; rerun clips everything closer than 0.1 m.
_NEAREST = 0.15


# Columns are the camera's directions right, down and forward: along +y with z up (a row from the side), or along -z with y up
# (a plane from above).
_SIDE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
_ABOVE = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])


@dataclass(frozen=True)
class Camera:
    """A camera with x to the right that looks along +y (z up), or from above along -z (y up).

    Attributes:
        path: path of its entity.
        middle: centre of its picture: x and z (from above: x and y) [m].
        width, height: visible extent [m].
        is_above: whether it looks from above.
    """

    path: str
    middle: tuple[float, float]
    width: float
    height: float
    is_above: bool = False

    @property
    def _image_size(self) -> tuple[float, float]:
        return _PIXELS, _PIXELS * self.height / self.width

    @property
    def _distance(self) -> float:
        return max(_DISTANCE * self.width, _NEAREST)

    @property
    def position(self) -> tuple[float, float, float]:
        """Return the camera's position [m]."""
        x, other = self.middle
        return (x, other, self._distance) if self.is_above else (x, -self._distance, other)

    def send(self, recording: Any) -> None:
        """Send the camera to the scene."""
        width, height = self._image_size
        place = rr.Transform3D(translation=self.position, mat3x3=_ABOVE if self.is_above else _SIDE)
        length, axes = self._distance / self.width * width, rr.ViewCoordinates.RDF
        lens = rr.Pinhole(focal_length=length, width=width, height=height, camera_xyz=axes)
        recording.log(self.path, place, lens, static=True)

    def make_pane(self, name: str, contents: list[str]) -> Any:
        """Return a pane that shows entities with this camera."""
        across, down = self._image_size
        return rrb.Spatial2DView(
            origin=self.path,
            contents=contents,
            name=name,
            background=[13, 16, 17],
            visual_bounds=rrb.VisualBounds2D(x_range=[0.0, across], y_range=[0.0, down]),
        )
