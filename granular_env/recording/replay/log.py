"""A log, opened: its content, and the program that it is, to be re-run or branched off."""

from __future__ import annotations

import os
from collections.abc import Mapping
from types import MappingProxyType

from ...components.component import Component
from ...components.errors import LogError, ParameterError
from ..reader.component_from_header import build
from ..reader.log_reader import LogReader
from ..recorder.log_writer import as_path
from .branch import Branch, branch_of
from .steps import restore


def open_log(
    path: str | os.PathLike[str], *, allow_large: bool = False, components: Mapping[str, type[Component]] | None = None
) -> Log:
    """Open a log; nothing but its index is read until it is asked for.

    Args:
        path: an MCAP file that `record` wrote; one whose writer was killed opens as far as it is intact.
        allow_large: lift the limits on sizes, for a file whose origin you trust.
        components: classes of components that are not ours, by name: a log alone never loads them.

    Raises:
        LogError: it is no log, or it is damaged.
    """
    log = Log(as_path(path), allow_large)
    log.components = components or {}
    return log


class Log(LogReader):
    """A log, as `open_log` gives it: what `LogReader` reads of it, and the component whose run it holds.

    Attributes:
        components: classes of components that are not ours, by name, which it may be re-run with.
    """

    components: Mapping[str, type[Component]] = MappingProxyType({})

    def component(self) -> Component:
        """Return a fresh component with the log's parameters, in the state at the log's start.

        Raises:
            LogError: the parameters do not give the identity that the log claims.
        """
        component = self.rebuilt()
        if component.identity != self.records.header.get("identity"):
            raise LogError(
                "its parameters do not give the identity it claims",
                hint=f"they were changed, or it is from another version of {component.name!r} (see `replay --verify`)",
                source=f"log {str(self.path)!r}",
            )
        if self.segments:
            restore(component, self.snapshot(self.segments[0], self.segments[0].start))
        return component

    def rebuilt(self) -> Component:
        """Return a fresh component with the log's parameters, its identity not compared and its state that of a reset."""
        return build(self.records.header, self.records.limits, self.components)

    def branch(self, at: float) -> Branch:
        """Return a component in the state at a time [s] of the log, and what the log did from there.

        A time between two steps is moved to the nearest; ``.component.time`` is the one that was taken.

        Raises:
            ParameterError: the time is outside of the log.
            LogError: the log cannot be re-run.
        """
        try:
            return branch_of(self, at)
        except ParameterError as error:
            raise error.renamed("time", "at") from None
