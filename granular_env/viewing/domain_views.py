"""The views that a domain may add to a scene beside the generic parts, and the base that adds nothing.

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
        motion: what is shown: a whole run, or the first frame of one that goes on.
        scales: of the generic scene.
        begin: of a run that goes on, the instant at which it begins [s].
        end: of such a run, the instant at which it will end [s]; None where nobody knows.
    """

    def __init__(self, motion: Motion, scales: Scales, begin: float = 0.0, end: float | None = None) -> None:
        """Lay the views out."""

    def reach(self, scales: Scales) -> tuple[float, float]:
        """Return lowest and highest z that the whole scene's camera has to see [m]."""
        return scales.low[2], scales.high[2]

    def grow(self, motion: Motion) -> bool:
        """Take one more frame of a run that goes on; return whether what `send_static` sends has changed with it."""
        return False

    def send_static(self, recording: Any, motion: Motion, scales: Scales) -> None:
        """Send what never changes: cameras, guides."""

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
        """Send what takes long to draw: once for a whole run, now and then for one that goes on."""

    def rows(self, motion: Motion, scales: Scales) -> list[tuple[Any, float]]:
        """Return panes as wide as the viewer, below the whole scene, each with its share of the height."""
        return []

    def panes(self, motion: Motion, scales: Scales) -> list[Any]:
        """Return panes beside the plots."""
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
