"""The caption of a scene: text that explains its shapes, units, display factors and colours, and lists notes on the run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from granular_env.colours import ColourScale

from ..picture_sentences import picture_sentences
from ..scene_data import MeshFrames, Motion, SceneData

if TYPE_CHECKING:
    from ..domain_views import Views
    from ..scene_scales import Scales

_MARKUP = str.maketrans({character: f"\\{character}" for character in "\\`*_{}[]<>#|!~"})


def escape_markdown(text: str) -> str:
    """Return text from a log with escaped markdown syntax."""
    return " ".join(str(text).split()).translate(_MARKUP)


def make_caption(scene_data: SceneData, scales: Scales | None, views: Views | None) -> str:
    """Return a markdown text that explains the scene to a new reader."""
    words = [f"# {escape_markdown(scene_data.title)}"]
    if scene_data.conclusions:
        words += ["**At the end of the run**", _bullets(scene_data.conclusions)]
    if scales is not None:
        words += _scene_sentences(scene_data, scales)
        if scene_data.motion is not None and views is not None:
            words += views.caption_paragraphs(scene_data.motion, scales)
    elif not scene_data.notes and not scene_data.profiles:
        words.append("This component has no particles; its outputs and its balances are plotted.")
    if scene_data.profiles:
        names = ", ".join(escape_markdown(one.variable.name.replace("_", " ")) for one in scene_data.profiles)
        words.append(f"**Curves along x:** {names}, at the instant of the cursor; a line marks 0.")
    if any(scene_data.named_curves(balance.entries) for balance in scene_data.balances):
        words.append("**Plots.** Balances since the reset. Their residuals are numerical errors.")
    # A single sample (at the start of a live run) does not show whether an input is always 0.
    inputs = scene_data.inputs.values()
    if inputs and not any(curve.values.any() or len(curve.values) < 2 for curve in inputs):
        words.append("No input acts in this run.")
    words.append(_bullets(scene_data.notes))
    words.append("Time is simulated time; drag the cursor below, or press space to play.")
    return "\n\n".join(filter(None, words))


def _bullets(sentences: Iterable[str]) -> str:
    return "\n".join(f"- {escape_markdown(one)}" for one in sentences)


def _scene_sentences(scene_data: SceneData, scales: Scales) -> Iterator[str]:
    """Yield sentences on shapes, colours, factors and frames."""
    yield from map(_shape_text, scene_data.shapes)
    if scene_data.remark:
        yield f"**{escape_markdown(scene_data.remark)}**"
    yield from map(_colour_text, scales.colours)
    yield _exaggeration_text(scene_data, scales)
    yield " ".join(picture_sentences(scene_data))
    if len(times := scene_data.shapes[0].times) > 1:
        yield f"{len(times)} frames from {times[0] * 1e6:.6g} to {times[-1] * 1e6:.6g} \u00b5s."


def _shape_text(shape: Motion | MeshFrames) -> str:
    if isinstance(shape, MeshFrames):
        name = escape_markdown(shape.name.capitalize())
        return f"**{name}: {len(shape.connectivity)} cells** between {len(shape.nodes)} nodes."
    least, largest = f"{shape.radius.min() * 1e3:.4g}", f"{shape.radius.max() * 1e3:.4g}"
    radii = least if least == largest else f"{least} to {largest}"
    links = "".join(f" {len(one.pairs)} {escape_markdown(one.name)} join them." for one in shape.links)
    return f"**{shape.total} {escape_markdown(shape.name)}**, radius {radii} mm (true to scale).{links}"


def _exaggeration_text(scene_data: SceneData, scales: Scales) -> str:
    if not any(shape.located for shape in scene_data.shapes):
        return ""
    words = "true to scale" if scales.exaggeration == 1.0 else f"drawn {scales.exaggeration:g} x larger than they are"
    return f"**Displacements are {words}.**{'' if scales.settled else ' Factor and limits are adjusted during the run.'}"


def _colour_text(scale: ColourScale) -> str:
    unit = "" if scale.unit == "1" else f" {escape_markdown(scale.unit)}"
    below = f"-{scale.limit:g}{unit} (blue) through " if scale.has_sign else ""
    beyond = " and more" if scale.is_exceeded else ""
    names = " and ".join(escape_markdown(name) for name in scale.names)
    return f"**Colour: {names}**, from {below}0 (white) to +{scale.limit:g}{unit} (red){beyond}."
