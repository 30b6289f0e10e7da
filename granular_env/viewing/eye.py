"""Eyes that look at a row of grains from the side, from so far away that spheres stay round.

Rerun's own 3D eye opens 55 degrees, so a pane that is many times wider than high would stretch the grains at its ends. A
pinhole far away is nearly a parallel projection, shows the same entities, and always fits its pane.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .extras import needed

# Distance in widths: the ends are seen at 18 degrees. Further away, rerun's single precision frays the spheres.
_DISTANCE = 1.5
_PIXELS = 2000.0


@dataclass(frozen=True)
class Eye:
    """An eye that looks along +y; x to the right, z up.

    Attributes:
        path: its entity.
        middle: what it looks at, x and z [m].
        width, height: what it sees [m].
    """

    path: str
    middle: tuple[float, float]
    width: float
    height: float

    @property
    def _image(self) -> tuple[float, float]:
        return _PIXELS, _PIXELS * self.height / self.width

    def send(self, recording: Any) -> None:
        """Put the eye into the scene."""
        rr = needed("rerun", "the viewer")
        distance = _DISTANCE * self.width
        across, down = self._image
        # Columns: where the eye's right, down and forward point to.
        turned = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
        place = rr.Transform3D(translation=[self.middle[0], -distance, self.middle[1]], mat3x3=turned)
        lens = rr.Pinhole(focal_length=_DISTANCE * across, width=across, height=down, camera_xyz=rr.ViewCoordinates.RDF)
        recording.log(self.path, place, lens, static=True)

    def view(self, name: str, contents: list[str]) -> Any:
        """A pane that shows entities through this eye."""
        rrb = needed("rerun.blueprint", "the viewer")
        across, down = self._image
        return rrb.Spatial2DView(
            origin=self.path,
            contents=contents,
            name=name,
            background=[13, 16, 17],
            visual_bounds=rrb.VisualBounds2D(x_range=[0.0, across], y_range=[0.0, down]),
        )
