"""The words beside a scene: what is seen, in which units, stretched and coloured how."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .scene_data import Motion, SceneData

if TYPE_CHECKING:
    from .scene import Scales
    from .views import Views

_MARKUP = str.maketrans({character: f"\\{character}" for character in "\\`*_{}[]<>#|!~"})


def plain(text: str) -> str:
    """Text from a log with nothing that markdown would act on."""
    return " ".join(str(text).split()).translate(_MARKUP)


def caption(scene_data: SceneData, scales: Scales | None, views: Views | None) -> str:
    """Return a markdown text that lets a stranger read the scene."""
    lines = [f"# {plain(scene_data.title)}", ""]
    motion = scene_data.motion
    if motion is not None and scales is not None:
        lines += _motion_lines(motion, scales)
        for words in [] if views is None else views.words(motion, scales):
            lines += [words, ""]
        lines += _frame_lines(motion)
    elif not scene_data.notes:
        lines += ["This component has no particles; its outputs and its balances are plotted.", ""]
    if any(scene_data.group(balance.entries) for balance in scene_data.balances):
        words = "Balances since the reset. A residual is what a balance cannot account for: the error of the numerics."
        lines += [f"**Plots.** {words}", ""]
    if scene_data.inputs and not any(curve.values.any() for curve in scene_data.inputs.values()):
        lines += ["No input acts in this run.", ""] if scales is None or scales.settled else []
    lines += [f"- {plain(note)}" for note in scene_data.notes]
    lines += ["", "Time is simulated time; drag the cursor below, or press space to play."]
    return "\n".join(lines)


def _motion_lines(motion: Motion, scales: Scales) -> list[str]:
    name, unit = plain(motion.colour_variable.name), plain(motion.colour_variable.unit)
    radii = f"{motion.radius.min() * 1e3:.4g}"
    if motion.radius.max() > motion.radius.min():
        radii += f" to {motion.radius.max() * 1e3:.4g}"
    lines = [f"**{motion.total} particles**, radius {radii} mm (true to scale).", ""]
    if motion.located and scales.settled and scales.exaggeration == 1.0:
        lines += ["**Displacements are true to scale** as well.", ""]
    elif motion.located:
        lines += [
            f"**Displacements are drawn {scales.exaggeration:g} x larger than they are.** The overlaps you see are stretched "
            "by the same factor." + ("" if scales.settled else " Factor and limits are adjusted while the run goes on."),
            "",
        ]
    if motion.colour is not None:
        has_sign = not scales.settled or bool(np.nanmin(motion.colour, initial=0.0) < 0.0)
        below = f"-{scales.colour_limit:g} {unit} (blue) through " if has_sign else ""
        lines += [f"**Colour: {name}**, from {below}0 (white) to +{scales.colour_limit:g} {unit} (red).", ""]
    for links in motion.links:
        words = f"a broken one, whose {plain(links.state_name)} is 0, has no line"
        lines += [f"**Lines: {len(links.pairs)} {plain(links.name)}**; {words}.", ""]
    return lines


def _frame_lines(motion: Motion) -> list[str]:
    if len(motion.times) < 2:
        return []
    first, last = motion.times[0] * 1e6, motion.times[-1] * 1e6
    return [f"{len(motion.times)} frames from {first:.6g} to {last:.6g} \u00b5s.", ""]
