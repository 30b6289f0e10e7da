"""Registered environments as text and as facts: for `granular-env describe`."""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np

from granular_env.domains import environments, load
from granular_env.envs.environment import ComponentEnv
from granular_env.envs.task import RowTask
from granular_env.terminal_text import columns, wrap_text


def describe_environment(name: str, arguments: Mapping[str, Any]) -> str:
    """Describe an environment: what its docstring says, its spaces, and its arguments with their defaults.

    Args:
        name: under which it is registered.
        arguments: those that differ from the defaults; spaces may depend on them.
    """
    env, facts, registered = _make(name, arguments), environment_facts(name, arguments), environments()[name]
    rows = [
        ("component", facts["component"]),
        ("action space", str(env.action_space)),
        ("observation space", _box(env.observation_space)),
        ("control step", f"{facts['control_step']:.6g} s: {facts['internal_steps']} internal steps"),
        ("deadline", "none" if facts["deadline"] is None else f"{facts['deadline']} control steps"),
        ("reward threshold", f"{facts['reward_threshold']:g}"),
        ("make_vec", "native batch" if facts["native_batch"] else "no native batch: Gymnasium's SyncVectorEnv"),
    ]
    title, _, rest = (inspect.getdoc(load(registered.entry_point)) or "").partition("\n")
    parts = [wrap_text(f"environment {name}: {title}"), "", columns(rows)]
    parts += ["", "actions, for an entry of 1", columns(_actions(env))]
    parts += ["", "arguments (gymnasium.make, --set)", columns((key, str(value)) for key, value in facts["arguments"].items())]
    return "\n".join([*parts, "", _plain_sections(rest)]).rstrip()


def environment_facts(name: str, arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Return the same as JSON values, for programs."""
    env, registered = _make(name, arguments), environments()[name]
    return {
        "name": name,
        "description": (inspect.getdoc(load(registered.entry_point)) or "").partition("\n")[0],
        "component": env.component.name,
        "actions": {entry: scale for entry, scale in _actions(env)},
        "action_size": env.action_space.shape[0],
        "observation_size": env.observation_space.shape[0],
        "control_step": env.duration,
        "internal_steps": env.internal_steps,
        "deadline": None if env.deadline == np.inf else int(env.deadline),
        "reward_threshold": registered.reward_threshold,
        "native_batch": isinstance(env.task, RowTask),
        "arguments": _arguments(load(registered.entry_point)),
    }


def _make(name: str, arguments: Mapping[str, Any]) -> Any:
    env = gymnasium.make(name, disable_env_checker=True, **arguments).unwrapped
    assert isinstance(env, ComponentEnv)
    return env


def _actions(env: ComponentEnv) -> list[tuple[str, str]]:
    """Return each input that is driven, with what an entry of 1 stands for."""
    rows = []
    for one in env.actuator.driven:
        entries = one.part.stop - one.part.start
        size = "" if entries == 1 else f" each, {entries} entries"
        rows.append((str(one.element), f"{one.scale:g} {env.component.variables[one.element.name].unit}{size}"))
    return rows


def _arguments(make: Any) -> dict[str, str]:
    """Return the arguments of a factory by name, with their defaults as Python writes them."""
    parameters = inspect.signature(make).parameters.values()
    named = {one.name: repr(one.default) for one in parameters if one.kind is not one.VAR_KEYWORD}
    options = any(one.kind is one.VAR_KEYWORD for one in parameters)
    return named | ({"...": "options of the environment, see Arguments below"} if options else {})


def _box(space: gymnasium.spaces.Space[Any]) -> str:
    assert isinstance(space, gymnasium.spaces.Box)
    low, high = (np.unique(bound) for bound in (space.low, space.high))
    limits = f"{low[0]:g}, {high[0]:g}" if len(low) == len(high) == 1 else f"from {low[0]:g} to {high[-1]:g}"
    return f"Box({limits}, {space.shape}, {space.dtype})"


def _plain_sections(docstring: str) -> str:
    """Return the rest of a docstring with its headings as lines of their own, without Markdown."""
    return re.sub(r"^#+ +", "", docstring.strip("\n"), flags=re.MULTILINE)
