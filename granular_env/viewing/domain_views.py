"""The views that a domain may add to a scene, and the base class that adds nothing.

`domains.Domain.views` names a subclass of `Views`; one instance of it serves one scene.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from granular_env.domains import domain_of

if TYPE_CHECKING:
    from .scene_data import Motion, SceneData
    from .scene_scales import Scales


class Views:
    """The views of a domain that has none of its own.

    Args:
        motion: a whole run, or the first frame of a live one.
        scales: of the generic scene.
        begin: start of a live run [s].
        end: end of a live run [s]; None if it is not known.
    """

    def __init__(self, motion: Motion, scales: Scales, begin: float = 0.0, end: float | None = None) -> None:
        """Lay the views out."""

    def reach(self, scales: Scales) -> tuple[float, float]:
        """Return lowest and highest z that the whole scene's camera has to see [m]."""
        return scales.low[2], scales.high[2]

    def grow(self, motion: Motion) -> bool:
        """Take one more frame of a live run; return whether `send_static` has to be called again."""
        return False

    def send_static(self, recording: Any, motion: Motion, scales: Scales) -> None:
        """Send cameras and guides, which never change."""

    def send_frames(
        self,
        recording: Any,
        motion: Motion,
        scales: Scales,
        drawn: npt.NDArray[Any],
        colours: npt.NDArray[np.uint8],
        when: list[Any],
    ) -> None:
        """Send what moves with the particles.

        Args:
            recording: rerun's recording.
            motion: the frames.
            scales: of the generic scene.
            drawn: where the particles are drawn, shape (frames, n, 3) [m].
            colours: of the particles, shape (frames, n, 3).
            when: rerun's time columns.
        """

    def send_pictures(self, recording: Any, motion: Motion, scales: Scales) -> None:
        """Send pictures that take long to draw: once for a whole run, now and then for a live one."""

    def rows(self, motion: Motion, scales: Scales) -> list[tuple[Any, float]]:
        """Return panes as wide as the viewer, below the whole scene, each with its share of the height."""
        return []

    def panes(self, motion: Motion, scales: Scales) -> list[Any]:
        """Return panes next to the plots."""
        return []

    def words(self, motion: Motion, scales: Scales) -> list[str]:
        """Return the caption's paragraphs on these views."""
        return []


def make_views(
    component: str, scene_data: SceneData, scales: Scales | None, begin: float = 0.0, end: float | None = None
) -> Views | None:
    """Return the views of a component's domain for one scene, None without particles; the arguments are those of `Views`."""
    if scene_data.motion is None or scales is None:
        return None
    return (domain_of(component).load("views") or Views)(scene_data.motion, scales, begin, end)
