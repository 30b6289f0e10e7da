"""Links in a rerun scene: lines from centre to centre, in front of the particles; those that are broken are gone."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.colours import sequential

from .optional_packages import import_optional
from .scene_data import LinkFrames, Motion

# Radius of a line as a part of the smallest particle's; how far in front of the centres, in the largest one's.
_THICKNESS, _IN_FRONT = 0.12, 1.05


def links_entity(links: LinkFrames) -> str:
    """Return the path of the lines."""
    return f"scene/links_{links.name}"


def send_links(recording: Any, motion: Motion, drawn: npt.NDArray[Any], when: list[Any]) -> None:
    """Send the links that hold in some frames.

    Args:
        recording: rerun's recording.
        motion: the frames.
        drawn: where the particles are drawn, shape (frames, n, 3) [m].
        when: rerun's time columns.
    """
    rr = import_optional("rerun", "the viewer")
    # Towards the camera: a plane is seen from above, a row along +y.
    towards = np.array([0.0, 0.0, 1.0] if motion.is_plane else [0.0, -1.0, 0.0])
    front = (drawn + _IN_FRONT * float(motion.radius.max()) * towards).astype(np.float32)
    for links in motion.links:
        frame, link = np.nonzero(links.state)
        strips = front[frame[:, None], links.pairs[link]]
        limit = float(links.state.max(initial=0.0)) or 1.0
        radii = np.full(len(link), _THICKNESS * float(motion.radius.min()), np.float32)
        lines = rr.LineStrips3D.columns(strips=strips, colors=sequential(links.state[frame, link], limit), radii=radii)
        counts = np.count_nonzero(links.state, axis=1)
        recording.send_columns(links_entity(links), when, lines.partition(counts))
