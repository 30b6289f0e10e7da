"""A rerun scene and its entities. The same functions send a whole log or the single frame of a live component.

scene/particles_...     spheres with true radii, coloured by a variable, displacements stretched by a stated factor
scene/spokes_...        rotation of the particles
scene/links_..., scene/cracks_...   intact and broken links
scene/cells_..., scene/edges_..., scene/broken_...   meshes, coloured by a variable, and pieces of broken cells
legend                  colour bars
profiles/...            fields along a line
scene/..., closeup/...  additions of the component's domain (`domain_views.Views`)
energy, inputs, ...     scalar plots
caption                 description: units, factors, limits
"""

from __future__ import annotations

from typing import Any

import matplotlib
import numpy as np
import numpy.typing as npt
import rerun as rr

from granular_env.colours import PALETTE, parse_rgb
from granular_env.components.support.float_arrays import FloatArray

from ..domain_views import Views
from ..figures.colour_bar import draw_colour_bars
from ..figures.drawing import DARK, render_canvas
from ..plot_groups import Plot, make_plots
from ..scene_data import Motion, SceneData, drawn_positions
from ..scene_scales import Scales
from .camera import Camera
from .caption import make_caption
from .profiles import send_profile
from .shapes import entity_path, send_links, send_mesh, send_spokes, send_triangles

APPLICATION = "granular-env"
LEGEND = "legend"
TIMELINE, TICKS = "time", "tick"
# Size of a labelled colour bar [inch], and its resolution.
_BAR_WIDTH, _BAR_HEIGHT = 5.0, 0.8
_DOTS_PER_INCH = 150


def whole_camera(scene_data: SceneData, scales: Scales, views: Views | None) -> Camera:
    """Return the camera of the whole scene: a row from the side, a plane from above."""
    low, high = scales.magnification * np.array(scales.low), scales.magnification * np.array(scales.high)
    middle = 0.5 * (low + high)
    if scene_data.is_plane:
        width, height = 1.05 * (high - low)[:2]
        return Camera("cameras/whole", (middle[0], middle[1]), float(width), float(height), is_above=True)
    reach = views.vertical_extent(scales) if views is not None else (scales.low[2], scales.high[2])
    bottom, top = (scales.magnification * level for level in reach)
    return Camera("cameras/whole", (middle[0], 0.5 * (top + bottom)), 1.03 * float(high[0] - low[0]), 1.08 * (top - bottom))


def send_scene(recording: Any, scene_data: SceneData, scales: Scales | None, views: Views | None) -> None:
    """Send a whole log: first the static parts, then the frames, then the plots."""
    send_static(recording, scene_data, scales, views)
    if scales is not None:
        send_frames(recording, scene_data, scales, views)
        if scene_data.motion is not None and views is not None:
            views.send_pictures(recording, scene_data.motion, scales)
    for profile in scene_data.profiles:
        send_profile(recording, profile, time_columns(profile.times, profile.ticks))
    send_curves(recording, scene_data)


def send_static(recording: Any, scene_data: SceneData, scales: Scales | None, views: Views | None) -> None:
    """Send the static parts: caption, legend, connectivity of the shapes, cameras and names of the curves."""
    text = rr.TextDocument(make_caption(scene_data, scales, views), media_type=rr.MediaType.MARKDOWN)
    recording.log("caption", text, static=True)
    if scales is not None:
        if scales.colours:
            with matplotlib.rc_context(DARK):
                pixels = render_canvas(draw_colour_bars(scales.colours, _BAR_WIDTH, _BAR_HEIGHT), _DOTS_PER_INCH).buffer_rgba()
            recording.log(LEGEND, rr.Image(np.asarray(pixels)[..., :3]), static=True)
        if scales.magnification != 1.0:
            recording.log("scene", rr.Transform3D(scale=scales.magnification), static=True)
        for motion in scene_data.motions:
            radii = rr.Points3D.from_fields(radii=motion.radius.astype(np.float32))
            recording.log(particles_path(motion), radii, static=True)
        for mesh in scene_data.meshes:
            send_triangles(recording, mesh)
        whole_camera(scene_data, scales, views).send(recording)
        if scene_data.motion is not None and views is not None:
            views.send_static(recording, scene_data.motion, scales)
    for plot in make_plots(scene_data):
        for place, (path, curve) in enumerate(zip(plot_paths(plot), plot.curves, strict=True)):
            name, colour = curve.name.replace("_", " "), parse_rgb(PALETTE[place % len(PALETTE)])
            # Switch off rerun's averaging of samples on one pixel, which would turn stairs into ramps of other heights.
            off = rr.components.AggregationPolicy.Off
            lines = rr.SeriesLines(names=name, colors=colour, widths=2.0, aggregation_policy=off)
            recording.log(path, lines, static=True)


def send_frames(recording: Any, scene_data: SceneData, scales: Scales, views: Views | None) -> None:
    """Send frames of all moving parts, each part in one message, and the domain's views of the first particles."""
    for mesh in scene_data.meshes:
        drawn = drawn_positions(mesh, scales.exaggeration).astype(np.float32)
        count = len(mesh.nodes) if mesh.field is None else mesh.field.shape[1]
        colours = scales.value_colours(mesh.field_variable, mesh.field, len(drawn) * count).reshape(len(drawn), count, 3)
        send_mesh(recording, mesh, drawn, colours, time_columns(mesh.times, mesh.ticks))
    eye = np.array(whole_camera(scene_data, scales, views).position) / scales.magnification
    for motion in scene_data.motions:
        _send_particles(recording, motion, scales, views if motion is scene_data.motion else None, eye)


def _send_particles(recording: Any, motion: Motion, scales: Scales, views: Views | None, eye: FloatArray) -> None:
    frames, count = motion.displacement.shape[:2]
    drawn = drawn_positions(motion, scales.exaggeration).astype(np.float32)
    when = time_columns(motion.times, motion.ticks)
    colours = scales.value_colours(motion.colour_variable, motion.colour, frames * count).reshape(frames, count, 3)
    particles = rr.Points3D.columns(positions=drawn.reshape(-1, 3), colors=colours.reshape(-1, 3))
    recording.send_columns(particles_path(motion), when, particles.partition(np.full(frames, count)))
    send_links(recording, motion, drawn, eye, when)
    send_spokes(recording, motion, drawn, eye, when)
    if views is not None:
        views.send_frames(recording, motion, scales, drawn, colours, when)


def particles_path(motion: Motion) -> str:
    """Return rerun's entity path of these particles."""
    return entity_path("scene/particles_", motion.name)


def plot_paths(plot: Plot) -> list[str]:
    """Return rerun's entity path of each curve of a plot."""
    return [entity_path(f"{plot.group}/", curve.name) for curve in plot.curves]


def send_curves(recording: Any, scene_data: SceneData) -> None:
    """Send the values of all scalar curves."""
    for plot in make_plots(scene_data):
        for path, curve in zip(plot_paths(plot), plot.curves, strict=True):
            # Separate the two sides of a jump by 1 ns and one tick, because rerun would draw the mean of simultaneous values.
            before_jump = np.append(np.diff(curve.times) <= 0.0, False).astype(np.int64)
            when = time_columns(curve.times, curve.ticks - before_jump, before_jump)
            recording.send_columns(path, when, rr.Scalars.columns(scalars=curve.values))


def time_columns(times: FloatArray, ticks: npt.NDArray[np.int64], earlier: npt.NDArray[np.int64] | int = 0) -> list[Any]:
    """Return rerun's columns for both timelines (time, tick); times are whole nanoseconds, reduced by `earlier` nanoseconds."""
    nanoseconds = np.rint(times * 1e9).astype(np.int64) - earlier
    return [rr.TimeColumn(TIMELINE, duration=nanoseconds.astype("timedelta64[ns]")), rr.TimeColumn(TICKS, sequence=ticks)]
