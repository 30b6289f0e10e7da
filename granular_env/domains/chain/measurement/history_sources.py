"""Makes a `History` from a chain and frames of its motion, or from a log."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from granular_env.components.component import Component
from granular_env.components.errors import LogError, ParameterError, one_line
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.validation import whole_number

from .chain_history import History

if TYPE_CHECKING:
    from granular_env.recording import Log
    from granular_env.recording.index import Segment


def make_history(
    component: Component,
    time: FloatArray,
    velocity: FloatArray,
    displacement: FloatArray | None = None,
    overlap: FloatArray | None = None,
    contact_force: FloatArray | None = None,
) -> History:
    """Return the history of a chain from frames; masses, contacts and positions are taken from the chain.

    Args:
        component: the chain.
        time: shape (T,) [s].
        velocity: shape (T, n) [m/s].
        displacement: shape (T, n) [m].
        overlap: overlap of each contact, as output by the chain, shape (T, n + 1) [m].
        contact_force: force in each contact, as output by the chain, shape (T, n + 1) [N].
    """
    chain = chain_geometry(component)
    parameters: Any = component.parameters
    piston = np.zeros(parameters.grains, dtype=bool)
    piston[0], piston[-1] = piston[0] or parameters.left == "piston", piston[-1] or parameters.right == "piston"

    return History(
        time, velocity, chain.mass, chain.stiffness, chain.rest_overlap, chain.position, displacement, piston,
        overlap, contact_force, parameters.law, chain.law_constants,
    )  # fmt: skip


def chain_geometry(component: Component) -> Any:
    """Return the `Geometry` of a chain; `ParameterError` for any other component."""
    if component.name != "chain":
        raise ParameterError(f"got a {component.name!r}", expected="a chain", hint="no other is supported", at="component")
    return component.geometry  # type: ignore[attr-defined]


def history(log: Log, segment: int | None = None) -> History:
    """Return the history recorded in a log of a chain; masses, contacts and positions follow from the parameters in the log.

    Args:
        log: log opened by `ge.open_log`.
        segment: number of the run, from 0; resets and restores during recording divide a log into several runs.

    Raises:
        ParameterError: `log` is not a log.
        LogError: not a log of a chain, velocity not recorded, or a log with several runs and no `segment`.
    """
    if isinstance(log, Component):
        raise ParameterError("got a running chain", expected="a log", hint="use measurement.observe", at="log")
    if not hasattr(log, "new_component"):
        raise ParameterError(f"got {one_line(log)}", expected="a log opened by granular_env.open_log", at="log")
    component = log.new_component() if log.metadata["component"] == "chain" else None
    if component is None:
        raise LogError(
            f"log {str(log.path)!r} is of {log.metadata['component']!r}", expected="a chain", hint="no other is supported"
        )
    if "velocity" not in log.variables:
        raise LogError(
            f"velocity was not recorded (recorded: {', '.join(log.variables) or 'none'})",
            hint="record with variables=['velocity', 'displacement']",
            source=f"log {str(log.path)!r}",
        )
    own = _find_segment(log, segment)
    time, velocity = log.series("velocity", own)
    if not len(time):
        raise LogError(f"log {str(log.path)!r} contains no frame of velocity", hint="record with every=, and call step")
    frames = {}
    for name in ("displacement" if "displacement" in log.variables else "overlap", "contact_force"):
        if name in log.variables:
            times, frames[name] = log.series(name, own)
            if not np.array_equal(times, time):
                raise LogError(
                    "recorded at different times than velocity",
                    hint="record both at the same times",
                    at=("frames", name),
                    source=f"log {str(log.path)!r}",
                )
    return make_history(component, time, velocity, **frames)


def _find_segment(log: Log, number: int | None) -> Segment | None:
    segments = log.segments
    if number is not None:
        return segments[whole_number("segment", number, 0, len(segments) - 1)]
    if len(segments) > 1:
        raise LogError(
            f"log {str(log.path)!r} contains {len(segments)} runs, separated by resets or restores",
            hint=f"select one with segment = 0 to {len(segments) - 1}",
        )
    return segments[0] if segments else None
