"""A complete log out of a killed or damaged one."""

from __future__ import annotations

import os
from pathlib import Path

from pydantic import BaseModel

from ...components import catalogue
from ...components.errors import Fault, GranularError, LogError, Option, ParameterError
from ...output_files import replacing
from ..format.metadata import metadata_of_log
from ..format.records import CLOSED, INCIDENTS, TOPICS, Record, decode
from ..preview.frame_selection import FROM_FRAMES
from ..recorder.log_file import create, refuse_unless_log
from ..recorder.log_writer import LogWriter, as_path
from .log import Log, open_log
from .preview_reconstruction import preview_of_frames


def recover(
    path: str | os.PathLike[str], out: str | os.PathLike[str], *, allow_large: bool = False, overwrite: bool = False
) -> Log:
    """Write a complete log with everything of `path` that is intact, from the front to the first damage.

    Args:
        path: the log of a killed process, or a damaged one; it is only read.
        out: the new file.
        allow_large: lift the limits on sizes.
        overwrite: whether an existing `out` may be replaced.

    Returns:
        The new log, opened; the last of ``.incidents`` says what was lost.

    Raises:
        LogError: nothing is intact, or `out` cannot be written.
        ParameterError: `out` exists, or is no log that could be replaced, or is the damaged file itself.
    """
    source, target = as_path(path), as_path(out)
    if os.path.lexists(target) and not overwrite:
        hint = ("choose another name, or pass ", Option("overwrite"))
        raise ParameterError(Fault(("out",), f"{str(target)!r} exists", hint=hint))
    if os.path.exists(target) and os.path.exists(source) and os.path.samefile(source, target):
        raise ParameterError(f"{str(target)!r} is the damaged log itself", hint="choose another name", at="out")
    refuse_unless_log(target)
    with Log(source, allow_large, scan=True) as log, replacing(target, LogError) as part:
        unharmed = f"{str(source)!r} is as it was; nothing was left behind"
        _copy(log, LogWriter(target, create(part, overwrite=True), unharmed), _has_summary(source, allow_large))
    return open_log(target, allow_large=allow_large)


def _has_summary(source: Path, allow_large: bool) -> bool:
    try:
        with Log(source, allow_large) as log:
            return log.complete
    except GranularError:
        return False


def _copy(log: Log, sink: LogWriter, had_summary: bool) -> None:
    """Every record as it is, then what stock viewers draw, then what was lost."""
    closing: Record | None = None
    container = log.records.container
    for chunk, message in container.all_messages():
        kind = TOPICS.get(message.topic)
        if kind is not None:
            record = decode(message.data, kind, log.identity if chunk or sink.log else None, container.most_text)
            if kind == INCIDENTS and record.detail == CLOSED:
                closing = record
            else:
                sink.add(record, message.nanoseconds)
    sink.flush()
    sink.add_metadata(metadata_of_log(log.records.header, parameter_model(log.records.header.get("component"))))
    track = preview_of_frames(log)
    if track is not None:
        sink.add_preview(track.messages())
    _finish(log, sink, closing, had_summary)


def _finish(log: Log, sink: LogWriter, closing: Record | None, had_summary: bool) -> None:
    segment = log.records.index.all_segments[-1] if log.records.index.all_segments else None
    number, tick = (segment.number, segment.end) if segment else (0, 0)
    nanoseconds = log.records.nanoseconds(log.end_tick)
    nothing = "nothing, the log was complete" if had_summary else "nothing but the summary"
    lost = log.records.container.damage or (nothing if closing else "what had not been written when the process ended")
    bytes_lost = log.records.container.bytes_lost
    header = {"incident": "recovered", "from": Path(log.path).name, "lost": lost[:2000], "bytes_lost": bytes_lost}
    sink.add(Record(INCIDENTS, 0, number, tick, tick, 1, sink.number(INCIDENTS), header, {}), nanoseconds)
    sink.flush()
    # Without a closing record nobody knows the report and the cautions; a verification says so.
    header = {**(closing.header if closing else {"incident": "closed"}), "preview": FROM_FRAMES}
    place = number, tick, tick, 1, sink.number(INCIDENTS)
    sink.add(Record(INCIDENTS, CLOSED, *place, header, {"index": sink.rows}), nanoseconds)
    sink.finish()


def parameter_model(name: object) -> type[BaseModel] | None:
    """Return the parameter model of a component of ours; None for others."""
    try:
        return catalogue.component_class(str(name)).Parameters
    except GranularError:
        return None


__all__ = ["GranularError", "recover"]
