"""Films of a log as MP4 or GIF files, drawn without a screen."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import closing
from itertools import chain
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from granular_env.components.errors import GranularError, ParameterError
from granular_env.components.support.validation import positive_number
from granular_env.optional_packages import import_optional
from granular_env.output_files import replace_file, require_writable
from granular_env.progress import Progress, progress_bar

from ..recorded_fields import recorded_outputs
from ..scene_builder import load_shapes, require_log
from ..scene_scales import make_scales
from .film_figure import FilmFigure
from .plane import Plane, add_overlays

_DOTS_PER_INCH = 150.0
# Largest number of values of an output in all frames of a film together, and largest number of its pictures.
_MOST_NUMBERS, _MOST_PICTURES = 15_000_000, 100_000
_LARGEST_SIDE = 8192
# Quality of the MP4 encoder, from 1 to 10, and colours of a GIF.
_QUALITY, _COLOURS = 6, 128

Pixels = npt.NDArray[np.uint8]


def video(
    log: Any,
    path: str | os.PathLike[str],
    *,
    colour: str | None = None,
    show: Sequence[str] = (),
    frame_rate: float = 20.0,
    duration: float = 10.0,
    size: tuple[int, int] | None = None,
    exaggerate: float | None = None,
    progress: Progress = False,
) -> Path:
    """Write a film of the bodies in a log, with curves along x for a row of particles or a gas.

        ge.viewing.video(log, "disc.mp4", show=["link_force"])

    The simulated time between two pictures is constant. Scales are constant too.

    Args:
        log: an open log.
        path: the file, which ends in .mp4 (needs the extra `video`) or .gif; an existing file is replaced.
        colour: a recorded output that colours the shapes, instead of the component's choice.
        show: recorded outputs to draw over the shapes: vectors as arrows, stresses as crosses along the principal
            directions, forces of links as lines.
        frame_rate: pictures per second of the film; each shows the nearest frame of the log.
        duration: duration of the film [s].
        size: width and height in pixels, even numbers; by default the film is up to 1080 pixels wide and fits the bodies.
        exaggerate: factor of the drawn displacements; by default motion is visible.
        progress: show a bar, or call this with the completed fraction.

    Returns:
        The path.

    Raises:
        MissingExtraError: matplotlib or, for MP4, imageio-ffmpeg is not installed.
        ParameterError: an argument is not valid, or the log contains nothing to draw.
        GranularError: the file cannot be written.
    """
    require_log(log)
    target = require_writable(path)
    writers = {".mp4": _write_mp4, ".gif": _write_gif}
    if (write := writers.get(target.suffix.lower())) is None:
        raise ParameterError(f"got {os.fspath(path)!r}", expected="the name of a file that ends in .mp4 or .gif", at="path")
    if (wanted := positive_number("frame_rate", frame_rate) * positive_number("duration", duration)) > _MOST_PICTURES:
        expected = f"at most {_MOST_PICTURES} pictures"
        raise ParameterError(f"got {duration:g} s at {frame_rate:g} pictures per second", expected=expected, at="duration")
    if size is not None and (len(size) != 2 or any(side % 2 or not 64 <= side <= _LARGEST_SIDE for side in size)):
        raise ParameterError(f"got {size}", expected=f"two even numbers of pixels from 64 to {_LARGEST_SIDE}", at="size")
    if write is _write_mp4:
        import_optional("imageio_ffmpeg", "an MP4 film")
    count = max(2, round(wanted))
    plane = _load_film(log, count, colour, show, exaggerate)
    figure = FilmFigure(plane, _DOTS_PER_INCH, size)
    instants = np.linspace(plane.times[0], plane.times[-1], count)
    frames = np.searchsorted(0.5 * (plane.times[1:] + plane.times[:-1]), instants)
    with progress_bar(f"film {target.name}", len(plane.times), show=progress) as bar, replace_file(path) as part:

        def pictures() -> Iterator[Pixels]:
            for frame, repeats in zip(*np.unique(frames, return_counts=True), strict=True):
                yield from [np.ascontiguousarray(figure.draw_frame(frame)[..., :3])] * repeats
                bar.update(frame + 1)

        write(part, pictures(), frame_rate, count)
    return Path(path)


def _load_film(log: Any, count: int, colour: str | None, show: Sequence[str], exaggerate: float | None) -> Plane:
    """Read the shapes in at most `count` frames, fewer for large bodies."""
    recorded = recorded_outputs(log)
    largest = max((prod(one.shape) for one in recorded.values()), default=1)
    clock = next((log.times(name) for name in recorded), np.zeros(1))
    times = np.linspace(clock[0], clock[-1], max(2, min(count, _MOST_NUMBERS // largest)))
    scene = load_shapes(log, times.tolist(), colour)
    factor = None if exaggerate is None else positive_number("exaggerate", exaggerate)
    if (scales := make_scales(scene, factor)) is None:
        hint = "record displacements, or an output that colours particles or cells"
        raise ParameterError("this log contains no body to draw", hint=hint, at="log")
    return add_overlays(log, Plane(scene, scales), show, may_be_pale=colour is None)


def _write_mp4(path: Path, pictures: Iterator[Pixels], rate: float, count: int) -> None:
    """Encode pictures as H.264; `GranularError` if the encoder fails."""
    import imageio_ffmpeg as encoder

    first = next(pictures)
    options = {"fps": rate, "codec": "libx264", "quality": _QUALITY, "macro_block_size": 2, "ffmpeg_log_level": "quiet"}
    try:
        with closing(encoder.write_frames(path, first.shape[1::-1], output_params=["-f", "mp4"], **options)) as writer:
            for picture in chain([None, first], pictures):  # None starts the encoder
                writer.send(picture)
        # The encoder does not report a full disk, so count the written pictures.
        complete = encoder.count_frames_and_secs(path)[0] == count
    except (OSError, RuntimeError):
        complete = False
    if not complete:
        raise GranularError("the film cannot be written: the encoder failed", hint="free some space or choose another folder")


def _write_gif(path: Path, pictures: Iterator[Pixels], rate: float, count: int) -> None:
    """Encode pictures as GIF, each with its own palette; their times are rounded to 10 ms, the unit of the format."""
    options: Any = {"method": Image.Quantize.MAXCOVERAGE, "dither": Image.Dither.NONE}
    frames = (Image.fromarray(one).quantize(_COLOURS, **options) for one in pictures)
    times = 10 * np.diff(np.rint(100.0 / rate * np.arange(count + 1)).astype(np.int64))
    next(frames).save(path, "GIF", save_all=True, append_images=frames, duration=times.tolist(), loop=0)
