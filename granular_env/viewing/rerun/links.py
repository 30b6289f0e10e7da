"""Links and turns in a rerun scene, in front of the particles: lines where links hold, cracks where they broke, spokes."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.colours import sequential
from granular_env.components.support.float_arrays import FloatArray
from granular_env.optional_packages import import_optional

from ..cracks import MOST_LINES, crack_lines
from ..scene_data import LinkFrames, Motion
from .entity_paths import entity

# Radius of a line as a part of the smallest particle's; how far in front of the centres, in the largest one's: a line lies on
# the ray from the camera through its place, so that it is seen at it, however far from the middle of the picture.
_THICKNESS, _CRACK_THICKNESS, _SPOKE_THICKNESS, _IN_FRONT = 0.12, 0.16, 0.05, 1.05
# A crack is seen on the grounds of the dark and of the light theme, and on every colour of particles.
_CRACK, _SPOKE = (190, 0, 255), (90, 95, 100)
_SPOKE_LENGTH = 0.9


def links_entity(links: LinkFrames) -> str:
    """Return the path of the lines."""
    return entity("scene/links_", links.name)


def cracks_entity(links: LinkFrames) -> str:
    """Return the path of the cracks."""
    return entity("scene/cracks_", links.name)


def send_links(recording: Any, motion: Motion, drawn: npt.NDArray[Any], eye: FloatArray, when: list[Any]) -> None:
    """Send the cracks of some frames and, unless they would hide the particles, the links that hold.

    Args:
        recording: rerun's recording.
        motion: the frames.
        drawn: where the particles are drawn, shape (frames, n, 3) [m].
        eye: where the camera is that sees them, shape (3,) [m].
        when: rerun's time columns.
    """
    towards = _towards(motion)
    front = _in_front(motion, drawn, eye)
    smallest = float(motion.radius.min())
    for links in motion.links:
        cracks = [
            crack_lines(places, motion.reference, links.pairs, state, tuple(towards.tolist()))
            for places, state in zip(front, links.state, strict=True)
        ]
        _send_lines(recording, cracks_entity(links), cracks, _CRACK, _CRACK_THICKNESS * smallest, when)
        if len(links.pairs) > MOST_LINES:
            continue
        frame, link = np.nonzero(links.state)
        limit = float(links.state.max(initial=0.0)) or 1.0
        held = front[frame[:, None], links.pairs[link]]
        counts = np.count_nonzero(links.state, axis=1)
        colours = sequential(links.state[frame, link], limit)
        _send_strips(recording, links_entity(links), held, counts, colours, _THICKNESS * smallest, when)


def send_spokes(recording: Any, motion: Motion, drawn: npt.NDArray[Any], eye: FloatArray, when: list[Any]) -> None:
    """Send a line in each particle from its centre outwards, which shows how it is turned; arguments as in `send_links`."""
    if motion.rotation is None or not motion.is_plane:
        return
    front, angle = _in_front(motion, drawn, eye), motion.rotation
    along = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=-1)
    ends = front + _SPOKE_LENGTH * motion.radius[:, None] * along
    spokes = list(np.stack([front, ends], axis=2).astype(np.float32))
    _send_lines(
        recording, entity("scene/spokes_", motion.name), spokes, _SPOKE, _SPOKE_THICKNESS * float(motion.radius.min()), when
    )


def _towards(motion: Motion) -> npt.NDArray[np.float64]:
    """Return the direction of the camera: a plane is seen from above, a row along +y."""
    return np.array([0.0, 0.0, 1.0] if motion.is_plane else [0.0, -1.0, 0.0])


def _in_front(motion: Motion, drawn: npt.NDArray[Any], eye: FloatArray) -> npt.NDArray[np.float32]:
    """Return the places moved towards the eye, until they are in front of the largest particle."""
    ray = eye - drawn
    part = _IN_FRONT * float(motion.radius.max()) / (ray @ _towards(motion))
    return (drawn + part[..., None] * ray).astype(np.float32)


def _send_lines(
    recording: Any, path: str, frames: list[npt.NDArray[Any]], colour: tuple[int, int, int], radius: float, when: list[Any]
) -> None:
    """Send lines of one colour; `frames` has those of each frame, shape (lines, 2, 3) [m]."""
    strips = np.concatenate(frames)
    colours = np.broadcast_to(np.array(colour, np.uint8), (len(strips), 3))
    _send_strips(recording, path, strips, np.array([len(one) for one in frames]), colours, radius, when)


def _send_strips(
    recording: Any,
    path: str,
    strips: npt.NDArray[Any],
    counts: npt.NDArray[np.int64],
    colours: npt.NDArray[np.uint8],
    radius: float,
    when: list[Any],
) -> None:
    rr = import_optional("rerun", "the viewer")
    lines = rr.LineStrips3D.columns(
        strips=strips.astype(np.float32), colors=colours, radii=np.full(len(strips), radius, np.float32)
    )
    recording.send_columns(path, when, lines.partition(counts))
