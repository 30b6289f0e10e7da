"""The loop that advances an experiment from its start to its end, a stop rule, or Ctrl-C."""

from __future__ import annotations

import dataclasses
import os
import signal
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from time import perf_counter
from typing import Any, Self

from granular_env.components.component import Component
from granular_env.components.errors import (
    ExperimentError,
    GranularError,
    GranularWarning,
    ParameterError,
    StepError,
)
from granular_env.components.inputs import Held
from granular_env.components.profiles import Profile
from granular_env.components.stepping import Observer
from granular_env.components.support.html_summary import html_summary
from granular_env.components.support.memory_limits import refuse_excess_memory
from granular_env.components.support.validation import finite_number
from granular_env.documents import Overrides
from granular_env.experiments.experiment import Source, load_experiment
from granular_env.experiments.preparation import prepare_experiment
from granular_env.experiments.stop_rules import StopWatch
from granular_env.progress import Progress, progress_bar

# A run is made in pieces of this wall time [s]; Ctrl-C, progress bar, recorder are handled between them. Each copies the state
# once. For a large state the pieces are longer, so that a copy at this rate [bytes/s] takes at most 5 % of a piece.
_PIECE_SECONDS = 0.02
_COPY_SHARE, _COPY_RATE = 0.05, 2e9
# Largest ratio of the numbers of ticks in two successive pieces of a run.
_GROWTH = 64
# Default wall time of a live run [s]; all shipped experiments take less.
_LIVE_SECONDS = 10.0
# Copies of the state that a recorder may need at once: snapshots in the write queue, and the bytes encoded from them.
_COPIES_RECORDED = 6
# Energies below this are rounding errors of a state at rest [J].
_LEAST_ENERGY = 1e-24

Inputs = Mapping[str, Held | Profile]


@dataclasses.dataclass(frozen=True)
class RunResult:
    """The result of a run.

    Attributes:
        component: the component in its state at the end of the run.
        log: the log's path, or None without a log.
        ticks: number of internal steps (ticks) made.
        seconds: wall time of the stepping [s].
        stopped_by: the stop rule that ended the run, as text, or None.
        unmet_stops: the stop rules of a run that ended without them, as texts.
        interrupted: whether Ctrl-C ended the run; the log is complete up to this point.
        report: numbers that show whether the model's assumptions hold, by name with unit.
        conclusions: sentences on the state of the component at the end.
        cautions: a sentence for each violated assumption.
        warnings: warnings of the run.
        start: tick at which the run, or its log, begins: 0, or later for a branch.
    """

    component: Component
    log: Path | None
    ticks: int
    seconds: float
    stopped_by: str | None
    interrupted: bool
    report: dict[str, float]
    conclusions: list[str]
    cautions: list[str]
    warnings: list[str]
    start: int = 0
    unmet_stops: list[str] = dataclasses.field(default_factory=list)

    def _repr_html_(self) -> str:
        names = ("log", "ticks", "seconds", "stopped_by", "interrupted", "conclusions", "cautions", "warnings")
        facts = {name.replace("_", " ").replace("seconds", "wall time [s]"): getattr(self, name) for name in names}
        return html_summary(f"run of {self.component!r}", facts, ("validity", "value"), self.report.items())


def run(
    experiment: Source,
    *,
    log: str | os.PathLike[str] | None = None,
    overrides: Overrides = (),
    progress: Progress = False,
    live: bool = False,
    pace: float | None = None,
    overwrite: bool = False,
    observers: Iterable[Observer] = (),
) -> RunResult:
    """Run an experiment to its end.

        result = ge.run("nesterenko-1983/3.4-piston", log="logs/piston.mcap", overrides={"component.grains": 500})

    Everything is checked before the log is started. The loop steps in pieces of a few hundredths of a second. Because
    ``step(n h)`` equals n times ``step(h)``, neither the pieces nor recorder, bar, viewer or stop rules change a bit.

    Args:
        experiment: a shipped experiment's name, the path of a TOML file, the content of one, or a loaded experiment.
        log: path of the log.
        overrides: keys of the experiment to set, such as ``{"component.grains": 500, "duration": 1e-3}``.
        progress: show a bar with simulated time, speed and the energy residual; or call this with the completed fraction.
        live: show the run in rerun.
        pace: with `live`, the least wall time of the run [s], so that it can be watched; 0 for no limit. By default 10 s.
        overwrite: whether an existing log may be replaced.
        observers: further observers.

    Raises:
        ExperimentError: the experiment is invalid or requires more memory than available (nothing has been written), or
            memory ran out during the run.
        ParameterError: `pace` without `live`, or not a number >= 0.
        GranularError: `live` without a screen, or the viewer cannot start; nothing has been written.
        StepError: the physics would break down; the log is complete up to the last good state, a note of the error names it.
        LogError: the log cannot be written.
    """
    loaded = load_experiment(experiment, overrides)
    seconds = _live_seconds(live, pace)
    with translate_memory_errors(loaded.origin, ExperimentError), collect_warnings() as issued, ExitStack() as stack:
        ready = prepare_experiment(loaded)
        if live:
            from granular_env.viewing import LiveViewer

            duration = ready.ticks * ready.component.step_size
            stack.enter_context(LiveViewer(ready.component, title=loaded.name, duration=duration, pace=seconds))
        if log is not None:
            from granular_env.experiments.cost import announce_log_size, refuse_oversized_log
            from granular_env.recording import record

            refuse_oversized_log(ready, Path(log))
            announce_log_size(ready, progress is True)
            refuse_unrecordable(ready.component)
            options = {"overwrite": overwrite, "experiment": loaded.to_dict(), **loaded.record.model_dump()}
            stack.enter_context(record(ready.component, log, **options))
        return advance_component(
            ready.component,
            ready.ticks,
            ready.inputs,
            stops=ready.stops,
            title=loaded.name,
            progress=progress,
            observers=observers,
            log=None if log is None else Path(log),
            issued_warnings=issued,
            closing_stack=stack,
        )


def advance_component(
    component: Component,
    end: int,
    inputs: Inputs,
    *,
    changes: Mapping[int, Inputs] | None = None,
    stops: StopWatch | None = None,
    title: str = "",
    progress: Progress = False,
    observers: Iterable[Observer] = (),
    log: Path | None = None,
    issued_warnings: list[str] | None = None,
    closing_stack: ExitStack | None = None,
) -> RunResult:
    """Advance a component from its present tick to a later tick; used by `run`, `replay`, `resume` and branches.

    Args:
        component: the component to advance.
        end: the tick to reach.
        inputs: inputs of the first step, held afterwards.
        changes: mapping from tick to the inputs to set there.
        stops: rules that end the run early.
        title: title of the progress bar.
        progress: show the bar, or call this with the completed fraction.
        observers: observers of the component during the loop.
        log: path of the log in the result.
        issued_warnings: list to which the warnings of the run are added.
        closing_stack: context managers, such as the recorder, to be closed after the last step.
    """
    first, began = component.tick, perf_counter()
    stopped_by, interrupted = None, False
    with ExitStack() as stack:
        show = _progress_display(stack, title, component, end, progress) if progress is not False else None
        for observer in observers:
            component.observe(observer)
            stack.callback(component.ignore, observer)
        interrupt = stack.enter_context(Interrupt())
        try:
            stopped_by = _step_until(component, end, {first: inputs, **(changes or {})}, stops, interrupt, show)
        except KeyboardInterrupt:
            interrupted = True  # by the second Ctrl-C; the current step was undone
        seconds = perf_counter() - began
        interrupted = interrupted or (interrupt.pressed and component.tick < end and stopped_by is None)
        if closing_stack is not None:
            closing_stack.close()
    return RunResult(
        component=component,
        log=log,
        ticks=component.tick - first,
        seconds=seconds,
        stopped_by=stopped_by,
        interrupted=interrupted,
        report=component.report(),
        conclusions=component.conclusions(),
        cautions=component.cautions(),
        warnings=issued_warnings if issued_warnings is not None else [],
        unmet_stops=stops.sentences if stops is not None and stopped_by is None and not interrupted else [],
    )


def _step_until(
    component: Component,
    end: int,
    changes: dict[int, Inputs],
    stops: StopWatch | None,
    interrupt: Interrupt,
    show: Callable[[Component], None] | None,
) -> str | None:
    """Step until the tick `end`, Ctrl-C, or a stop rule; return the text of the rule that stopped the run, else None."""
    piece, turns = 1, sorted(changes)
    length = max(_PIECE_SECONDS, component.state_bytes / _COPY_RATE / _COPY_SHARE)
    while component.tick < end and not interrupt.pressed:
        tick, begin = component.tick, perf_counter()
        stop = min(end, tick + piece)
        looked = stops.next_tick(tick) if stops is not None else None
        turn = next((turn for turn in turns if turn > tick), None)
        stop = min([stop, *(other for other in (looked, turn) if other is not None)])
        _step_to_tick(component, stop, changes.get(tick, {}))
        if show is not None:
            show(component)
        if stop == looked and stops is not None and (met := stops.stop_reason(component)) is not None:
            return met
        piece = _next_piece_ticks(piece, stop - tick, (perf_counter() - begin) / length)
    return None


def _step_to_tick(component: Component, stop: int, inputs: Inputs) -> None:
    """Step to the tick `stop`; if that fails, step to the last tick before the failure, so that the log contains it."""
    tick, step = component.tick, component.step_size
    try:
        component.step((stop - tick) * step, **inputs)
    except StepError as error:
        good = round(error.time / step) - 1 - tick
        if 0 < good < stop - tick:
            component.step(good * step, **inputs)
            while component.tick < stop:
                component.step(step)
        raise


def _next_piece_ticks(piece: int, done: int, took: float) -> int:
    """Return the number of ticks of the run's next piece: more if the last piece was complete and fast, half if it was slow.

    `piece` is the number of planned ticks, `done` of completed ones; `took` is the wall time over the intended wall time.
    """
    if took > 2.0:
        return max(1, piece // 2)
    if done < piece or took > 0.5:
        return piece
    return piece * max(2, min(_GROWTH, int(0.5 / max(took, 1e-9))))


class Interrupt:
    """A handler that turns the first Ctrl-C into a flag, checked between pieces; the second Ctrl-C raises immediately."""

    def __init__(self) -> None:
        self.pressed = False
        self._before: Any = None

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            self._before = signal.getsignal(signal.SIGINT)
            if self._before is signal.default_int_handler:
                signal.signal(signal.SIGINT, self._on_interrupt)
        return self

    def __exit__(self, *_: object) -> None:
        if self._before is signal.default_int_handler:
            signal.signal(signal.SIGINT, self._before)

    def _on_interrupt(self, number: int, frame: Any) -> None:
        if self.pressed:
            raise KeyboardInterrupt
        self.pressed = True


@contextmanager
def translate_memory_errors(what: str, kind: type[GranularError]) -> Iterator[None]:
    """Turn a `MemoryError` raised in the block into an error of class `kind`; `what` is the beginning of its message."""
    try:
        yield
    except MemoryError as error:
        raise kind(f"{what}: not enough memory; make the model smaller, or record less often") from error


@contextmanager
def collect_warnings() -> Iterator[list[str]]:
    """Collect this package's warnings as sentences, each once, and issue them at the end of the block."""
    issued: list[str] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GranularWarning)
        try:
            yield issued
        finally:
            issued += dict.fromkeys(str(one.message) for one in caught if issubclass(one.category, GranularWarning))
    for one in {str(one.message): one for one in caught}.values():
        warnings.warn_explicit(one.message, one.category, one.filename, one.lineno)


def refuse_unrecordable(component: Component) -> None:
    """Raise `ExperimentError` if recording a component requires more memory than available."""
    refuse_excess_memory(_COPIES_RECORDED * component.state_bytes, f"recording component {component.name!r}", ExperimentError)


def _live_seconds(live: bool, pace: float | None) -> float | None:
    """Return the least wall time of a live run [s], None for no limit; refuse a live run without a screen."""
    if not live:
        if pace is not None:
            raise ParameterError(f"got {pace!r} without a live view", hint="pass live=True (--live)", at="pace")
        return None
    from granular_env.viewing.rerun.process import require_screen

    look = "show the log: granular-env view LOG --web, --save FILE.rrd or --screenshot FILE.png"
    require_screen(f"run without live=True (--live) and {look}")
    seconds = _LIVE_SECONDS if pace is None else finite_number("pace", pace, "seconds")
    if seconds < 0.0:
        raise ParameterError(f"got {pace!r} s", expected="0 or more", at="pace")
    return seconds or None


def _progress_display(
    stack: ExitStack, title: str, component: Component, end: int, progress: Progress
) -> Callable[[Component], None]:
    """Return a function that shows the progress of the component on a bar."""
    first, begun = component.tick, perf_counter()
    bar = stack.enter_context(progress_bar(title, end, done=first, show=progress))

    def show_progress(component: Component) -> None:
        if bar.is_due():
            speed = (component.tick - first) / max(perf_counter() - begun, 1e-9)
            bar.update(component.tick, f"t = {component.time:.4g} s", f"{speed:,.0f} ticks/s", energy_residual_text(component))

    return show_progress


def energy_residual_text(component: Component) -> str:
    """Return text on the residual of the energy balance: absolute and, if there is energy, relative to it."""
    energy = next((balance for balance in component.balances() if balance.quantity == "energy"), None)
    if energy is None:
        return ""
    residual = float(energy.residual)
    scale = max(sum(map(float, energy.stored.values())), *(abs(float(amount)) for amount in energy.supplied.values()), 0.0)
    share = f" ({residual / scale:+.1e})" if scale > _LEAST_ENERGY else ""
    return f"energy residual {residual:+.2e} J{share}"
