"""Registered environments as text and as data for `granular-env describe`."""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np

from granular_env.components.variables import parse_element
from granular_env.domains import import_object, load_environments
from granular_env.envs.environment import ComponentEnv
from granular_env.envs.factory import Options, options_type
from granular_env.envs.task import RowTask
from granular_env.terminal_text import align_columns, wrap_text


def describe_environment(name: str, arguments: Mapping[str, Any]) -> str:
    """Return the text that describes an environment with these arguments: its properties, its docstring's sections."""
    facts = environment_facts(name, arguments)
    shown = {**facts, "control_step": f"{facts['control_step']:.6g} s"}
    rows = [(key.replace("_", " "), str(value)) for key, value in shown.items() if not isinstance(value, dict)]
    parts = [wrap_text(f"environment {name}: {facts['description']}"), "", align_columns(rows[2:])]
    parts += ["", "inputs at action 1", align_columns(facts["actions"].items())]
    parts += ["", "arguments (gymnasium.make, --set)", align_columns(facts["arguments"].items())]
    make = import_object(load_environments()[name].entry_point)
    sections = [(inspect.getdoc(make) or "").partition("\n")[2].strip("\n")]
    if (shared := options_type(make)) is not Options:
        sections += ["", inspect.getdoc(shared) or ""]
    return "\n".join([*parts, "", re.sub(r"^#+ +", "", "\n".join(sections), flags=re.MULTILINE)]).rstrip()


def environment_facts(name: str, arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Return the properties of an environment as JSON values; `arguments` as for `describe_environment`."""
    env, registered = gymnasium.make(name, disable_env_checker=True, **arguments).unwrapped, load_environments()[name]
    assert isinstance(env, ComponentEnv)
    make, space = import_object(registered.entry_point), env.sensors.space
    return {
        "name": name,
        "description": (inspect.getdoc(make) or "").partition("\n")[0],
        "component": env.component.name,
        "actions": {name: f"{scale:g} {_variable_unit(env, name)}" for name, scale in env.task.actions.items()},
        "action_size": env.actuator.size,
        "observation_size": len(space.low),
        "observation_limits": f"{space.low.min():g} to {space.high.max():g}",
        "control_step": env.duration,
        "internal_steps": env.internal_steps,
        "deadline": None if env.deadline == np.inf else env.deadline,
        "reward_threshold": registered.reward_threshold,
        "native_batch": isinstance(env.task, RowTask),
        "arguments": _factory_arguments(make),
    }


def _variable_unit(env: ComponentEnv, name: str) -> str:
    return env.component.variables[parse_element(name).name].unit


def _factory_arguments(make: Any) -> dict[str, str]:
    """Return the arguments of the function that makes an environment, by name, with their defaults as text."""
    parameters = inspect.signature(make).parameters.values()
    named = {one.name: repr(one.default) for one in parameters if one.kind is not one.VAR_KEYWORD}
    return {**named, "...": "options of every environment, see `help(granular_env.envs.ComponentEnv)`"}
