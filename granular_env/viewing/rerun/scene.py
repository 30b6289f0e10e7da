"""A rerun scene: what is sent, entity by entity. The same functions send a whole log or the one frame of a live component.

scene/particles_...     spheres with their true radii, coloured by a variable, displacements stretched by a stated factor
scene/spokes_...        how they are turned
scene/links_..., scene/cracks_...   links that hold, and those that are broken
scene/cells_..., scene/edges_...    meshes, coloured by a variable
legend                  what the colours mean
profiles/...            fields along a line
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

from granular_env.colours import PALETTE, diverging, rgb
from granular_env.components.contract import Variable
from granular_env.components.support.arrays import FloatArray
from granular_env.optional_packages import import_optional

from ..caption import caption
from ..colour_scales import ColourScale, colour_scales, rescale, scale_of
from ..legend import send_legend
from ..plot_groups import plots
from ..scene_data import MeshFrames, Motion, SceneData
from ..shapes import common_exaggeration
from ..views import Views
from .camera import Camera
from .entities import entity
from .links import send_links, send_spokes
from .meshes import send_mesh, send_triangles
from .profiles import send_profile

APPLICATION = "granular-env"
TIMELINE, TICKS = "time", "tick"
# Scenes that are smaller are magnified [m].
_LEAST_LENGTH = 0.1
REST_COLOUR = (150, 150, 150)


@dataclass(frozen=True)
class Scales:
    """Scales from numbers to lengths and colours in one scene.

    Attributes:
        exaggeration: displacements are drawn this many times larger.
        colours: one for each quantity that colours something, that of the first particles first.
        low, high: corners of the box that holds what is drawn, everything that moves included; x, y, z [m].
        settled: whether factor and limits hold for the whole scene, or may change while a run goes on.
    """

    exaggeration: float
    colours: tuple[ColourScale, ...]
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    settled: bool = True

    @property
    def colour_limit(self) -> float:
        """Magnitude at the ends of the colours of the first particles, in the unit of what colours them."""
        return self.colours[0].limit if self.colours else 1.0

    @property
    def length(self) -> float:
        """Largest extent [m]."""
        return max(high - low for low, high in zip(self.low, self.high, strict=True))

    @property
    def magnification(self) -> float:
        """Factor of the whole scene, a power of 10: rerun draws nothing nearer than 0.1 to a camera, in single precision."""
        return 1.0 if self.length >= _LEAST_LENGTH else 10.0 ** math.ceil(math.log10(_LEAST_LENGTH / self.length))

    @property
    def particles_entity(self) -> str:
        """Path of the first particles; it says the factor, where that is settled."""
        return f"scene/particles_displacement_x{self.exaggeration:g}" if self.settled else "scene/particles"

    @property
    def stretch(self) -> str:
        """The factor in words, for titles."""
        if not self.settled:
            return "larger than they are (how much: see the text)"
        return "true to scale" if self.exaggeration == 1.0 else f"{self.exaggeration:g} x larger"

    def colours_of(self, variable: Variable, values: FloatArray | None, count: int) -> npt.NDArray[np.uint8]:
        """Return the colours of an output's values, or of so many things of which it is not known; shape (..., 3)."""
        scale = scale_of(self.colours, variable.name)
        if values is None or scale is None:
            return np.broadcast_to(np.array(REST_COLOUR, np.uint8), (count, 3)).copy()
        return diverging(values, scale.limit)


def scales_of(scene_data: SceneData, exaggerate: float | None = None) -> Scales | None:
    """Return scales that fit what is drawn, None where nothing is; `exaggerate` overrides the automatic factor."""
    if not scene_data.shapes:
        return None
    factor = exaggerate or common_exaggeration(
        ((one.reference, one.radius, one.displacement) for one in scene_data.motions),
        ((one.nodes, one.displacement) for one in scene_data.meshes),
    )
    corners = []
    for shape in scene_data.shapes:
        rest, radius = (shape.nodes, 0.0) if isinstance(shape, MeshFrames) else (shape.reference, shape.radius[:, None])
        drawn = rest + factor * shape.displacement
        corners += [(drawn - radius).min(axis=(0, 1)), (drawn + radius).max(axis=(0, 1))]
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    colours = colour_scales(scene_data.coloured(), scene_data.is_plane)
    return Scales(factor, colours, tuple(low.tolist()), tuple(high.tolist()))


def enlarge_scales(scales: Scales, scene_data: SceneData, exaggerate: float | None = None) -> Scales:
    """Return the same scene's scales with limits that hold this frame too; unchanged while they hold."""
    now = scales_of(scene_data, exaggerate)
    if now is None:
        return scales
    factor = scales.exaggeration
    if any(np.any(shape.displacement) for shape in scene_data.shapes) and (factor == 1.0 or now.exaggeration < factor):
        factor = now.exaggeration
    values = {variable.name: values for variable, values in scene_data.coloured()}

    def larger(scale: ColourScale) -> ColourScale:
        own = [values[name] for name in scale.names if name in values]
        largest = max((float(np.abs(one).max(initial=0.0)) for one in own), default=0.0)
        has_sign = scale.has_sign or any(bool(np.any(one < 0.0)) for one in own)
        return rescale(scale, roomy_limit(scale.limit, largest), has_sign)

    return dataclasses.replace(scales, exaggeration=factor, colours=tuple(larger(scale) for scale in scales.colours))


def roomy_limit(limit: float, value: float) -> float:
    """Return the limit while it holds the value, else the next 1, 2 or 5 x 10^k: few changes while a wave grows."""
    if value <= limit or not math.isfinite(value):
        return limit
    decade = 10.0 ** math.floor(math.log10(value))
    return next(float(f"{step * decade:.6g}") for step in (1, 2, 5, 10) if step * decade >= value * (1.0 - 1e-12))


def whole_camera(scene_data: SceneData, scales: Scales, views: Views | None) -> Camera:
    """Return the camera that sees everything: a row from the side, a plane from above."""
    low, high = scales.magnification * np.array(scales.low), scales.magnification * np.array(scales.high)
    middle = 0.5 * (low + high)
    if scene_data.is_plane:
        width, height = 1.05 * (high - low)[:2]
        return Camera("cameras/whole", (middle[0], middle[1]), float(width), float(height), is_above=True)
    reach = views.reach(scales) if views is not None else (scales.low[2], scales.high[2])
    bottom, top = (scales.magnification * level for level in reach)
    return Camera("cameras/whole", (middle[0], 0.5 * (top + bottom)), 1.03 * float(high[0] - low[0]), 1.08 * (top - bottom))


def send(recording: Any, scene_data: SceneData, scales: Scales | None, views: Views | None) -> None:
    """Send everything of a log: first what never changes, then every frame, then the plots."""
    send_static(recording, scene_data, scales, views)
    if scales is not None:
        send_frames(recording, scene_data, scales, views)
        if scene_data.motion is not None and views is not None:
            views.send_pictures(recording, scene_data.motion, scales)
    for profile in scene_data.profiles:
        send_profile(recording, profile, time_columns(profile.times, profile.ticks))
    send_curves(recording, scene_data)


def send_static(recording: Any, scene_data: SceneData, scales: Scales | None, views: Views | None) -> None:
    """Send the caption, the legend, what of the shapes does not change, cameras and the names of the curves."""
    rr = import_optional("rerun", "the viewer")
    text = rr.TextDocument(caption(scene_data, scales, views), media_type=rr.MediaType.MARKDOWN)
    recording.log("caption", text, static=True)
    if scales is not None:
        send_legend(recording, scales.colours)
        if scales.magnification != 1.0:
            recording.log("scene", rr.Transform3D(scale=scales.magnification), static=True)
        for motion in scene_data.motions:
            radii = rr.Points3D.from_fields(radii=motion.radius.astype(np.float32))
            recording.log(_particles_entity(scene_data, motion, scales), radii, static=True)
        for mesh in scene_data.meshes:
            send_triangles(recording, mesh)
        whole_camera(scene_data, scales, views).send(recording)
        if scene_data.motion is not None and views is not None:
            views.send_static(recording, scene_data.motion, scales)
    for plot in plots(scene_data):
        for place, (path, curve) in enumerate(zip(plot.paths, plot.curves, strict=True)):
            name, colour = f"{curve.name.replace('_', ' ')} [{curve.unit}]", rgb(PALETTE[place % len(PALETTE)])
            # Rerun's default draws the mean of the points that fall on one pixel: stairs would become ramps of other heights.
            lines = rr.SeriesLines(
                names=name, colors=colour, widths=2.0, aggregation_policy=rr.components.AggregationPolicy.Off
            )
            recording.log(path, lines, static=True)


def _particles_entity(scene_data: SceneData, motion: Motion, scales: Scales) -> str:
    return scales.particles_entity if motion is scene_data.motion else entity("scene/particles_", motion.name)


def send_frames(recording: Any, scene_data: SceneData, scales: Scales, views: Views | None) -> None:
    """Send some frames of everything that moves, each in one message, and what the domain shows of the first particles."""
    for mesh in scene_data.meshes:
        drawn = (mesh.nodes + scales.exaggeration * mesh.displacement).astype(np.float32)
        count = len(mesh.nodes) if mesh.field is None else mesh.field.shape[1]
        colours = scales.colours_of(mesh.field_variable, mesh.field, len(drawn) * count).reshape(len(drawn), count, 3)
        send_mesh(recording, mesh, drawn, colours, time_columns(mesh.times, mesh.ticks))
    for motion in scene_data.motions:
        _send_particles(recording, scene_data, motion, scales, views if motion is scene_data.motion else None)


def _send_particles(recording: Any, scene_data: SceneData, motion: Motion, scales: Scales, views: Views | None) -> None:
    rr = import_optional("rerun", "the viewer")
    frames, count = motion.displacement.shape[:2]
    drawn = (motion.reference + scales.exaggeration * motion.displacement).astype(np.float32)
    when = time_columns(motion.times, motion.ticks)
    colours = scales.colours_of(motion.colour_variable, motion.colour, frames * count).reshape(frames, count, 3)
    particles = rr.Points3D.columns(positions=drawn.reshape(-1, 3), colors=colours.reshape(-1, 3))
    entity = _particles_entity(scene_data, motion, scales)
    recording.send_columns(entity, when, particles.partition(np.full(frames, count)))
    send_links(recording, motion, drawn, when)
    send_spokes(recording, motion, drawn, when)
    if views is not None:
        views.send_frames(recording, motion, scales, drawn, colours, when)


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
