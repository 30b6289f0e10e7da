"""Branches: continuations of a log from any time with other inputs, or with the same inputs and bitwise equal results."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from ..components.component import Component
from ..components.errors import ParameterError
from ..components.inputs import Held
from ..components.profiles import Profile
from .index import Segment
from .recorder import Recorder, begin_log
from .replay import advance_to_tick, check_work, restore_snapshot
from .schedule import make_schedule, names_to_record, parse_schedule
from .writer import LogWriter, to_path

if TYPE_CHECKING:
    from ..components.profiles import CompiledProfile
    from .log import Log


@dataclass(slots=True)
class Branch:
    """A component in its state at a time of a log.

    Attributes:
        parent: the log.
        segment, tick: number of the log's segment, and the component's tick in it, at which the branch starts.
        component: the component, to be stepped directly or by `run`.
        remaining: mapping from tick to the inputs that the log sets there, from the start of the branch on.
    """

    parent: Log
    segment: Segment
    tick: int
    component: Component
    remaining: dict[int, dict[str, Held]] = field(repr=False)

    @property
    def parent_facts(self) -> dict[str, Any]:
        """Return the data on the parent log that the header of the branch's log stores."""
        name = os.path.basename(str(self.parent.path))
        return {"file": name, "log": self.parent.identity, "identity": self.component.identity, "segment": self.segment.number,
                "tick": self.tick}  # fmt: skip

    def run(
        self,
        log: str | os.PathLike[str],
        inputs: Mapping[str, float | Profile | CompiledProfile] | None = None,
        until: float | None = None,
        *,
        every: float | None = None,
        variables: list[str] | None = None,
        overwrite: bool = False,
    ) -> Log:
        """Step the component with the inputs of the log, except those given here, and record it in a new log.

        Args:
            log: path of the new log.
            inputs: values or profiles from the branch's start on, instead of the log's inputs.
            until: end time on the component's clock [s]; default: the end of the log's segment. Beyond it, the last inputs are
                held.
            every: time between frames, as for `record`; default: the frame times of the parent.
            variables: recorded variables, as for `record`; default: the variables of the parent.
            overwrite: whether an existing file may be replaced.

        Returns:
            The new log, opened.

        Raises:
            ParameterError: an argument is invalid; nothing has been written.
            StepError: the physics would break down with these inputs; the log until then is complete.
        """
        given, end = dict(inputs or {}), self.end_tick(until)
        with self.make_recorder(log, given, every, variables, overwrite) as recorder:
            advance_to_tick(self.component, sorted(self.input_changes(given).items(), reverse=True), end)
        return type(self.parent)(recorder.path, self.parent.limits.lifted)

    def end_tick(self, until: float | None = None) -> int:
        """Return the tick at which to stop, by default the end of the log's segment; `ParameterError` if it has passed."""
        end = self.segment.end if until is None else self.component.duration_ticks(until, "until")
        if end < self.component.tick:
            raise ParameterError(f"got {until:g} s, but the branch begins at {self.component.time:g} s", at="until")
        if until is None:
            # Limit the work only for an end from the log, which is untrusted; a requested end is the user's responsibility.
            check_work(end - self.component.tick, self.component, self.parent.limits)
        return end

    def input_changes(self, inputs: Mapping[str, Any]) -> dict[int, dict[str, Any]]:
        """Return the inputs to set by tick: the given inputs at the branch's start, and the log's for all other inputs."""
        found = {self.tick: dict(inputs)}
        for tick, sets in self.remaining.items():
            found.setdefault(tick, {}).update({name: value for name, value in sets.items() if name not in inputs})
        return found

    def make_recorder(
        self, log: Any, inputs: Mapping[str, Any], every: float | None = None, variables: Any = None, overwrite: bool = False
    ) -> Recorder:
        """Return a recorder of the component; arguments and errors are those of `run`."""
        component, header, target = self.component, self.parent.header, to_path(log)
        if component.tick != self.tick:
            raise ParameterError("the branch's component has been stepped already", hint="take a new branch")
        component.checked_inputs(inputs)
        if os.path.exists(target) and os.path.samefile(target, self.parent.path):
            raise ParameterError("this file is the parent log", hint="choose another name", source=f"log {str(target)!r}")
        names = names_to_record(component, list(self.parent.variables) if variables is None else variables)
        if every is None:
            schedule = parse_schedule(header.get("options"))
        else:
            schedule = make_schedule(component, every, None, None, None, names)
        # Count the ticks that the parent had before the branch, so that the frames have the times that they have in the parent.
        elapsed = self.parent.elapsed + self.segment.elapsed + self.tick - self.segment.start
        return begin_log(
            component, LogWriter(target, overwrite), names, schedule, header.get("experiment"), self.parent_facts, elapsed
        )


def make_branch(log: Log, at: float) -> Branch:
    """Return the branch at a time [s] of a log, run again from the nearest earlier snapshot."""
    segment, tick = log.segment_and_tick(at)
    component = log.component()
    snapshot, steps = log.snapshot(segment, tick), log.step_history(segment)
    check_work(tick - snapshot.tick, component, log.limits)
    restore_snapshot(component, snapshot)
    changes = steps.input_changes(log.snapshot(segment, segment.start).inputs)
    done = [change for change in changes if snapshot.tick <= change[0] < tick]
    advance_to_tick(component, done[::-1], tick)
    return Branch(log, segment, tick, component, {at: sets for at, sets in changes if at >= tick})
