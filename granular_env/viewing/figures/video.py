"""Films of a log as MP4 or GIF files, drawn without a screen."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from granular_env.components.drawables import Cells, drawn_outputs, element_count
from granular_env.components.errors import GranularError, ParameterError
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.validation import positive_number
from granular_env.optional_packages import import_optional
from granular_env.output_files import replace_file, require_writable
from granular_env.progress import Progress, progress_bar

from ..recorded_fields import pick_evenly, recorded_outputs
from ..scene_builder import load_shapes, require_log
from ..scene_scales import make_scales
from .film_figure import FilmFigure
from .overlays import load_overlays
from .plane import Plane, is_pale

_DOTS_PER_INCH = 150.0
# Largest number of positions in all frames of a film together, and largest number of its pictures.
_MOST_POSITIONS, _MOST_PICTURES = 5_000_000, 100_000
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
        frame_rate: pictures per second of the film; a frame of the log is repeated until the next one.
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
    rate, seconds = positive_number("frame_rate", frame_rate), positive_number("duration", duration)
    if rate * seconds > _MOST_PICTURES:
        raise ParameterError(
            f"got {seconds:g} s at {rate:g} pictures per second", expected=f"at most {_MOST_PICTURES} pictures", at="duration"
        )
    if size is not None and (len(size) != 2 or any(side % 2 or not 64 <= side <= _LARGEST_SIDE for side in size)):
        raise ParameterError(f"got {size}", expected=f"two even numbers of pixels from 64 to {_LARGEST_SIDE}", at="size")
    if write is _write_mp4:
        import_optional("imageio_ffmpeg", "an MP4 film")
    count = max(2, round(rate * seconds))
    plane = _load_film(log, count, colour, show, exaggerate)
    figure = FilmFigure(plane, _DOTS_PER_INCH, size)
    instants = np.linspace(plane.times[0], plane.times[-1], count)
    frames = np.abs(plane.times[:, None] - instants).argmin(axis=0)
    with progress_bar(f"film {target.name}", count, show=progress) as bar, replace_file(path) as part:

        def pictures() -> Iterator[Pixels]:
            drawn, last = np.zeros(0, np.uint8), -1
            for done, frame in enumerate(frames.tolist(), start=1):
                if frame != last:
                    drawn, last = np.ascontiguousarray(figure.draw_frame(frame)[..., :3]), frame
                yield drawn
                bar.update(done)

        write(part, pictures(), rate)
    return Path(path)


def _load_film(log: Any, count: int, colour: str | None, show: Sequence[str], exaggerate: float | None) -> Plane:
    """Read the shapes in at most `count` frames, fewer for large bodies."""
    recorded = recorded_outputs(log)
    clock = next((np.asarray(log.times(name)) for name in drawn_outputs(log.drawables) if name in recorded), np.zeros(0))
    size = max([1, *(len(one.nodes) if isinstance(one, Cells) else element_count(one) for one in log.drawables)])
    times: FloatArray = clock[pick_evenly(len(clock), max(2, min(count, _MOST_POSITIONS // size)))]
    scene = load_shapes(log, times.tolist(), colour)
    factor = None if exaggerate is None else positive_number("exaggerate", exaggerate)
    if (scales := make_scales(scene, factor)) is None:
        hint = "record displacements, or an output that colours particles or cells"
        raise ParameterError("this log contains no body to draw", hint=hint, at="log")
    overlays = load_overlays(log, scene.shapes[0].times, show)
    return Plane(scene, scales, overlays, is_pale(overlays, colour))


def _write_mp4(path: Path, pictures: Iterator[Pixels], rate: float) -> None:
    """Encode pictures as H.264; `GranularError` if the encoder fails."""
    import imageio_ffmpeg as encoder

    count, first = 1, next(pictures)
    options = {"fps": rate, "codec": "libx264", "quality": _QUALITY, "macro_block_size": 2, "ffmpeg_log_level": "quiet"}
    writer = encoder.write_frames(path, first.shape[1::-1], output_params=["-f", "mp4"], **options)
    try:
        with closing(writer):
            writer.send(None)
            writer.send(first)
            for picture in pictures:
                writer.send(picture)
                count += 1
        # The encoder does not report a full disk, so count the written pictures.
        complete = encoder.count_frames_and_secs(path)[0] == count
    except (OSError, RuntimeError):
        complete = False
    if not complete:
        raise GranularError("the film cannot be written: the encoder failed", hint="free some space or choose another folder")


def _write_gif(path: Path, pictures: Iterator[Pixels], rate: float) -> None:
    """Encode pictures as GIF, each with its own palette."""
    options: Any = {"method": Image.Quantize.FASTOCTREE, "dither": Image.Dither.NONE}
    frames = (Image.fromarray(one).quantize(_COLOURS, **options) for one in pictures)
    first = next(frames)
    first.save(path, "GIF", save_all=True, append_images=frames, duration=round(1000.0 / rate), loop=0)
