"""Cameras that look at a scene from so far away that spheres stay round.

Rerun's own 3D camera opens 55 degrees, so a pane that is many times wider than high would stretch the shapes at its ends. A
pinhole far away is nearly a parallel projection, shows the same entities, and always fits its pane.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

# Distance in widths: the ends are seen at 18 degrees. Further away, rerun's single precision frays the spheres.
_DISTANCE = 1.5
_PIXELS = 2000.0
# Rerun draws nothing that is nearer than 0.1 to a camera [m].
_NEAREST = 0.15


# The camera's directions right, down and forward, as columns: along +y with z up (a row is seen from the side), or along -z
# with y up (a plane is seen from above).
_SIDE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
_ABOVE = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])


@dataclass(frozen=True)
class Camera:
    """A camera with x to the right, that looks along +y (z up) or from above, along -z (y up).

    Attributes:
        path: its entity.
        middle: what it looks at: x, and z (or y, from above) [m].
        width, height: what it sees [m].
        is_above: whether it looks from above.
    """

    path: str
    middle: tuple[float, float]
    width: float
    height: float
    is_above: bool = False

    @property
    def _image(self) -> tuple[float, float]:
        return _PIXELS, _PIXELS * self.height / self.width

    @property
    def _distance(self) -> float:
        return max(_DISTANCE * self.width, _NEAREST)

    @property
    def place(self) -> tuple[float, float, float]:
        """Return where it is [m]."""
        x, other = self.middle
        return (x, other, self._distance) if self.is_above else (x, -self._distance, other)

    def send(self, recording: Any) -> None:
        """Put the camera into the scene."""
        width, height = self._image
        place = rr.Transform3D(translation=self.place, mat3x3=_ABOVE if self.is_above else _SIDE)
        lens = rr.Pinhole(
            focal_length=self._distance / self.width * width, width=width, height=height, camera_xyz=rr.ViewCoordinates.RDF
        )
        recording.log(self.path, place, lens, static=True)

    def view(self, name: str, contents: list[str]) -> Any:
        """Return a pane that shows entities through this camera."""
        across, down = self._image
        return rrb.Spatial2DView(
            origin=self.path,
            contents=contents,
            name=name,
            background=[13, 16, 17],
            visual_bounds=rrb.VisualBounds2D(x_range=[0.0, across], y_range=[0.0, down]),
        )
