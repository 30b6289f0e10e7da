"""A Gymnasium environment from any component and any task."""

from __future__ import annotations

import copy
import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import wraps
from typing import Any, ClassVar, NamedTuple, SupportsFloat, TypeVar

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.envs.registration import EnvSpec

from ..components.component import Component
from ..components.errors import IssuedCautions, ParameterError, StepError, one_line
from ..components.support.validation import finite_number, positive_number, whole_number
from ..components.variables import Element, parse_element
from .pickling import Given, Recreatable, known_arguments, make_again, recreatable
from .rendering import draw
from .state import Drawn, EnvState, EpisodeOrigin, bit_generator
from .task import Task, counters, judgement, read_only, refuse_incomplete, refuse_taken_names
from .time_observation import clock_readings

Observation = npt.NDArray[np.float32]
Ready = tuple[Component, Task, Drawn]
Env = TypeVar("Env", bound="ComponentEnv")
_LARGEST_CLOCK = 100
# Options of constructors that are read once, so that setting an attribute of that name would do nothing.
_READ_ONCE = frozenset(
    ["internal_steps", "deadline", "hold", "clock", "action_rate", "control_delay", "observe", "noise", "info", "randomise"]
)
# Those of them that are attributes, which the constructor sets once.
_KEPT = frozenset(["internal_steps", "deadline", "hold", "clock", "info"])


class ObservationRow(NamedTuple):
    """A part of an observation: its first and last index, what it shows, and what an entry of 1 stands for."""

    first: int
    last: int
    quantity: str
    unit: str


class ComponentEnv(Recreatable, gymnasium.Env[Observation, npt.NDArray[np.float32]]):
    """A component driven by an agent, as a task sees it.

    ## Action space
    `Box(-1, 1, (entries,), float32)`: an entry for each input that is a number, as many as it has elements for one that is an
    array, row by row, and one for an element such as `force[3,0]`; the elements that are not driven are 0. Each times the
    task's declared scale (`env.unwrapped.task.actions`, in the input's unit) is held over `hold` control steps. Entries outside
    [-1, 1] are clipped; NaN, infinity and wrong shapes are refused with `ParameterError`, and nothing has moved.

    ## Observation space
    `Box(-limit, limit, (size,), float32)`: the task's outputs one after the other, arrays row by row, each divided by its
    declared scale (`env.unwrapped.task.observations`) and clipped to +- `task.observation_limit`; then the clock, whose
    readings lie in [-1, 1]. The unscaled float64 values are in `info`, as fresh arrays.

    ## Rewards, start and end
    The task's. A step that the component refuses (`StepError`: the physics would break down) ends the episode: the reward is
    `step_error_reward`, `terminated` is true, `info["step_error"]` holds the message, the state is that from before the step.
    After `deadline` control steps the episode ends: with a clock it is `terminated`, because the agent has seen the end come,
    without one it is `truncated`, because for the agent time goes on.

    ## Arguments
    * `component`: any `Component`.
    * `task`: any `Task` whose inputs and outputs the component has. It holds the counters of an episode: give each environment
      a component and a task of its own.
    * `internal_steps`: internal steps of the component in a control step.
    * `deadline`: control steps of an episode; None for no end.
    * `hold` (1): control steps for which an action is held (frame skip); the reward of a step is the sum of theirs.
    * `clock` (0): numbers at the end of the observation that tell the time, cos(pi k t / deadline), k = 1 to `clock`.
    * `step_error_reward` (-10): reward of a step that the component refuses, in place of the task's. An episode that the
      component does not refuse can return less.
    * `render_mode`: None or "rgb_array".

    `reset(options={"velocity": {0: 5.0}})` gives start values, as `Component.reset` takes them.

    `copy.deepcopy`, pickle and cloudpickle give an independent environment that goes on with the same bits; a recording stays
    with the original.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 30}  # noqa: RUF012
    _modes: ClassVar[tuple[str | None, ...]] = (None, "rgb_array")
    _spec: EnvSpec | None = None

    def __init__(
        self,
        component: Component,
        task: Task,
        *,
        internal_steps: int = 3,
        deadline: int | None = None,
        hold: int = 1,
        clock: int = 0,
        step_error_reward: float = -10.0,
        render_mode: str | None = None,
    ) -> None:
        if render_mode not in self._modes:
            raise ParameterError(f"got {render_mode!r}", expected='None or "rgb_array"', at="render_mode")
        refuse_incomplete(task)
        self.component, self.task, self.render_mode = component, task, render_mode
        self.drawn: Drawn = {}
        self.internal_steps = whole_number("internal_steps", internal_steps)
        self.deadline = math.inf if deadline is None else whole_number("deadline", deadline)
        self.hold, self.clock = whole_number("hold", hold), _clock(clock, deadline)
        if self.hold > self.deadline:
            raise ParameterError(
                f"got {self.hold}", expected=f"at most the deadline of {self.deadline} control steps", at="hold"
            )
        self.step_error_reward = finite_number("step_error_reward", step_error_reward)
        self.duration = self.internal_steps * component.step_size
        self._scales = element_scales("actions", task.actions, component, "input")
        self._readings = element_scales("observations", task.observations, component, "output")
        self._lay_out_observation()
        self._lay_out_action()
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (len(self._entries),), np.float32)
        self.observation_space = observation_box(task.observation_limit, self._size, self.clock)
        self._elapsed, self._running, task.counters = 0, False, {}
        # As it is at the first save of an episode: only a start draws random numbers.
        self._origin: EpisodeOrigin | None = None

    def __setattr__(self, name: str, value: Any) -> None:
        """Set an attribute; `ParameterError` for an argument that the constructor alone reads."""
        if (name in _READ_ONCE and (name in vars(self) or name not in _KEPT)) or (name[0] != "_" and self.is_read_once(name)):
            raise ParameterError(
                "it cannot be set in an environment that is made", hint=f"make another one with {name}=...", at=name
            )
        super().__setattr__(name, value)

    @property
    def driven_elements(self) -> list[tuple[Element, float]]:
        """Return the inputs, or elements of them, that actions drive, each with its value at action 1."""
        return list(self._scales)

    def _lay_out_action(self) -> None:
        """Say which entries of the action are which input, and what each entry is called in messages."""
        self._driven: list[_Driven] = []
        self._entries: list[str] = []
        for element, scale in self._scales:
            shape, begin = self.component.variables[element.name].shape, len(self._entries)
            if element.index or not shape:
                self._entries.append(str(element))
            else:
                self._entries += [str(Element(element.name, index)) for index in np.ndindex(shape)]
            self._driven.append(_Driven(element, scale, slice(begin, len(self._entries)), shape))
        _refuse_elements_driven_twice(self._driven)

    def _lay_out_observation(self) -> None:
        parts, begin = [], 0  # of each output: its place in the observation, and the factor that scales it
        for element, scale in self._readings:
            shape = () if element.index else self.component.variables[element.name].shape
            size = math.prod(shape)
            parts.append((element, slice(begin, begin + size), shape, np.array(1.0 / scale)))
            begin += size
        self._size, self._scaled = begin, np.empty(begin)
        self._parts = [(element, self._scaled[part].reshape(shape), factor) for element, part, shape, factor in parts]
        self._low, self._high = np.array(-self.task.observation_limit), np.array(self.task.observation_limit)

    # -- Gymnasium --------------------------------------------------------------------------------------------------

    @property
    def spec(self) -> EnvSpec | None:  # type: ignore[override]
        """Return what Gymnasium made this environment from; `max_episode_steps` is one action more than the deadline takes.

        So wrappers know how long an episode is at most, and no time limit comes before the environment's own end.
        """
        return self._spec

    @spec.setter
    def spec(self, given: EnvSpec | None) -> None:  # pyright: ignore[reportIncompatibleVariableOverride]
        if given is not None and given.max_episode_steps is None and self.deadline < math.inf:
            given = replace(given, max_episode_steps=-(-int(self.deadline) // self.hold) + 1)
        self._spec = given

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Observation, dict[str, Any]]:
        """Start an episode; see the class.

        Raises:
            ParameterError: a start value in `options` is not valid, or the seed is none.
        """
        if not isinstance(options, Mapping | None) or "seed" in (options or {}):
            raise ParameterError(
                f"got {one_line(options)}", expected="start values of state variables, name -> value", at="options"
            )
        checked = validate_seed(seed)
        super().reset(seed=checked)
        ready = self._draw()
        start = self._start(ready[1], options or {})
        number = int(self.np_random.integers(2**31))
        if ready[0] is not self.component:
            # Start values that are not valid are refused before anything is replaced.
            ready[0].reset(seed=number, **start)
            self._take(*ready)
        self.component.reset(seed=number, **start)
        self._origin = None
        self._begin(number)
        return self.observe()

    def step(self, action: npt.ArrayLike) -> tuple[Observation, SupportsFloat, bool, bool, dict[str, Any]]:
        """Advance by one action: `hold` control steps, or fewer where the episode ends; see the class.

        Raises:
            ParameterError: the action is not one, the episode is over, or the task's judgement is no (finite reward, done), and
                the component has moved then.
        """
        if not self._running:
            raise ParameterError("the episode is over or has not begun", hint="call reset() first", at="step")
        inputs, total, terminated, late = self._inputs(action), 0.0, False, False
        seen: dict[str, Any] = {}
        for _ in range(self.hold):
            try:
                self.component.step(self.duration, **inputs)
            except StepError as error:
                return self._fail(error, total)
            self._elapsed += 1
            seen = self._see()
            reward, terminated = judgement(self.task, self.component, seen, self.duration)
            total += reward
            late = not terminated and self._elapsed >= self.deadline
            if terminated or late:
                self._running = False
                break
        terminated, truncated = terminated or (late and self.clock > 0), late and self.clock == 0
        return self._observation(), total, terminated, truncated, self._info(seen)

    def render(self) -> npt.NDArray[np.uint8] | None:  # type: ignore[override]
        """Return the present state as a picture, shape (360, 960, 3); None without a render mode."""
        return draw(self.component, self.task) if self.render_mode == "rgb_array" else None

    # -- mid-episode ------------------------------------------------------------------------------------------------

    def observe(self) -> tuple[Observation, dict[str, Any]]:
        """Return the present observation and info, as `reset` gives them; after `restore`, for instance."""
        seen = self._see()
        return self._observation(), self._info(seen)

    def save(self) -> EnvState:
        """Everything that changes in an episode; restoring it gives the same bits from there on."""
        origin = self._origin
        if origin is None:
            origin = EpisodeOrigin(self.task.name, self.np_random.bit_generator.state, self.drawn)
            self._origin = origin
        return EnvState(self.component.save(), self._episode(), origin)

    def restore(self, state: EnvState) -> None:
        """Go on from a saved state, of this environment or of one made in the same way. `observe` tells what is seen there.

        Raises:
            ParameterError: the state belongs to another component or task; nothing has changed.
        """
        if state.__class__ is not EnvState or state.origin is not self._origin:
            self.take_state(state, self.refuse_foreign(state))
            return
        # One of the present episode, as a tree search restores them: nothing else is to be compared.
        self.component.restore(state.snapshot)
        self._go_on(state.episode)

    def refuse_foreign(self, state: EnvState) -> Any:
        """Raise what `restore` would raise for this state, and change nothing; return what `take_state` needs."""
        if state.__class__ is not EnvState or state.origin.task != self.task.name:
            raise ParameterError(
                f"got {one_line(state)}", expected=f"what save() of an environment of {self.task.name!r} gave", at="state"
            )
        self._refuse_episode(state)
        ready = self._redraw(state.origin.drawn)
        ready[0].refuse_foreign(state.snapshot)
        return ready, None if state.origin is self._origin else _bit_generator(state.origin.random)

    def take_state(self, state: EnvState, ready: Any) -> None:
        """Go on from a state that `refuse_foreign` has looked at."""
        drawn, random = ready
        self._take(*drawn)
        self.component.restore(state.snapshot)
        self._go_on(state.episode)
        if random is not None:
            if isinstance(self.np_random.bit_generator, np.random.PCG64):
                self.np_random.bit_generator.state = random.state
            else:
                self._np_random = np.random.Generator(random)
            self._origin = state.origin

    def __reduce__(self) -> tuple[Any, ...]:
        """Support pickle and `copy.deepcopy`: the constructor's arguments, where the episode is, and the generators."""
        kept = {name: getattr(self, name) for name in ("_np_random_seed", "spec", "action_space", "observation_space")}
        return _recreate, (self._made_by, *self._made_with, self.save(), self.component.issued_cautions, kept)

    def guarded_copy(self) -> ComponentEnv:
        """Return a copy for `check_task`."""
        return copy.deepcopy(self)

    def branch(
        self, log: str | os.PathLike[str], at: float, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode at an instant of a recorded log: the component goes on from there, the task begins anew.

        Args:
            log: path of a log whose component has this one's parameters.
            at: time of the log [s]; a time between two internal steps is moved to the nearest.
            seed: as for `reset`.
            options: as for `reset`, but for start values.

        Raises:
            ParameterError: the log's component has other parameters, or the time is outside of the log; nothing has changed.
            LogError: it is no log, or cannot be re-run.
        """
        from .state_from_log import snapshot_at

        ready, snapshot = snapshot_at(self.component, self._like, log, at)
        start = set(options or {}) & {variable.name for variable in self.component.variables.values() if variable.state}
        if start:
            raise ParameterError(f"got start values of {', '.join(sorted(start))}, but the log gives the start", at="options")
        super().reset(seed=validate_seed(seed))
        self._start(ready[1], options or {})
        number = int(self.np_random.integers(2**31))
        self._take(*ready)
        self.component.restore(snapshot)
        self._origin = None
        self._begin(number)
        return self.observe()

    # -- what an environment of a domain may do otherwise ---------------------------------------------------------------

    @property
    def draws_component(self) -> bool:
        """Return whether each episode has a component of its own, with parameters that were drawn."""
        return False

    def _draw(self) -> Ready:
        """Return the component and the task of the next episode, and what was drawn for them."""
        return self.component, self.task, {}

    def _redraw(self, drawn: Drawn) -> Ready:
        """Return the component and the task for what was drawn; `ParameterError` where nothing like it is drawn here."""
        if drawn:
            raise ParameterError(
                f"it has {', '.join(sorted(drawn))} drawn", hint="make this environment with that randomise", at="state"
            )
        return self.component, self.task, {}

    def _like(self, recorded: Component) -> Ready:
        """Return what could go on from a log of this component."""
        return self.component, self.task, {}

    def _take(self, component: Component, task: Task, drawn: Drawn) -> None:
        """Go on with another component of the same shape, and its task."""

    def _start(self, task: Task, options: Mapping[str, Any]) -> dict[str, Any]:
        """Start values of an episode; may draw random numbers."""
        return {**task.start(self.np_random), **options}

    def _begin(self, seed: int) -> None:
        """Begin an episode; the component has its start state."""
        self._elapsed, self._running, self.task.counters = 0, True, {}
        self.task.begin(self.component, read_only(self._see()))

    def _episode(self) -> Any:
        """Return what changes in an episode beside the component."""
        return self._elapsed, self._running, counters(self.task)

    def _refuse_episode(self, state: EnvState) -> None:
        if not isinstance(state.episode, tuple):
            raise ParameterError("it was saved by an environment of another kind", at="state")

    def _go_on(self, episode: Any) -> None:
        self._elapsed, self._running, kept = episode
        self.task.counters = dict(kept)

    # -- details ----------------------------------------------------------------------------------------------------

    def _inputs(self, action: npt.ArrayLike) -> dict[str, Any]:
        """Return the inputs that an action stands for: numbers, and arrays in the shapes of their variables."""
        numbers = self._validate_action(action).tolist()
        clipped = [-1.0 if number < -1.0 else 1.0 if number > 1.0 else float(number) for number in numbers]
        inputs: dict[str, Any] = {}
        for one in self._driven:
            if one.element.index:
                inputs.setdefault(one.element.name, np.zeros(one.shape))[one.element.index] = (
                    one.scale * clipped[one.part.start]
                )
            elif one.shape:
                inputs[one.element.name] = one.scale * np.array(clipped[one.part]).reshape(one.shape)
            else:
                inputs[one.element.name] = one.scale * clipped[one.part.start]
        return inputs

    def _validate_action(self, action: npt.ArrayLike) -> npt.NDArray[Any]:
        """Return the action's numbers, finite."""
        count = len(self._entries)
        try:
            given = np.asarray(action)
        except ValueError as error:  # rows of unlike length
            raise ParameterError(f"got {one_line(action)}", expected=f"{count} numbers", at="action") from error
        if given.shape != (count,):
            raise ParameterError(f"got shape {given.shape}", expected=f"shape {(count,)}: {one_line(action)}", at="action")
        if given.dtype.kind not in "fiu":
            raise ParameterError(f"got {one_line(action)}", expected=f"{count} numbers from -1 to 1", at="action")
        for entry, number in zip(self._entries, given.tolist(), strict=True):
            if not math.isfinite(number):
                raise ParameterError(f"got {number} for {entry}", expected="a number from -1 to 1", at="action")
        return given

    def _see(self) -> dict[str, Any]:
        """Return the observed outputs, fresh; scaled, they are in `_scaled` then."""
        seen = {}
        for element, scaled, factor in self._parts:
            value = seen[str(element)] = element.of(self.component.get(element.name))
            np.multiply(value, factor, out=scaled)
        return seen

    def _observation(self) -> Observation:
        np.minimum(self._scaled, self._high, out=self._scaled)
        np.maximum(self._scaled, self._low, out=self._scaled)
        if not self.clock:
            return self._scaled.astype(np.float32)
        return np.append(self._scaled.astype(np.float32), clock_readings(self._elapsed, int(self.deadline), self.clock))

    def observation_rows(self) -> Iterator[ObservationRow]:
        """Yield the parts of an observation, in order."""
        place = 0
        for name, scale in self.task.observations.items():
            element = parse_element(name)
            variable, index = self.component.variables[element.name], element.index
            size = 1 if index else math.prod(variable.shape)
            axes = "" if index or not variable.axes else f" of every {variable.axes[0]}"
            shape = f", {' x '.join(map(str, variable.shape))} numbers" if len(variable.shape) > 1 and not index else ""
            unit = f"{scale:.6g} {variable.unit}".removesuffix(" 1")
            yield ObservationRow(place, place + size - 1, f"`{name}`{axes}{shape}", unit)
            place += size
        yield from self._clock_rows(place)

    def _clock_rows(self, place: int) -> Iterator[ObservationRow]:
        for k in range(1, self.clock + 1):
            at = place + k - 1
            yield ObservationRow(at, at, f"clock: cos({'' if k == 1 else f'{k} '}pi t / T)", "1")

    def _info(self, seen: dict[str, Any]) -> dict[str, Any]:
        info, kept = {"time": self.component.time, **seen}, counters(self.task)
        refuse_taken_names(self.task, kept, info)
        return info | kept

    def _fail(self, error: StepError, total: float) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        self._running = False
        info = self._info(self._see())
        info["step_error"] = str(error)
        return self._observation(), total + self.step_error_reward, True, False, info


def environment_factory(make: Callable[Given, Env]) -> Callable[Given, Env]:
    """Make a function that returns the environment of one task fit for registration, copies and pickle; a decorator.

    Unknown arguments are refused by name, and so are parameters of the component that are given twice: as an argument, and in
    the further ones, a mapping whose name is that of the component. Gymnasium finds the render modes as it does on a class.
    """

    @wraps(make)
    def make_once(*arguments: Given.args, **keywords: Given.kwargs) -> Env:
        env = make(*arguments, **keywords)
        given = {**dict(zip(known_arguments(make) or (), arguments, strict=False)), **keywords}
        _refuse_given_twice(env.component.name, given)
        return env

    made = recreatable(make_once)
    made.metadata = ComponentEnv.metadata  # type: ignore[attr-defined]
    return made


def _refuse_given_twice(component: str, given: Mapping[str, Any]) -> None:
    """Raise `ParameterError` where a parameter of the component is among its further ones and an argument too."""
    further = given.get(component)
    for name, value in further.items() if isinstance(further, Mapping) else ():
        if given.get(name) is not None:
            came = f"got {one_line(value)}, and {name} = {one_line(given[name])} as an argument of the environment"
            raise ParameterError(came, expected="it once", at=(component, str(name)))


def observation_box(limit: float, readings: int, clock: int) -> Any:
    """Return the space of readings that are clipped to +- `limit`, followed by those of a clock."""
    high = np.append(np.full(readings, limit, np.float32), np.ones(clock, np.float32))
    return gymnasium.spaces.Box(-high, high, dtype=np.float32)


def _recreate(
    make: Callable[..., ComponentEnv],
    arguments: Any,
    keywords: Mapping[str, Any],
    state: EnvState,
    issued_cautions: IssuedCautions,
    kept: Mapping[str, Any],
) -> ComponentEnv:
    """Return an environment that was made so, in this state; it says nothing that the first one has said."""
    env = make_again(make, arguments, keywords)
    env.component.share_cautions(issued_cautions)
    env.restore(state)
    for name, value in kept.items():
        setattr(env, name, value)
    return env


def _bit_generator(state: Mapping[str, Any]) -> np.random.BitGenerator:
    try:
        return bit_generator(state)
    except ValueError as error:
        raise ParameterError(f"its random numbers are none: {error}", at="state") from error


def validate_seed(seed: Any) -> int | None:
    """Return a seed as Gymnasium takes it; `ParameterError` where it is neither None nor a whole number from 0."""
    if seed is not None and (isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0):
        raise ParameterError(f"got {one_line(seed)}", expected="a whole number from 0, or None", at="seed")
    return None if seed is None else int(seed)


def _clock(value: Any, deadline: int | None) -> int:
    readings = whole_number("clock", value, 0, _LARGEST_CLOCK)
    if readings and deadline is None:
        raise ParameterError(
            f"got {value}, but there is no deadline that it could tell", hint="give a deadline, or clock=0", at="clock"
        )
    return readings


@dataclass(frozen=True)
class _Driven:
    """An input, or an element of one, that an action drives.

    Attributes:
        element: of the input.
        scale: its value at action 1.
        part: its entries in the action.
        shape: of the whole input.
    """

    element: Element
    scale: float
    part: slice
    shape: tuple[int, ...]


def _refuse_elements_driven_twice(driven: Sequence[_Driven]) -> None:
    named: dict[Element, Element] = {}
    for one in driven:
        place = one.element.counted_from_the_start(one.shape)
        if place in named:
            came = "twice" if named[place] == one.element else f"and {named[place]}, which are the same element"
            raise ParameterError(f"got {one.element} {came}", expected="each element once", at="actions")
        named[place] = one.element
    for element in named:
        if element.index and Element(element.name) in named:
            raise ParameterError(
                f"{element.name} is driven as a whole and by elements", hint="give one or the other", at="actions"
            )


def element_scales(what: str, scales: Mapping[str, float], component: Component, causality: str) -> list[tuple[Element, float]]:
    """Return a task's actions or observations with their scales; `ParameterError` where the component has none such."""
    checked = []
    for name, scale in scales.items():
        try:
            element = parse_element(name)
            element.find(component.variables, f"an {causality} of component {component.name!r}", causality)
        except ParameterError as error:
            raise error.within(what, str(name)) from None
        checked.append((element, positive_number((what, name), scale)))
    if not checked:
        raise ParameterError("the task names none", expected=f"at least one {causality}", at=what)
    return checked
