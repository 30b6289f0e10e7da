"""Point clouds of the preview: the drawables of a log as coloured dots.

Rows and bodies in a plane lie in x and z, which stock viewers show from the front; bodies in space keep their axes.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ...colours import ColourScale, colour_scales, diverging_colours
from ...components.drawables import OUTPUT_FIELDS, Cells, Curve, Drawable, Links, Points, drawn_outputs, to_three_columns
from ...components.variables import Variable
from .displacement_scale import common_exaggeration
from .visible_drawables import colour_name, is_hidden, is_plane, is_solid, with_recorded_colour

# Largest number of drawn elements of a drawable, and of positions from which the displacement factor follows.
MOST_PLACES, _MOST_POSITIONS = 5_000, 1_000_000
# Drawn height of the largest value above a row or of a curve, and distance of stacked curves, relative to their length; a
# broken link is a dot while the drawn distance of its ends is below the last multiple of their distance at rest.
_HEIGHT, _STACKED, _FARTHEST = 0.22, 0.33, 1.5
# Number of colours on each side of the value 0, which is a grey that is visible on light and dark backgrounds.
_SHADES, _ZERO, _BROKEN = 15, "#bebebe", (190, 0, 255, 255)
_FOLDERS = {Points: "points", Links: "links", Cells: "cells", Curve: "curves"}
COUNTED = {Points: "radius", Links: "pairs", Cells: "nodes", Curve: "coordinate"}

# A picture (drawn frame): its time [ns], and the values of the drawn outputs by name.
Picture = tuple[int, dict[str, np.ndarray]]


class Clouds:
    """The drawables as point clouds, with one factor for displacements and one colour limit per unit for all pictures.

    Attributes:
        sentences: description of factor, colours and dots.
    """

    def __init__(self, drawables: Sequence[Drawable], variables: Mapping[str, Variable], pictures: Sequence[Picture]) -> None:
        self._drawables, self._first = drawables, pictures[0][1]
        self._points = {one.name: one for one in drawables if isinstance(one, Points)}
        self._rest = rest_positions(drawables)
        self._is_flat = not _has_solid(drawables)
        self._factor, self._limits = _displacement_factor(drawables, pictures), {"": 1.0}
        larger = f"{self._factor:g} times larger" if self._factor != 1.0 else "true to scale"
        moves = any(getattr(one, "displacement", "") for one in drawables)
        self.sentences = [f"Displacements are {larger}."] if moves else []
        coloured = dict.fromkeys(filter(None, map(_coloured_by, drawables)))
        values = [(variables[name], np.stack([drawn[name] for _, drawn in pictures])) for name in coloured]
        bodies = [one for one in drawables if isinstance(one, Points | Cells)]
        for scale in colour_scales(values, any(is_plane(_nodes(one), variables.get(one.displacement)) for one in bodies)):
            self._limits |= dict.fromkeys(scale.names, scale.limit)
            self.sentences.append(_scale_sentence(scale, drawables))
        curves = [one.name for one in drawables if isinstance(one, Curve)]
        self.sentences += [f"Curves from the top: {', '.join(curves)}."] if len(curves) > 1 else []
        self.sentences += ["Violet dots: broken links."] if any(isinstance(one, Links) for one in drawables) else []

    def messages(self, picture: Mapping[str, np.ndarray]) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
        """Yield the topic, the positions (n, 3) [m] and the colours (n, 4) of each drawable in a picture."""
        for one in self._drawables:
            places, colours = self._broken_dots(one, picture) if isinstance(one, Links) else self._dots(one, picture)
            some = slice(None, None, -(-len(places) // MOST_PLACES) or 1)  # evenly spaced if there are too many
            yield cloud_topic(one), places[some], colours[some]

    def _dots(self, drawable: Points | Cells | Curve, picture: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Return the positions and colours of points, nodes, cells or places of a curve."""
        name, places = _coloured_by(drawable), self._positions(drawable, picture)
        values = picture[name] if name else np.zeros(len(places), np.float32)
        if isinstance(drawable, Cells):
            corners = drawable.connectivity
            whole = picture[drawable.state] != 0.0 if drawable.state else np.ones(len(corners), np.bool_)
            if len(values) == len(places):
                shown = np.unique(corners[whole])
                places, values = places[shown], values[shown]
            else:
                places, values = places[corners[whole]].mean(axis=1), values[whole]
        places[:, 2] += _value_height(drawable) * values / self._limits[name]
        return places, value_colours(values, self._limits[name])

    def _broken_dots(self, links: Links, picture: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Return a dot in front of the middle of each link that has broken since the first picture."""
        points = self._points[links.points]
        broken = (self._first[links.state] != 0.0) & (picture[links.state] == 0.0)
        pairs = links.pairs[broken & points.is_unwrapped(links.pairs)]
        ends, rest = self._positions(points, picture)[pairs], self._rest[cloud_topic(points)][pairs]
        near = np.linalg.norm(np.diff(ends, axis=1), axis=2) < _FARTHEST * np.linalg.norm(np.diff(rest, axis=1), axis=2)
        dots = ends[near[:, 0]].mean(axis=1)
        dots[:, 1] -= float(points.radius.max()) if self._is_flat else 0.0
        return dots, np.broadcast_to(np.array(_BROKEN, np.uint8), (len(dots), 4))

    def _positions(self, drawable: Points | Cells | Curve, picture: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the drawn positions, shape (n, 3): at rest if no displacement was recorded."""
        rest, moved = self._rest[cloud_topic(drawable)], picture.get(getattr(drawable, "displacement", ""))
        return rest.copy() if moved is None else rest + self._factor * _stand_up(moved.astype(np.float64), self._is_flat)


def shown_drawables(drawables: Sequence[Drawable], variables: Mapping[str, Variable]) -> tuple[Drawable, ...]:
    """Return the drawables that viewers show, without the names of unrecorded outputs.

    As in all views, hidden drawables are omitted, and another recorded output replaces a colour that was not recorded. Points
    and cells without a recorded displacement are shown at rest; links only if their state and points are recorded.
    """
    found: list[Drawable] = []
    for one in drawables:
        if is_hidden(one, drawables):
            continue
        one = with_recorded_colour(one, variables)
        roles = [role for role in OUTPUT_FIELDS if hasattr(one, role)]
        omitted = [role for role in roles if role == "rotation" or getattr(one, role) not in variables]
        one = dataclasses.replace(one, **dict.fromkeys(omitted, ""))
        if drawn_outputs([one]) and (not isinstance(one, Links) or one.points in [points.name for points in found]):
            found.append(one)
    return tuple(found)


def cloud_topic(drawable: Drawable) -> str:
    """Return the topic of a drawable's point clouds."""
    return f"/{_FOLDERS[type(drawable)]}/{drawable.name.replace(' ', '_')}"


def rest_positions(drawables: Sequence[Drawable]) -> dict[str, np.ndarray]:
    """Return topic -> drawn positions at rest, shape (n, 3) [m], of all drawables except links; curves are stacked."""
    flat, found, base = not _has_solid(drawables), dict[str, np.ndarray](), 0.0
    for one in drawables:
        if isinstance(one, Curve):
            found[cloud_topic(one)] = to_three_columns(one.coordinate) + np.array([0.0, 0.0, base])
            base -= _STACKED * float(np.ptp(one.coordinate))
        elif not isinstance(one, Links):
            found[cloud_topic(one)] = _stand_up(_nodes(one), flat)
    return found


def bounding_box(drawables: Sequence[Drawable]) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and highest corner of all drawables in the initial state, shape (3,) each [m]."""
    rest, corners = rest_positions(drawables), []
    for one in drawables:
        if not isinstance(one, Links):
            places, margin = rest[cloud_topic(one)], one.radius[:, None] if isinstance(one, Points) else 0.0
            corners += [places - margin, places + margin + np.array([0.0, 0.0, _value_height(one)])]
    return np.min(np.vstack(corners), axis=0), np.max(np.vstack(corners), axis=0)


def value_colours(values: np.ndarray, limit: float) -> np.ndarray:
    """Return the colours of values: blue below 0, grey at 0 and for NaN, red above 0, full at `limit`; shape (n, 4) uint8."""
    shades = np.rint(np.clip(np.nan_to_num(values / limit), -1.0, 1.0) * _SHADES) / _SHADES  # few colours, which compress well
    return np.pad(diverging_colours(shades, 1.0, _ZERO), ((0, 0), (0, 1)), constant_values=255)


def _coloured_by(drawable: Drawable) -> str:
    return drawable.field if isinstance(drawable, Curve) else colour_name(drawable)


def _nodes(drawable: Points | Cells) -> np.ndarray:
    return drawable.reference if isinstance(drawable, Points) else drawable.nodes


def _has_solid(drawables: Sequence[Drawable]) -> bool:
    return any(is_solid(_nodes(one)) for one in drawables if isinstance(one, Points | Cells))


def _stand_up(vectors: np.ndarray, is_flat: bool) -> np.ndarray:
    """Return vectors, shape (n, d), with three columns; those of flat bodies in the plane of x and z."""
    return to_three_columns(vectors)[:, [0, 2, 1]] if is_flat else to_three_columns(vectors)


def _value_height(drawable: Drawable) -> float:
    """Return the drawn height of the limit of the colours above points in a row along x, or of a curve [m]; 0 for others."""
    if isinstance(drawable, Points) and drawable.colour and not np.ptp(drawable.reference[:, 1:], axis=0).any():
        return _HEIGHT * float(np.ptp(drawable.reference[:, 0]))
    return _HEIGHT * float(np.ptp(drawable.coordinate)) if isinstance(drawable, Curve) else 0.0


def _scale_sentence(scale: ColourScale, drawables: Sequence[Drawable]) -> str:
    full = f"{scale.limit:g} {scale.unit if scale.unit != '1' else ''}".strip()
    low = f"-{full} (blue) over 0" if scale.has_sign else "0"
    is_height = any(_value_height(one) for one in drawables if _coloured_by(one) in scale.names)
    return f"{'Colour and height' if is_height else 'Colour'}: {', '.join(scale.names)} from {low} (grey) to {full} (red)."


def _displacement_factor(drawables: Sequence[Drawable], pictures: Sequence[Picture]) -> float:
    """Return the factor of drawn displacements by the rule of all viewers, from as many pictures as memory allows."""
    points, cells = [], []
    for one in drawables:
        if isinstance(one, Points | Cells) and one.displacement:
            every = math.ceil(len(pictures) * len(_nodes(one)) / _MOST_POSITIONS)
            moved = np.stack([drawn[one.displacement] for _, drawn in pictures[::-every]])
            moved = np.nan_to_num(moved, posinf=0.0, neginf=0.0)
            if isinstance(one, Points):
                rows = to_three_columns(moved[..., None] if moved.ndim == 2 else moved)
                points.append((to_three_columns(one.reference), one.radius, rows))
            else:
                cells.append((one.nodes, moved))
    return common_exaggeration(points, cells)
