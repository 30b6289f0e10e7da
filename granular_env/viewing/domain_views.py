"""The views that a domain may add to a scene, and the base class that adds nothing.

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
        motion: a whole run, or the first frame of a live run.
        scales: scales of the generic scene.
        begin: start of a live run [s].
        end: end of a live run [s]; None if unknown.
    """

    def __init__(self, motion: Motion, scales: Scales, begin: float = 0.0, end: float | None = None) -> None:
        """Compute the layout of the views."""

    def vertical_extent(self, scales: Scales) -> tuple[float, float]:
        """Return the lowest and highest z that the camera of the whole scene must cover [m]."""
        return scales.low[2], scales.high[2]

    def add_frame(self, motion: Motion) -> bool:
        """Add a frame of a live run; return whether `send_static` must be called again."""
        return False

    def send_static(self, recording: Any, motion: Motion, scales: Scales) -> None:
        """Send cameras and guides, which do not change."""

    def send_frames(
        self,
        recording: Any,
        motion: Motion,
        scales: Scales,
        positions: npt.NDArray[Any],
        colours: npt.NDArray[np.uint8],
        when: list[Any],
    ) -> None:
        """Send the parts that move with the particles.

        Args:
            recording: rerun's recording.
            motion: the frames.
            scales: scales of the generic scene.
            positions: drawn positions of the particles, shape (frames, n, 3) [m].
            colours: colours of the particles, shape (frames, n, 3).
            when: rerun's time columns.
        """

    def send_pictures(self, recording: Any, motion: Motion, scales: Scales) -> None:
        """Send pictures that take long to draw: once for a whole run, occasionally for a live run."""

    def full_width_panes(self, motion: Motion, scales: Scales) -> list[tuple[Any, float]]:
        """Return full-width panes below the whole scene, each with its share of the height."""
        return []

    def side_panes(self, motion: Motion, scales: Scales) -> list[Any]:
        """Return panes next to the plots."""
        return []

    def caption_paragraphs(self, motion: Motion, scales: Scales) -> list[str]:
        """Return the caption's paragraphs on these views."""
        return []


def make_views(
    component: str, scene_data: SceneData, scales: Scales | None, begin: float = 0.0, end: float | None = None
) -> Views | None:
    """Return the views of a component's domain for one scene, None without particles; arguments as for `Views`."""
    if scene_data.motion is None or scales is None:
        return None
    return (find_domain(component).load_attribute("views") or Views)(scene_data.motion, scales, begin, end)
