"""A layout (arrangement of panels) for Foxglove: front view of the log's preview, a description, and a plot per quantity.

Without a layout, Foxglove hides the topics of an unknown file, and its camera is 20 m away from a body of a few centimetres.
"""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any

from granular_env.colours import PALETTE
from granular_env.components.drawables import Points
from granular_env.components.errors import LogError
from granular_env.components.variables import Variable
from granular_env.output_files import replace_file
from granular_env.recording.header import balance_quantities
from granular_env.recording.log import Log
from granular_env.recording.preview.clouds import bounding_box, cloud_topic, shown_drawables
from granular_env.recording.preview.encoding import FRAME
from granular_env.recording.preview.film import ABOUT_TOPIC, number_topics, topic_quantity

_POINT_SIZE, _OTHER_SIZE = 5, 3
# Vertical field of view of the camera [degrees], and smallest aspect ratio (width over height) of its picture.
_OPENING, _ASPECT = 45.0, 1.6
_TANGENT = math.tan(math.radians(_OPENING / 2))
# In Foxglove's camera settings, phi is the polar angle from the vertical [degrees].
_VIEW = {"phi": 80.0, "thetaOffset": 0.0, "perspective": True, "fovy": _OPENING}


def save_foxglove_layout(log: Log, path: str | os.PathLike[str]) -> Path:
    """Write the layout for a log as a JSON file; in Foxglove: Layouts, Import from file.

    Args:
        log: a complete log.
        path: the file to write; an existing file is replaced.

    Returns:
        The path.

    Raises:
        LogError: the log was not closed and has no preview, or the file cannot be written.
    """
    text = json.dumps(foxglove_layout(log), indent=1) + "\n"
    with replace_file(path, LogError) as part:
        part.write_text(text, encoding="utf-8")
    return Path(path)


def foxglove_layout(log: Log) -> dict[str, Any]:
    """Return the layout for a log in Foxglove's export format; `LogError` if the log has no preview."""
    groups: dict[str, dict[str, Variable]] = {}
    for topic, variable in _plotted_numbers(log).items():
        groups.setdefault(topic_quantity(topic), {})[topic] = variable
    plots = {f"Plot!{place}": _plot_panel(name, topics, place) for place, (name, topics) in enumerate(groups.items())}
    about = {"RawMessages!about": {"topicPath": f"{ABOUT_TOPIC}.data", "diffEnabled": False}}
    scene = {"3D!preview": _scene_panel(log)} if shown_drawables(log.drawables, log.variables) else {}
    below = _panel_row([*about, *plots])
    layout: Any = {"direction": "column", "first": "3D!preview", "second": below, "splitPercentage": 60} if scene else below
    return {
        "configById": {**scene, **about, **plots},
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": layout,
    }


def _plotted_numbers(log: Log) -> dict[str, Variable]:
    """Return topic -> variable of the numbers in the preview."""
    known, found = number_topics(log.variables, balance_quantities(log.header.get("balances"))), log.container.topics.values()
    if ABOUT_TOPIC not in found:
        raise LogError(
            "the log has no preview for stock viewers: it was not closed, or an older version wrote it",
            hint="`granular-env recover` writes a log with a preview",
            source=f"log {str(log.path)!r}",
        )
    return {topic: variable for topic, (variable, _) in known.items() if topic in found}


def _scene_panel(log: Log) -> dict[str, Any]:
    shown = shown_drawables(log.drawables, log.variables)
    low, high = bounding_box(shown)
    middle, (width, depth, height) = (low + high) / 2, (high - low).tolist()
    tilt = math.radians(_VIEW["phi"])
    # Height [m] that the picture must cover at the bodies so that they fit in; x runs across the picture.
    seen = 1.1 * max(height * math.sin(tilt) + depth * math.cos(tilt), width / _ASPECT)
    distance = seen / 2 / _TANGENT
    topics: dict[str, Any] = {}
    for one in shown:
        size = _POINT_SIZE if isinstance(one, Points) else _OTHER_SIZE
        topics[cloud_topic(one)] = {"visible": True, "pointSize": size, "colorMode": "rgba", "colorField": "rgba"}
    camera = {
        **_VIEW,
        "distance": distance,
        "target": [0.0, 0.0, 0.0],
        "targetOffset": middle.tolist(),
        "targetOrientation": [0.0, 0.0, 0.0, 1.0],
        "near": distance / 100,
        "far": distance * 100,
    }
    # Hide the frame axes: Foxglove draws them a few centimetres long, over the particles.
    hidden = {f"frame:{FRAME}": {"visible": False}}
    followed = {"followMode": "follow-none", "followTf": FRAME}
    return {"cameraState": camera, **followed, "scene": {}, "transforms": hidden, "layers": {}, "topics": topics}


def _plot_panel(quantity: str, topics: dict[str, Variable], place: int) -> dict[str, Any]:
    unit = next(iter(topics.values())).unit
    paths = [
        {
            "value": f"{topic}.data[0]",
            "label": topic.rpartition("/")[2],
            "enabled": True,
            "timestampMethod": "receiveTime",
            "color": PALETTE[(place + number) % len(PALETTE)],
        }
        for number, topic in enumerate(topics)
    ]
    return {
        "paths": paths,
        "foxglovePanelTitle": quantity if unit == "1" else f"{quantity} [{unit}]",
    }


def _panel_row(panels: list[str]) -> Any:
    """Return Foxglove's layout node for panels of equal width side by side."""
    if len(panels) == 1:
        return panels[0]
    return {"direction": "row", "first": panels[0], "second": _panel_row(panels[1:]), "splitPercentage": 100 / len(panels)}
