"""A close-up of the grains around the fastest grain, which makes overlaps visible on a chain of any length."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from granular_env.optional_packages import import_optional
from granular_env.viewing.rerun.camera import Camera
from granular_env.viewing.scene_data import Motion

if TYPE_CHECKING:
    from granular_env.viewing.scene_scales import Scales

WINDOW = 24


def has_closeup(motion: Motion) -> bool:
    """Return whether the chain is so long that a close-up shows more detail than the view of the whole chain."""
    return motion.colour is not None and motion.every == 1 and len(motion.radius) > 2 * WINDOW


def closeup_camera(motion: Motion) -> Camera:
    """Return the camera of the close-up, whose picture contains one window of grains and the grain numbers below it."""
    largest = float(motion.radius.max())
    return Camera("cameras/closeup", (0.0, -0.6 * largest), 2.0 * largest * (WINDOW + 1), 4.0 * largest)


def closeup_windows(motion: Motion) -> npt.NDArray[np.int64]:
    """Return the first grain of each frame's window, around the grain of largest |colour value|, shape (frames,)."""
    assert motion.colour is not None
    fastest = np.abs(motion.colour).argmax(axis=1)
    return np.clip(fastest - WINDOW // 2, 0, len(motion.radius) - WINDOW)


def send_closeup(recording: Any, motion: Motion, scales: Scales, colours: npt.NDArray[np.uint8], when: list[Any]) -> None:
    """Send the windows of all frames, each centred at x = 0; every fifth grain is labelled with its number."""
    rr = import_optional("rerun", "the viewer")
    frames = len(motion.times)
    members = closeup_windows(motion)[:, None] + np.arange(WINDOW)
    rows = np.arange(frames)[:, None]
    drawn = motion.reference[members] + scales.exaggeration * motion.displacement[rows, members]
    drawn[..., 0] -= 0.5 * (drawn[:, :1, 0] + drawn[:, -1:, 0])
    grains = rr.Points3D.columns(
        positions=drawn.reshape(-1, 3).astype(np.float32),
        colors=colours[rows, members].reshape(-1, 3),
        radii=motion.radius[members].reshape(-1).astype(np.float32),
    )
    recording.send_columns("closeup/grains", when, grains.partition(np.full(frames, WINDOW)))
    marked = [(frame, place) for frame in range(frames) for place in range(WINDOW) if members[frame, place] % 5 == 0]
    places = np.array([drawn[mark] for mark in marked], dtype=np.float32)
    places[:, 2] -= 1.1 * motion.radius.max()
    numbers = [str(members[mark]) for mark in marked]
    labels = rr.Points3D.columns(positions=places, labels=numbers, radii=np.zeros(len(marked), np.float32))
    counts = np.bincount([frame for frame, _ in marked], minlength=frames)
    recording.send_columns("closeup/grain_numbers", when, labels.partition(counts))
