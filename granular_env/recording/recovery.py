"""A complete log out of a killed or damaged one."""

from __future__ import annotations

import os
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

from ..components.errors import ParameterError
from .header import title_of
from .index import SEGMENT
from .log import Log, open_log
from .preview.film import Preview
from .records import CLOSED, HEADER, INCIDENTS, Record, decode, kind_of
from .writer import LogWriter, as_path


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
        LogError: nothing is intact, or `out` cannot be written; nothing is left behind.
        ParameterError: `out` exists, or is no log that could be replaced, or is the damaged file itself.
    """
    source, target = as_path(path), as_path(out)
    with Log(source, allow_large, scan=True) as log:
        if os.path.exists(target) and os.path.samefile(source, target):
            raise ParameterError(f"{str(target)!r} is the damaged log itself", hint="choose another name", at="out")
        try:
            writer = LogWriter(target, overwrite, is_hidden=True)
        except ParameterError as error:
            raise error.renamed("path", "out") from None
        try:
            copy_records(log, writer, len(log.index.rows))
            writer.add_preview(preview_of(log).messages())
            _finish(log, writer)
        finally:
            writer.abandon()
    return open_log(target, allow_large=allow_large)


def copy_records(log: Log, writer: LogWriter, count: int) -> None:
    """Write the first records of a log as they are, but for its closing one."""
    container = log.container
    messages = (entry for _, entry in container.all_messages() if kind_of(entry.topic) is not None)
    for topic, message in islice(messages, count):
        with log.name_file_in_errors():
            record = decode(message.data, kind_of(topic) or HEADER, container.most_text)
        if record.kind == HEADER:
            writer.add_header(record)
        elif (record.kind, record.detail) != (INCIDENTS, CLOSED):
            writer.add(record, message.log_time)


def preview_of(log: Log, end: int | None = None) -> Preview:
    """Return the preview of the frames of a log, up to a tick of the log's time; default: all."""
    preview = Preview(title_of(log.header), log.drawables, log.variables)
    for together in zip(*(_frames_of(log, name) for name in log.variables), strict=False):
        tick = together[0][0]
        if end is not None and tick > end:
            break
        values = {name: value for name, (_, value) in zip(log.variables, together, strict=True)}
        preview.add(log.nanoseconds(tick), values)
    return preview


def _frames_of(log: Log, name: str) -> Iterator[tuple[int, Any]]:
    """Yield tick of the log's time and value of each frame of a variable."""
    for row in log.frame_rows(name):
        ticks, values = log.frames(row, name)
        yield from zip(log.log_tick(row[SEGMENT], ticks).tolist(), values, strict=True)


def _finish(log: Log, writer: LogWriter) -> None:
    """Write the incident that names the loss, and the closing record."""
    records, closing = log.records, log.closing
    segment = records.index.all_segments[-1] if records.index.all_segments else None
    number, tick = (segment.number, segment.end) if segment else (0, 0)
    time, container = records.nanoseconds(log.end_tick), records.container
    lost = container.damage or ("nothing of the run" if closing else "what had not been written when the process ended")
    facts = {"incident": "recovered", "from": Path(log.path).name, "lost": lost[:2000], "bytes_lost": container.bytes_lost}
    writer.add(Record(INCIDENTS, 0, number, tick, tick, 1, writer.number(INCIDENTS), facts, {}), time)
    # Without a closing record the report and the cautions are lost.
    writer.finish(number, tick, time, dict(closing.header) if closing else {})
