"""A layout (arrangement of panels) for Foxglove: side view of the log's preview, a description, and a plot per unit.

Without a layout, Foxglove hides the topics of an unknown file, and its camera is 20 m away from a body of a few centimetres.
"""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any

import numpy as np

from granular_env.colours import PALETTE
from granular_env.components.drawables import Cells, Points, to_three_columns
from granular_env.components.errors import LogError
from granular_env.output_files import replace_file
from granular_env.recording.log import Log
from granular_env.recording.preview.encoding import CDR_HEAD, FRAME, decode_number_names
from granular_env.recording.preview.film import ABOUT_TOPIC, bounding_box, cloud_topic, shown_drawables

_POINT_SIZE, _OTHER_SIZE = 5, 3
# Vertical field of view of the camera [degrees], and smallest aspect ratio (width over height) of its picture.
_OPENING, _ASPECT = 45.0, 1.6
_TANGENT = math.tan(math.radians(_OPENING / 2))
# In Foxglove's camera settings, phi is the polar angle from the vertical [degrees].
_SIDE_VIEW = {"phi": 80.0, "thetaOffset": 0.0, "perspective": True, "fovy": _OPENING}
_PLANE_PHI = 30.0


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
    numbers = enumerate(_number_names(log).items())
    plots = {f"Plot!{place}": _plot_panel(topic, names, place) for place, (topic, names) in numbers}
    about = {"RawMessages!about": {"topicPath": f"{ABOUT_TOPIC}.data", "diffEnabled": False}}
    scene = {"3D!preview": _scene_panel(log)} if log.drawables else {}
    below = _panel_row([*about, *plots])
    layout: Any = {"direction": "column", "first": "3D!preview", "second": below, "splitPercentage": 60} if scene else below
    return {
        "configById": {**scene, **about, **plots},
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": layout,
    }


def _number_names(log: Log) -> dict[str, list[str]]:
    """Return, for each topic of the preview with numbers, the names of the numbers; the preview is at the end of the file."""
    found: dict[str, list[str]] = {}
    container = log.container
    for chunk in reversed(range(len(container.places))):
        entries = container.messages(chunk)
        for topic, message in entries:
            if topic.startswith("/") and message.data[:4] == CDR_HEAD and topic not in (ABOUT_TOPIC, *found):
                found[topic] = decode_number_names(message.data)
        if any(topic == ABOUT_TOPIC for topic, _ in entries):
            return found
    raise LogError(
        "the log has no preview for stock viewers: it was not closed, or an older version wrote it",
        hint="`granular-env recover` writes a log with a preview",
        source=f"log {str(log.path)!r}",
    )


def _scene_panel(log: Log) -> dict[str, Any]:
    low, high = bounding_box(log.drawables)
    middle, (width, depth, height) = (low + high) / 2, (high - low).tolist()
    drawn = [one for one in log.drawables if isinstance(one, Points | Cells)]
    places = [one.reference if isinstance(one, Points) else one.nodes for one in drawn]
    is_plane = any(np.ptp(to_three_columns(rows)[:, 1]) > 0.0 for rows in places)
    view = {**_SIDE_VIEW, "phi": _PLANE_PHI} if is_plane else _SIDE_VIEW
    tilt = math.radians(view["phi"])
    # Height [m] that the picture must cover at the bodies so that they fit in; x runs across the picture.
    seen = 1.1 * max(height * math.sin(tilt) + depth * math.cos(tilt), width / _ASPECT)
    distance = seen / 2 / _TANGENT
    topics: dict[str, Any] = {}
    for one in shown_drawables(log.drawables, log.variables):
        size = _POINT_SIZE if isinstance(one, Points) else _OTHER_SIZE
        topics[cloud_topic(one)] = {"visible": True, "pointSize": size, "colorMode": "rgba", "colorField": "rgba"}
    camera = {
        **view,
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


def _plot_panel(topic: str, names: list[str], place: int) -> dict[str, Any]:
    path = json.dumps(topic, ensure_ascii=False)
    paths = [
        {
            "value": f"{path}.data[{number}]",
            "label": name,
            "enabled": True,
            "timestampMethod": "receiveTime",
            "color": PALETTE[(place + number) % len(PALETTE)],
        }
        for number, name in enumerate(names)
    ]
    return {
        "paths": paths,
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "showLegend": True,
        "legendDisplay": "floating",
        "showPlotValuesInLegend": False,
        "isSynced": True,
        "xAxisVal": "timestamp",
        "sidebarDimension": 240,
        "foxglovePanelTitle": topic.removeprefix("/"),
    }


def _panel_row(panels: list[str]) -> Any:
    """Return Foxglove's layout node for panels of equal width side by side."""
    if len(panels) == 1:
        return panels[0]
    return {"direction": "row", "first": panels[0], "second": _panel_row(panels[1:]), "splitPercentage": 100 / len(panels)}
