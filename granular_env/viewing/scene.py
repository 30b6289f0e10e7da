"""A rerun scene: what is sent, entity by entity. The same functions send a whole log or the one frame of a live component.

scene/particles_...     spheres with their true radii, coloured by a variable, displacements stretched by a stated factor
scene/links_...         lines between linked particles
scene/..., closeup/...  what the component's domain adds (`views.Views`)
energy, inputs, ...     scalar plots
caption                 what is seen, in words: units, factors, limits
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.colours import PALETTE, diverging, rgb, symmetric_limit
from granular_env.components.support.arrays import FloatArray
from granular_env.recording.displacement_scale import choose_exaggeration

from .camera import Camera
from .caption import caption
from .links import send_links
from .optional_packages import import_optional
from .plot_groups import plots
from .scene_data import Motion, SceneData
from .views import Views

APPLICATION = "granular-env"
TIMELINE, TICKS = "time", "tick"
REST_COLOUR = (150, 150, 150)


@dataclass(frozen=True)
class Scales:
    """Scales from numbers to lengths and colours in one scene.

    Attributes:
        exaggeration: displacements are drawn this many times larger.
        colour_limit: magnitude at the ends of the colour map, in the unit of the colouring variable.
        low, high: corners of the box that holds the particles, everything that moves included; x, y, z [m].
        settled: whether factor and limits hold for the whole scene, or may change while a run goes on.
    """

    exaggeration: float
    colour_limit: float
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    settled: bool = True

    @property
    def length(self) -> float:
        """Largest extent [m]."""
        return max(high - low for low, high in zip(self.low, self.high, strict=True))

    @property
    def particles_entity(self) -> str:
        """Path of the particles; it says the factor, where that is settled."""
        return f"scene/particles_displacement_x{self.exaggeration:g}" if self.settled else "scene/particles"

    @property
    def stretch(self) -> str:
        """The factor in words, for titles."""
        if not self.settled:
            return "larger than they are (how much: see the text)"
        return "true to scale" if self.exaggeration == 1.0 else f"{self.exaggeration:g} x larger"


def scales_of(motion: Motion, exaggerate: float | None = None) -> Scales:
    """Return scales that fit a motion; `exaggerate` overrides the automatic factor."""
    factor = exaggerate or choose_exaggeration(motion.reference, motion.radius, motion.displacement)
    drawn, radius = motion.reference + factor * motion.displacement, motion.radius[:, None]
    low, high = (drawn - radius).min(axis=(0, 1)), (drawn + radius).max(axis=(0, 1))
    colour = np.zeros(1) if motion.colour is None else motion.colour
    return Scales(factor, symmetric_limit(colour), tuple(low.tolist()), tuple(high.tolist()))


def enlarge_scales(scales: Scales, motion: Motion, exaggerate: float | None = None) -> Scales:
    """Return the same scene's scales with limits that hold this frame too; unchanged while they hold."""
    now = scales_of(motion, exaggerate)
    factor = scales.exaggeration
    if bool(np.any(motion.displacement)) and (factor == 1.0 or now.exaggeration < factor):
        factor = now.exaggeration
    colour = motion.colour if motion.colour is not None else np.zeros(1)
    limit = roomy_limit(scales.colour_limit, float(np.abs(colour).max()))
    return dataclasses.replace(scales, exaggeration=factor, colour_limit=limit)


def roomy_limit(limit: float, value: float) -> float:
    """Return the limit while it holds the value, else the next 1, 2 or 5 x 10^k: few changes while a wave grows."""
    if value <= limit or not math.isfinite(value):
        return limit
    decade = 10.0 ** math.floor(math.log10(value))
    return next(float(f"{step * decade:.6g}") for step in (1, 2, 5, 10) if step * decade >= value * (1.0 - 1e-12))


def whole_camera(motion: Motion, scales: Scales, views: Views) -> Camera:
    """Return the camera that sees everything: a row from the side, a plane from above."""
    low, high = np.array(scales.low), np.array(scales.high)
    middle = 0.5 * (low + high)
    if motion.is_plane:
        width, height = 1.05 * (high - low)[:2]
        return Camera("cameras/whole", (middle[0], middle[1]), float(width), float(height), is_above=True)
    bottom, top = views.reach(scales)
    return Camera("cameras/whole", (middle[0], 0.5 * (top + bottom)), 1.03 * float(high[0] - low[0]), 1.08 * (top - bottom))


def send(recording: Any, scene_data: SceneData, scales: Scales | None, views: Views | None) -> None:
    """Send everything of a log: first what never changes, then every frame, then the plots."""
    send_static(recording, scene_data, scales, views)
    if scene_data.motion is not None and scales is not None and views is not None:
        send_motion(recording, scene_data.motion, scales, views)
        views.send_pictures(recording, scene_data.motion, scales)
    send_curves(recording, scene_data)


def send_static(recording: Any, scene_data: SceneData, scales: Scales | None, views: Views | None) -> None:
    """Send the caption, radii, cameras and the names of the curves."""
    rr = import_optional("rerun", "the viewer")
    text = rr.TextDocument(caption(scene_data, scales, views), media_type=rr.MediaType.MARKDOWN)
    recording.log("caption", text, static=True)
    if scene_data.motion is not None and scales is not None and views is not None:
        radii = rr.Points3D.from_fields(radii=scene_data.motion.radius.astype(np.float32))
        recording.log(scales.particles_entity, radii, static=True)
        whole_camera(scene_data.motion, scales, views).send(recording)
        views.send_static(recording, scene_data.motion, scales)
    for plot in plots(scene_data):
        for place, (path, curve) in enumerate(zip(plot.paths, plot.curves, strict=True)):
            name, colour = f"{curve.name.replace('_', ' ')} [{curve.unit}]", rgb(PALETTE[place % len(PALETTE)])
            # Rerun's default draws the mean of the points that fall on one pixel: stairs would become ramps of other heights.
            lines = rr.SeriesLines(
                names=name, colors=colour, widths=2.0, aggregation_policy=rr.components.AggregationPolicy.Off
            )
            recording.log(path, lines, static=True)


def send_motion(recording: Any, motion: Motion, scales: Scales, views: Views) -> None:
    """Send the particles of some frames, in one message, and what the domain shows of them."""
    rr = import_optional("rerun", "the viewer")
    frames, count = motion.displacement.shape[:2]
    drawn = (motion.reference + scales.exaggeration * motion.displacement).astype(np.float32)
    when = time_columns(motion.times, motion.ticks)
    colours = _colours(motion, scales)
    particles = rr.Points3D.columns(positions=drawn.reshape(-1, 3), colors=colours.reshape(-1, 3))
    recording.send_columns(scales.particles_entity, when, particles.partition(np.full(frames, count)))
    send_links(recording, motion, drawn, when)
    views.send_frames(recording, motion, scales, drawn, colours, when)


def _colours(motion: Motion, scales: Scales) -> npt.NDArray[np.uint8]:
    if motion.colour is None:
        return np.broadcast_to(np.array(REST_COLOUR, np.uint8), motion.displacement.shape).copy()
    return diverging(motion.colour, scales.colour_limit)


def send_curves(recording: Any, scene_data: SceneData) -> None:
    """Send the scalar plots."""
    rr = import_optional("rerun", "the viewer")
    for plot in plots(scene_data):
        for path, curve in zip(plot.paths, plot.curves, strict=True):
            # The sides of a jump are put 1 ns and one tick apart: rerun would draw the mean of what falls on one instant.
            before_jump = np.append(np.diff(curve.times) <= 0.0, False).astype(np.int64)
            when = time_columns(curve.times, curve.ticks - before_jump, before_jump)
            recording.send_columns(path, when, rr.Scalars.columns(scalars=curve.values))


def time_columns(times: FloatArray, ticks: npt.NDArray[np.int64], earlier: npt.NDArray[np.int64] | int = 0) -> list[Any]:
    """Return both timelines; times in whole nanoseconds, as rerun keeps them, `earlier` of them earlier."""
    rr = import_optional("rerun", "the viewer")
    nanoseconds = np.rint(times * 1e9).astype(np.int64) - earlier
    return [rr.TimeColumn(TIMELINE, duration=nanoseconds.astype("timedelta64[ns]")), rr.TimeColumn(TICKS, sequence=ticks)]
