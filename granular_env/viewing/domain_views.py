"""Views that a domain (the code for one kind of component) may add to a rerun scene, and the base class, which adds none.

`domains.Domain.views` names a subclass of `Views`; each scene has one instance.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from granular_env.domains import find_domain

if TYPE_CHECKING:
    from .scene_data import Motion, SceneData
    from .scene_scales import Scales


class Views:
    """Base class of the views of a domain; it adds no view.

    Args:
        motion: the particles in all frames of a log, or in the first frame of a live run.
        scales: scales of the scene to which the views are added.
        begin: start of a live run [s].
        end: end of a live run [s]; None if unknown.
    """

    def __init__(self, motion: Motion, scales: Scales, begin: float = 0.0, end: float | None = None) -> None:
        """Compute from `motion` and `scales` where the views lie in the scene."""

    def vertical_extent(self, scales: Scales) -> tuple[float, float]:
        """Return the lowest and highest z that the camera of the whole scene must cover [m]."""
        return scales.low[2], scales.high[2]

    def add_frame(self, motion: Motion) -> bool:
        """Add a frame of a live run; return whether `send_static` must be called again."""
        return False

    def send_static(self, recording: Any, motion: Motion, scales: Scales) -> None:
        """Send the parts of the views that do not change with time: cameras and guide lines."""

    def send_frames(
        self,
        recording: Any,
        motion: Motion,
        scales: Scales,
        positions: npt.NDArray[Any],
        colours: npt.NDArray[np.uint8],
        when: list[Any],
    ) -> None:
        """Send the parts of the views that move with the particles.

        Args:
            recording: rerun's recording.
            motion: the particles in the frames to send.
            scales: scales of the scene to which the views are added.
            positions: drawn positions of the particles, shape (frames, n, 3) [m].
            colours: colours of the particles, shape (frames, n, 3).
            when: rerun's time columns.
        """

    def send_pictures(self, recording: Any, motion: Motion, scales: Scales) -> None:
        """Send pictures that take long to draw: called once for a whole run, and now and then during a live run."""

    def full_width_panes(self, motion: Motion, scales: Scales) -> list[tuple[Any, float]]:
        """Return panes over the full width, to be shown below the whole scene, each with its share of the height."""
        return []

    def side_panes(self, motion: Motion, scales: Scales) -> list[Any]:
        """Return panes to be shown next to the plots."""
        return []

    def caption_paragraphs(self, motion: Motion, scales: Scales) -> list[str]:
        """Return the paragraphs on these views for the caption of the scene."""
        return []


def make_views(
    component: str, scene_data: SceneData, scales: Scales | None, begin: float = 0.0, end: float | None = None
) -> Views | None:
    """Return the views that the component's domain adds to a scene; None without particles; arguments as for `Views`."""
    if scene_data.motion is None or scales is None:
        return None
    return (find_domain(component).load_attribute("views") or Views)(scene_data.motion, scales, begin, end)
