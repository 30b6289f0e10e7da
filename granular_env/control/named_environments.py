"""Environments by the names that studies call them: ``pulse-forming`` is ``granular_env/PulseForming-v1``.

Besides the shipped ones there are the user's own: ``module:name`` is what makes an environment in a module, and a name that is
registered with Gymnasium (``mine/Task-v0``, or ``module:mine/Task-v0`` to import the module that registers it) is that one.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from granular_env.components.errors import GranularError, ParameterError, nearest, one_line
from granular_env.domains import environments, load

# What a study gives every environment unless a method asks for more; one that does not take it does without.
_DEFAULTS = {"hold": 1, "clock": 0, "info": "brief"}


def task_names() -> dict[str, str]:
    """Return short name -> registered name."""
    return {_short(registered): registered for registered in environments()}


def _short(registered: str) -> str:
    plain = registered.rpartition("/")[2].partition("-v")[0]
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", plain).lower()


def is_shipped(name: str) -> bool:
    """Return whether a name is that of an environment of this package."""
    return name in environments() or name in task_names()


def names_own_code(name: str) -> bool:
    """Return whether a name is ``module:name`` or has the form of one registered with Gymnasium, and is not of this package."""
    return not is_shipped(name) and (":" in name or "/" in name or re.search(r"-v\d+$", name) is not None)


def registered_name(name: str) -> str:
    """Return the registered name behind a short one; any other name as it is."""
    return task_names().get(name, name)


def find_environment(name: str, folder: Path | None = None) -> Callable[..., Any]:
    """Return what makes the single environment of a name; importing code of the user's own where it names some.

    Args:
        name: a short or registered name, ``module:name``, or a name registered with Gymnasium, ``module:`` in front of it.
        folder: where modules are looked for first, as Python does beside a script; None for Python's path alone.

    Raises:
        ParameterError: there is none; names the module, what it has, or the nearest name.
    """
    if is_shipped(name):
        return load(environments()[registered_name(name)].entry_point)
    module, colon, rest = name.partition(":")
    if not colon:
        return _find_registered(name)
    imported = _import_object(name, module, folder)
    return _find_registered(rest) if "/" in rest else _own(name, imported, rest)


def make_environment(make: Callable[..., Any], arguments: Mapping[str, Any], name: str = "name") -> Any:
    """Return the single environment, bare.

    Args:
        make: what makes it.
        arguments: for that.
        name: of the task, for messages.

    Raises:
        ParameterError: it does not take one of the arguments, the nearest is named; what makes it raises something else than an
            error of this package; or it is no environment of a component.
    """
    from granular_env.envs.environment import ComponentEnv
    from granular_env.envs.factory import known_arguments
    from granular_env.envs.task import Task

    known = known_arguments(make)
    given = {key: value for key, value in arguments.items() if known is None or key in known or _DEFAULTS.get(key) != value}
    if known is not None and (unknown := [key for key in given if key not in known]):
        raise ParameterError("unknown", hint=nearest(unknown[0], known), at=unknown[0])
    try:
        made = make(**given)
    except GranularError:
        raise
    except Exception as error:  # whatever the user's own code does
        message = " ".join(str(error).split())
        raise ParameterError(
            f"it ends with {type(error).__name__}{f': {message}' if message else ''}", source=f"task {name}"
        ) from error
    env = getattr(made, "unwrapped", made)
    if isinstance(env, Task):
        raise ParameterError(
            "it makes a task", expected="its environment", hint="name what returns ComponentEnv(component, task)", at="name"
        )
    if not isinstance(env, ComponentEnv):
        raise ParameterError(f"it makes {one_line(made)}", expected="a ComponentEnv", at="name")
    return env


def _import_object(name: str, module: str, folder: Path | None) -> Any:
    if folder is not None and str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
    try:
        return import_module(module)
    except GranularError:
        raise
    except Exception as error:  # whatever the module does while it is imported
        missing = isinstance(error, ModuleNotFoundError) and error.name is not None and module.startswith(error.name)
        where = f"in {folder} and on Python's path" if folder is not None else "on Python's path"
        came = f"there is no module {module!r} {where}" if missing else f"its import ends with {type(error).__name__}: {error}"
        raise ParameterError(f"got {name!r}: {came}", at="name") from error


def _own(name: str, module: Any, path: str) -> Callable[..., Any]:
    found = getattr(module, path, None)
    if found is None:
        public = [known for known, value in vars(module).items() if callable(value) and not known.startswith("_")]
        raise ParameterError(f"got {name!r}: the module has no {path!r}", hint=nearest(path, public), at="name")
    if not callable(found):
        raise ParameterError(f"got {name!r}, which is {one_line(found)}", expected="what makes a ComponentEnv", at="name")
    return found


def _find_registered(name: str) -> Callable[..., Any]:
    from gymnasium.envs.registration import load_env_creator, registry

    spec = registry.get(name)
    if spec is None or spec.entry_point is None:
        own = (id for id, spec in registry.items() if "/" in id and id not in environments() and not _of_gymnasium(spec))
        raise ParameterError(
            f"got {name!r}",
            expected="the name of a task",
            hint=nearest(
                name,
                [*task_names(), *own],
                "one of your own is 'module:name' of what makes its environment, or 'module:id' of one that it registers",
            ),
            at="name",
        )
    entry = spec.entry_point
    creator = load_env_creator(entry) if isinstance(entry, str) else entry
    return partial(creator, **spec.kwargs) if spec.kwargs else creator


def _of_gymnasium(spec: Any) -> bool:
    """Return whether Gymnasium itself registers it: `phys2d/CartPole-v1`, for instance."""
    return str(spec.entry_point or spec.vector_entry_point).startswith("gymnasium.")
