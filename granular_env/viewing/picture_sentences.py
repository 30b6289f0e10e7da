"""Sentences common to all pictures of a scene: viewpoint, contents and omissions."""

from __future__ import annotations

from .cracks import MOST_LINES
from .scene_data import SceneData
from .viewpoint import viewpoint_text


def picture_sentences(scene_data: SceneData) -> list[str]:
    """Return sentences that explain a picture of the scene in any viewer or figure."""
    links = [one for motion in scene_data.motions for one in motion.links]
    sentences = [f"Seen {viewpoint_text(scene_data.viewpoint)}; the inside is dark."] if scene_data.is_solid else []
    if any(motion.rotation is not None for motion in scene_data.motions):
        sentences.append("Spokes show the rotation of the particles.")
    if any(mesh.whole is not None for mesh in scene_data.meshes):
        sentences.append("Cells crossed by a crack are dark pieces, one for each corner.")
    if links:
        sentences.append("A broken link is drawn as a short line across it while its two ends are close.")
    if any(len(one.pairs) > MOST_LINES for one in links):
        sentences.append("Intact links are not drawn, because they would hide the colours.")
    return sentences
