"""Sentences common to all pictures of a scene: viewpoint, contents and omissions."""

from __future__ import annotations

from .cracks import MOST_LINES
from .scene_data import SceneData
from .viewpoint import viewpoint_text


def picture_sentences(scene_data: SceneData) -> list[str]:
    """Return the sentences, independent of the viewer."""
    links = [one for motion in scene_data.motions for one in motion.links]
    sentences = [f"Seen {viewpoint_text(scene_data.viewpoint)}; dark is the inside."] if scene_data.is_solid else []
    if any(motion.rotation is not None for motion in scene_data.motions):
        sentences.append("A spoke shows how each is turned.")
    if any(mesh.whole is not None for mesh in scene_data.meshes):
        sentences.append("Cells that a crack crosses are left out.")
    if links:
        sentences.append("A broken link is a short line across, while its two ends are near.")
    if any(len(one.pairs) > MOST_LINES for one in links):
        sentences.append("Links that hold are not drawn: they would hide the colours.")
    return sentences
