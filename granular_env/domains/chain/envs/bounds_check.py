"""Bounds check of a task's kernels: they run as plain Python on arrays that refuse a wrong index or write."""

from __future__ import annotations

import sys
from collections.abc import Callable
from types import FrameType
from typing import TYPE_CHECKING, Any

import numpy as np

from granular_env.components.chain import layout
from granular_env.components.errors import ParameterError, caution, one_line
from granular_env.components.support.float_arrays import FloatArray
from granular_env.envs.task_check import SlipError, UncheckedError

from .episode_layout import ELAPSED
from .plain_function import plain_function

if TYPE_CHECKING:
    from .environment import ChainEnv


# The rows of the table with a number for each grain or contact.
_GRAIN_ROWS = {
    getattr(layout, name): name
    for name in ("STIFFNESS", "REST_OVERLAP", "INVERSE_MASS", "MASS", "LIMIT", "LAW_CONSTANTS", "DISSIPATED", "U", "V", "PEAK")
}
# Looking at each index of longer chains would take seconds; numpy's own look at the bounds remains.
_LONGEST_LOOKED_AT = 2000
_refused_nothing: set[Any] = set()


def refuse_slips(env: ChainEnv) -> None:
    """Begin an episode and judge two control steps on guarded arrays, unless the task is of this package.

    It is done once for all that a kernel may take an index from: sizes, deadline and constants. A kernel that does not run as
    plain Python is told of by a `GranularWarning`.

    Raises:
        ParameterError: a kernel reads or writes where it must not; names it. Any other fault shows when the task is used.
    """
    task = env.task
    if type(task).__module__.split(".")[0] == __name__.split(".")[0]:
        return
    grains = env.component.parameters.grains
    sizes = (task.counter_names, grains, env.component.table.shape, len(task.goal_scales))
    known = (type(task).begin_kernel, type(task).judge_kernel, sizes, env.control_steps, env.constants.tobytes())
    if known in _refused_nothing:
        return
    try:
        copy = guard_copy(env)
        copy.reset(seed=0)
        for last in (False, True):
            if last and copy.control_steps:
                copy.memory[ELAPSED] = copy.control_steps - 1
            copy.step(np.ones(copy.action_space.shape))
    except SlipError as slip:
        raise ParameterError(str(slip), source=f"task {task.name!r}") from None
    except UncheckedError as error:
        caution(f"task {task.name!r} could not be checked: {error}; call check_task(env)")
    except Exception:  # a start that is not one, a reward that is no number: told where it happens
        return
    _refused_nothing.add(known)


def guard_copy(env: ChainEnv) -> Any:
    """Return an environment like this one whose kernels are plain Python and see guarded arrays."""
    copy: Any = env.copy_into(np.zeros_like(env.component.table), np.zeros_like(env.memory))
    names, grains = env.task.counter_names, env.component.parameters.grains
    counters = f"counter_names declares {len(names)}" + (f" ({', '.join(names)})" if names else "")
    constants = f"the task has {len(env.constants)}"

    def guard(which: str, a: FloatArray, numbers: FloatArray, given: FloatArray) -> tuple[FloatArray, ...]:
        watched = grains if grains <= _LONGEST_LOOKED_AT else None
        return (
            _Guarded.of(a, which, "a", f"the chain has {grains} grains, in the columns 1 to {grains}", grains=watched),
            _Guarded.of(numbers, which, "counters", counters, writable=True),
            _Guarded.of(given, which, "constants", constants),
        )

    begin, judge = (plain_function(_kernel(env, name)) for name in ("begin_kernel", "judge_kernel"))

    def guarded_begin(a: FloatArray, numbers: FloatArray, given: FloatArray) -> None:
        _run(begin, "begin_kernel", *guard("begin_kernel", a, numbers, given))

    def guarded_judge(a: FloatArray, inputs: FloatArray, numbers: FloatArray, given: FloatArray, *rest: Any) -> Any:
        a, numbers, given = guard("judge_kernel", a, numbers, given)
        held = _Guarded.of(inputs, "judge_kernel", "inputs", "there are 2, left and right")
        duration, elapsed, steps = rest  # as numbers of numpy: like compiled ones they divide by 0 without raising
        return _run(judge, "judge_kernel", a, held, numbers, given, np.float64(duration), np.int64(elapsed), np.int64(steps))

    copy.begin_task, copy.judge = guarded_begin, guarded_judge
    return copy


def _kernel(env: ChainEnv, name: str) -> Callable[..., Any]:
    from .task import task_kernel

    return env.component.specialise(task_kernel(env.task, name))


def _run(kernel: Callable[..., Any], name: str, *arguments: Any) -> Any:
    try:
        with np.errstate(all="ignore"):  # compiled code gives inf and NaN without a word
            return kernel(*arguments)
    except IndexError as error:
        raise SlipError(f"{name}: {error}") from None
    except ValueError as error:
        if _writes(kernel, arguments):
            raise SlipError(f"{name}: it writes into an array that is not its own; it may write into counters alone") from None
        raise _wrap_error(name, error) from error
    except SlipError:
        raise
    except Exception as error:  # whatever compiled code can do and plain Python cannot
        raise _wrap_error(name, error) from error


def _writes(kernel: Callable[..., Any], arguments: tuple[Any, ...]) -> bool:
    """Return whether a kernel changes arrays that it only may read, where they are copies that it can write to."""
    closed = [place for place, one in enumerate(arguments) if isinstance(one, np.ndarray) and not one.flags.writeable]
    copies = [np.array(one) if isinstance(one, np.ndarray) else one for one in arguments]
    try:
        with np.errstate(all="ignore"):
            kernel(*copies)
    except Exception:  # it does not come to writing for another reason
        return False
    return any(copies[place].tobytes() != np.asarray(arguments[place]).tobytes() for place in closed)


def _wrap_error(name: str, error: Exception) -> UncheckedError:
    return UncheckedError(f"{name} does not run as plain Python: {type(error).__name__}: {one_line(str(error))}")


class _Guarded(np.ndarray[Any, Any]):
    """An array that refuses an index out of bounds by its name, and writes where they are not allowed."""

    _kernel: str
    _name = ""
    _has = ""
    _grains: int | None = None

    @classmethod
    def of(
        cls, array: FloatArray, kernel: str, name: str, has: str, *, writable: bool = False, grains: int | None = None
    ) -> Any:
        """Return a guarded view.

        Args:
            array: what is looked at.
            kernel: who looks.
            name: the array's name there.
            has: what there is, for messages.
            writable: whether it may be written to.
            grains: of a chain whose table it is: columns beyond it are refused too.
        """
        view = array.view(cls)
        view._kernel, view._name, view._has, view._grains = kernel, name, has, grains
        view.flags.writeable = writable
        return view

    def __getitem__(self, index: Any) -> Any:
        self._look_at(index)
        try:
            return super().__getitem__(index)
        except IndexError:
            raise self._slip("reads", index) from None

    def __setitem__(self, index: Any, value: Any) -> None:
        if not self.flags.writeable:
            raise self._slip("writes into", index)
        try:
            super().__setitem__(index, value)
        except IndexError:
            raise self._slip("writes into", index) from None
        except ValueError:  # it cannot be broadcast
            raise self._slip(f"writes {np.size(value)} numbers into", index) from None

    def _look_at(self, index: Any) -> None:
        if self._grains is None or not isinstance(index, tuple) or len(index) != 2:
            return
        row, column = index
        if isinstance(column, (int, np.integer)) and row in _GRAIN_ROWS and not 0 <= column <= self._grains + 1:
            if not (row == layout.V and column >= 0 and _is_called_by_package(sys._getframe(2))):
                raise self._slip("reads", index)

    def _slip(self, does: str, index: Any) -> SlipError:
        if not self._name:  # a part of one
            return SlipError(f"a kernel {does} [{index}] of a part of an array, beyond it or where it must not")
        forbidden = does.startswith("writes") and not self.flags.writeable
        why = "it may write into counters alone" if forbidden else self._has
        return SlipError(f"{self._kernel} {does} {self._name}[{_index_text(index)}], but {why}")


def _is_called_by_package(frame: FrameType) -> bool:
    """Return whether code of this package asks: it knows of the tallies behind the chain."""
    return frame.f_globals.get("__name__", "").split(".")[0] == __name__.split(".")[0]


def _index_text(index: Any) -> str:
    """Return an index as one writes it, the row of the table by its name."""
    if not isinstance(index, tuple):
        return _part_text(index)
    row, *rest = index
    named = _GRAIN_ROWS.get(row, row) if isinstance(row, (int, np.integer)) else row
    return ", ".join(map(_part_text, (named, *rest)))


def _part_text(part: Any) -> str:
    if not isinstance(part, slice):
        return str(part)
    ends = [part.start, part.stop] + ([] if part.step is None else [part.step])
    return ":".join("" if end is None else str(end) for end in ends)
