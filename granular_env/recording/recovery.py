"""A complete log out of a killed or damaged one."""

from __future__ import annotations

import os
from collections.abc import Iterator
from itertools import islice
from typing import Any

from ..components.errors import ParameterError
from .header import title_of
from .index import SEGMENT, all_records
from .log import Log, open_log
from .preview.film import Preview
from .records import CLOSED, HEADER, INCIDENTS, Record
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
            raise ParameterError("it is the damaged log itself", hint="choose another name", source=f"log {str(target)!r}")
        writer = LogWriter(target, overwrite, is_hidden=True)
        try:
            copy_records(log, writer, len(log.index.rows))
            writer.add_preview(preview_of(log).messages())
            # Without a closing record the report and the cautions are lost.
            facts = dict(log.closing.header) if log.closing is not None else {}
            lost = "nothing of the run" if log.closing is not None else "what had not been written when the process ended"
            lost, bytes_lost = log.container.damage or lost, log.container.bytes_lost
            told = {"incident": "recovered", "from": source.name, "lost": lost, "bytes_lost": bytes_lost}
            number, tick = next(((one.number, one.end) for one in reversed(log.index.all_segments)), (0, 0))
            writer.add(Record(INCIDENTS, 0, number, tick, tick, 1, 0, told, {}), log.nanoseconds(log.end_tick))
            writer.finish(number, tick, log.nanoseconds(log.end_tick), facts)
        finally:
            writer.abandon()
    return open_log(target, allow_large=allow_large)


def copy_records(log: Log, writer: LogWriter, count: int) -> None:
    """Write the first records of a log as they are, but for its closing one."""
    with log.name_file_in_errors():
        for _, time, record in islice(all_records(log.container), count):
            if record.kind == HEADER:
                writer.add_header(record)
            elif (record.kind, record.detail) != (INCIDENTS, CLOSED):
                writer.add(record, time)


def preview_of(log: Log, end: int | None = None) -> Preview:
    """Return the preview of the frames of a log, up to a tick of the log's time; default: all."""
    preview = Preview(title_of(log.header), log.drawables, log.variables)
    for together in zip(*(_frames_of(log, name) for name in log.variables), strict=False):
        tick = together[0][0]
        if end is None or tick <= end:
            values = [value for _, value in together]
            preview.add(log.nanoseconds(tick), dict(zip(log.variables, values, strict=True)))
    return preview


def _frames_of(log: Log, name: str) -> Iterator[tuple[int, Any]]:
    """Yield tick of the log's time and value of each frame of a variable."""
    for row in log.frame_rows(name):
        ticks, values = log.frames(row, name)
        yield from zip(log.log_tick(row[SEGMENT], ticks).tolist(), values, strict=True)
