"""A rerun scene: what is sent, entity by entity. The same functions send a whole log or the one frame of a live component.

scene/grains_...        spheres with their true radii, coloured by velocity, displacements stretched by a stated factor
scene/profile           the colouring quantity drawn as a curve over the grains
scene/contacts          contact forces (or overlaps) as bars under the contacts
closeup/...             the grains around the fastest one, large
space_time/...          the x-t diagram and the present instant on it
energy, inputs, ...     scalar plots
caption                 what is seen, in words: units, factors, limits
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from granular_env.colours import PALETTE, diverging, rgb, sequential, symmetric_limit
from granular_env.recording.exaggeration import chosen_exaggeration

from .caption import caption
from .closeup import closeup_eye, has_closeup, send_closeup
from .extras import needed
from .eye import Eye
from .footage import Footage, Motion
from .plots import plots

if TYPE_CHECKING:
    from .space_time import Picture

FloatArray = npt.NDArray[np.float64]

APPLICATION = "granular-env"
TIMELINE, TICKS = "time", "tick"
_REST_COLOUR = (150, 150, 150)
# Where the words of a zero line stand, in lengths of the longest bar.
_WORDS = 1.25
# The longest bar, in lengths of the scene.
BAR_LENGTH = 0.05


@dataclass(frozen=True)
class Scales:
    """How numbers become lengths and colours in one scene.

    Attributes:
        exaggeration: displacements are drawn this many times larger.
        colour_limit: magnitude at the ends of the colour map, in the unit of the colouring variable.
        contact_limit: contact force or overlap whose bar is `height` long.
        low, high: ends of the chain, everything that moves included, along x [m].
        height: length of the longest bar and of half the profile's span [m].
        profile_level: height of the profile's zero line [m].
        contact_level: height from which the contacts' bars hang down [m].
        settled: whether factor and limits hold for the whole scene, or may change while a run goes on.
    """

    exaggeration: float
    colour_limit: float
    contact_limit: float
    low: float
    high: float
    height: float
    profile_level: float
    contact_level: float
    settled: bool = True

    @property
    def length(self) -> float:
        """Extent along x [m]."""
        return self.high - self.low

    @property
    def grains_entity(self) -> str:
        """Path of the particles; it says the factor, where that is settled."""
        return f"scene/grains_displacement_x{self.exaggeration:g}" if self.settled else "scene/grains"

    @property
    def stretch(self) -> str:
        """The factor in words, for titles."""
        return f"{self.exaggeration:g} x larger" if self.settled else "larger than they are (how much: see the text)"


def scales_of(motion: Motion, exaggerate: float | None = None) -> Scales:
    """Scales that fit a motion; `exaggerate` overrides the automatic factor."""
    factor = exaggerate or chosen_exaggeration(motion.reference, motion.radius, motion.displacement)
    drawn = motion.reference[:, 0] + factor * motion.displacement[:, :, 0]
    low, high = float((drawn - motion.radius).min()), float((drawn + motion.radius).max())
    colour = np.zeros(1) if motion.colour is None else motion.colour
    colour_limit = symmetric_limit(colour)
    height, margin = BAR_LENGTH * (high - low), 0.015 * (high - low) + float(motion.radius.max())
    # Room under the profile's zero line for as much as goes below it.
    below = height * max(0.0, -float(colour.min())) / colour_limit
    return Scales(
        factor,
        colour_limit,
        symmetric_limit([0.0] if motion.contact is None else motion.contact),
        low, high, height,
        profile_level=float(motion.reference[:, 2].max()) + margin + below,
        contact_level=float(motion.reference[:, 2].min()) - margin,
    )  # fmt: skip


def whole_eye(scales: Scales) -> Eye:
    """The eye that sees the whole chain, the profile above and the bars below."""
    reach = (_WORDS + 0.18) * scales.height
    top, bottom = scales.profile_level + reach, scales.contact_level - reach
    return Eye(
        "eyes/whole", (0.5 * (scales.low + scales.high), 0.5 * (top + bottom)), 1.03 * scales.length, 1.08 * (top - bottom)
    )


def send(recording: Any, footage: Footage, scales: Scales | None) -> None:
    """Everything of a log: first what never changes, then every frame, then the plots."""
    send_static(recording, footage, scales)
    if footage.motion is not None and scales is not None:
        send_motion(recording, footage.motion, scales)
        _send_space_time(recording, footage.motion, scales)
    send_curves(recording, footage)


def send_static(recording: Any, footage: Footage, scales: Scales | None) -> None:
    """The caption, radii, zero lines and the names of the curves."""
    rr = needed("rerun", "the viewer")
    recording.log("caption", rr.TextDocument(caption(footage, scales), media_type=rr.MediaType.MARKDOWN), static=True)
    if footage.motion is not None and scales is not None:
        recording.log(
            scales.grains_entity, rr.Points3D.from_fields(radii=footage.motion.radius.astype(np.float32)), static=True
        )
        whole_eye(scales).send(recording)
        if has_closeup(footage.motion):
            closeup_eye(footage.motion).send(recording)
        _send_guides(recording, footage.motion, scales)
    for plot in plots(footage):
        for place, (path, curve) in enumerate(zip(plot.paths, plot.curves, strict=True)):
            name, colour = f"{curve.name.replace('_', ' ')} [{curve.unit}]", rgb(PALETTE[place % len(PALETTE)])
            # Rerun's default draws the mean of the points that fall on one pixel: stairs would become ramps of other heights.
            lines = rr.SeriesLines(
                names=name, colors=colour, widths=2.0, aggregation_policy=rr.components.AggregationPolicy.Off
            )
            recording.log(path, lines, static=True)


def _send_guides(recording: Any, motion: Motion, scales: Scales) -> None:
    """Zero lines with a label each."""
    rr = needed("rerun", "the viewer")
    variable = motion.colour_variable
    guides = []
    if motion.colour is not None:
        guides.append(
            (scales.profile_level, 1.0, f"{variable.name} of each grain; full height {scales.colour_limit:g} {variable.unit}")
        )
    if motion.contact is not None:
        guides.append(
            (
                scales.contact_level,
                -1.0,
                f"{motion.contact_name} of each contact; full length {scales.contact_limit:g} {motion.contact_unit}",
            )
        )
    for index, (level, direction, text) in enumerate(guides):
        ends = [[scales.low, 0.0, level], [scales.high, 0.0, level]]
        line = rr.LineStrips3D([ends], colors=[_REST_COLOUR], radii=rr.Radius.ui_points(0.7))
        recording.log(f"scene/zero_lines/{index}", line, static=True)
        # The words stand at the right end, beyond what the longest bar and the highest point of the curve reach.
        place = [scales.high - 0.12 * scales.length, 0.0, level + direction * _WORDS * scales.height]
        words = rr.Points3D([place], labels=[text], show_labels=True, radii=0.0, colors=[_REST_COLOUR])
        recording.log(f"scene/words/{index}", words, static=True)


def send_motion(recording: Any, motion: Motion, scales: Scales) -> None:
    """Grains, profile and force bars of some frames, in one message each."""
    rr = needed("rerun", "the viewer")
    frames, count = motion.displacement.shape[:2]
    drawn = (motion.reference + scales.exaggeration * motion.displacement).astype(np.float32)
    when = _indexes(rr, motion.times, motion.ticks)
    colours = _colours(motion, scales)
    grains = rr.Points3D.columns(positions=drawn.reshape(-1, 3), colors=colours.reshape(-1, 3))
    recording.send_columns(scales.grains_entity, when, grains.partition(np.full(frames, count)))
    if motion.colour is not None and count > 1:
        curve = drawn.copy()
        curve[..., 2] = scales.profile_level + scales.height * motion.colour / scales.colour_limit
        _send_strips(recording, "scene/profile", when, curve, 1, np.full((frames, 3), 235, np.uint8), rr.Radius.ui_points(1.5))
    if motion.contact is not None:
        _send_contacts(recording, motion, scales, drawn, when)
    if has_closeup(motion):
        send_closeup(recording, motion, scales, colours, when)


def _send_contacts(recording: Any, motion: Motion, scales: Scales, drawn: npt.NDArray[np.float32], when: list[Any]) -> None:
    assert motion.contact is not None
    rr = needed("rerun", "the viewer")
    frames, contacts = motion.contact.shape
    top = 0.5 * (drawn[:, 1:] + drawn[:, :-1])
    top[..., 2] = scales.contact_level
    bottom = top.copy()
    bottom[..., 2] -= scales.height * motion.contact / scales.contact_limit
    bars = np.stack([top, bottom], axis=2).reshape(frames * contacts, 2, 3)
    colours = sequential(motion.contact, scales.contact_limit).reshape(-1, 3)
    # Bars as wide as half a grain, while that can be seen.
    thin = motion.radius.min() < 1e-3 * scales.length
    _send_strips(
        recording,
        "scene/contacts",
        when,
        bars,
        contacts,
        colours,
        rr.Radius.ui_points(1.0) if thin else 0.25 * motion.radius.min(),
    )


def _send_strips(
    recording: Any,
    path: str,
    when: list[Any],
    strips: npt.NDArray[np.float32],
    per_frame: int,
    colours: npt.NDArray[np.uint8],
    radius: float,
) -> None:
    rr = needed("rerun", "the viewer")
    frames = len(strips) // per_frame
    lines = rr.LineStrips3D.columns(strips=strips, colors=colours, radii=np.full(len(strips), radius, np.float32))
    recording.send_columns(path, when, lines.partition(np.full(frames, per_frame)))


def _colours(motion: Motion, scales: Scales) -> npt.NDArray[np.uint8]:
    if motion.colour is None:
        return np.broadcast_to(np.array(_REST_COLOUR, np.uint8), motion.displacement.shape).copy()
    return diverging(motion.colour, scales.colour_limit)


def send_picture(recording: Any, picture: Picture) -> None:
    """Send the x-t diagram, in the place of one that was sent before."""
    recording.log("space_time/picture", needed("rerun", "the viewer").Image(picture.pixels), static=True)


def _send_space_time(recording: Any, motion: Motion, scales: Scales) -> None:
    """The x-t diagram, and a line across it at the present instant."""
    if motion.colour is None or len(motion.times) < 2:
        return
    from .space_time import space_time_picture

    rr = needed("rerun", "the viewer")
    picture = space_time_picture(motion, scales.colour_limit)
    send_picture(recording, picture)
    rows = picture.rows(motion.times)
    lines = np.empty((len(rows), 2, 2), np.float32)
    lines[:, 0, 0], lines[:, 1, 0] = picture.left, picture.right
    lines[:, :, 1] = rows[:, None]
    now = rr.LineStrips2D.columns(strips=lines, colors=np.full((len(rows), 3), rgb("#e69f00"), np.uint8))
    recording.send_columns("space_time/now", _indexes(rr, motion.times, motion.ticks), now.partition(np.ones(len(rows), int)))


def send_curves(recording: Any, footage: Footage) -> None:
    """The scalar plots."""
    rr = needed("rerun", "the viewer")
    for plot in plots(footage):
        for path, curve in zip(plot.paths, plot.curves, strict=True):
            # The sides of a jump are put 1 ns and one tick apart: rerun would draw the mean of what falls on one instant.
            before_jump = np.append(np.diff(curve.times) <= 0.0, False).astype(np.int64)
            when = _indexes(rr, curve.times, curve.ticks - before_jump, before_jump)
            recording.send_columns(path, when, rr.Scalars.columns(scalars=curve.values))


def _indexes(rr: Any, times: FloatArray, ticks: npt.NDArray[np.int64], earlier: npt.NDArray[np.int64] | int = 0) -> list[Any]:
    """Both timelines; times in whole nanoseconds, as rerun keeps them, `earlier` of them earlier."""
    nanoseconds = np.rint(times * 1e9).astype(np.int64) - earlier
    return [rr.TimeColumn(TIMELINE, duration=nanoseconds.astype("timedelta64[ns]")), rr.TimeColumn(TICKS, sequence=ticks)]
