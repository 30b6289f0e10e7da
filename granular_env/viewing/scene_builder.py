"""Building of the scene data (shapes and curves to be drawn) of a log or of a running component."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from granular_env.components.component import Component
from granular_env.components.drawables import Cells, Drawable, Links, Points, to_three_columns
from granular_env.components.drawables import Curve as DrawnCurve
from granular_env.components.errors import ParameterError
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.variables import Variable
from granular_env.domains import find_domain
from granular_env.recording.header import BalanceNames, balance_facts, parse_balance_names
from granular_env.recording.preview.visible_drawables import colour_name, is_hidden, is_plane, visible_cells, visible_points

from .curves import MAXIMUM_CURVE_POINTS, Curve, load_input_curves, present_input_curves
from .recorded_fields import (
    coloured_drawables,
    curve_names,
    load_curves,
    nearest_frame,
    pick_evenly,
    recorded_outputs,
    segment_starts,
    validity_limit,
)
from .scene_data import (
    MAXIMUM_FRAMES,
    MAXIMUM_POINTS,
    MAXIMUM_SHOWN_LINKS,
    MAXIMUM_SHOWN_NODES,
    MAXIMUM_SHOWN_PARTICLES,
    LinkFrames,
    MeshFrames,
    Motion,
    ProfileFrames,
    SceneData,
)
from .viewpoint import focus_normal


class Frames(NamedTuple):
    """Times [s] and ticks, shape (frames,), first frames of later segments, and a function that reads an output at them."""

    times: FloatArray
    ticks: npt.NDArray[np.int64]
    cuts: npt.NDArray[np.int64]
    read: Callable[[str], FloatArray]


class SceneSource(NamedTuple):
    """The source of a scene's data: a log, or the present state of a component.

    `has` returns whether an output can be read, `frames` its frames; a larger size (numbers per frame) gives fewer frames.
    """

    component: str
    variables: Mapping[str, Variable]
    drawables: Sequence[Drawable]
    has: Callable[[str], bool]
    frames: Callable[[str, int], Frames]


def _log_source(log: Any, colour: str | None, pick: Callable[[FloatArray, int], npt.NDArray[np.int64]]) -> SceneSource:
    """Return a log as a source; `pick` chooses frames, given the times of all [s] and the count of numbers per frame."""

    def frames(name: str, size: int) -> Frames:
        times = log.times(name)
        picked = pick(times, size)
        cuts = segment_starts(log, name, picked)
        return Frames(times[picked], log.ticks(name)[picked], cuts, lambda name: log.frames_at(name, picked))

    component, recorded = str(log.metadata.get("component")), recorded_outputs(log)
    return SceneSource(component, log.variables, coloured_drawables(log, colour), recorded.__contains__, frames)


def _present_source(component: Component, times: FloatArray, ticks: npt.NDArray[np.int64]) -> SceneSource:
    """Return the present state of a component as a source with one frame."""
    now = Frames(times, ticks, np.zeros(0, np.int64), lambda name: np.asarray(component.get(name))[None])
    known = component.variables
    return SceneSource(component.name, known, component.drawables(), known.__contains__, lambda name, size: now)


def require_log(log: Any) -> None:
    """Raise `ParameterError` for anything but an open log."""
    if not hasattr(log, "metadata") or not hasattr(log, "variables"):
        raise ParameterError(f"got {type(log).__name__}", expected="an open log: open_log(path)", at="log")


def load_scene(log: Any, frames: int = MAXIMUM_FRAMES, colour: str | None = None) -> SceneData:
    """Return a log's scene data: at most `frames` frames of shapes (coloured by `colour`), and thinned scalars and inputs."""
    source = _log_source(log, colour, lambda clock, size: pick_evenly(len(clock), max(2, min(frames, MAXIMUM_POINTS // size))))
    outputs = recorded_outputs(log)
    vectors = {name for balance in log.balances for name in (*balance.entries, balance.residual)}
    shown = [name for name, one in outputs.items() if one.shape in ((), (1,)) or name in vectors]
    acted = [one for name in log.input_variables if (one := load_input_curves(log, name)) is not None]
    until, invalid = validity_limit(log)
    scene_data = SceneData(
        log_title(log),
        *_read_shapes(source),
        curves={curve.name: curve for name in shown for curve in load_curves(log, name)},
        inputs={curve.name: curve for one in acted for curve in one.curves},
        balances=_balances_to_show(log.balances, log.variables),
        profiles=tuple(_read_profiles(source)),
        remark=f"{picture_remark(source.component, log.metadata.get('parameters'))} {invalid}".strip(),
        conclusions=tuple(log.metadata["conclusions"]),
        focus_normal=focus_normal(log, source.drawables),
        valid_until=until,
    )
    return replace(scene_data, notes=(*_scene_notes(log, scene_data), *_colour_notes(log, source.drawables, scene_data)))


def load_shapes(log: Any, times: Sequence[float], colour: str | None = None) -> SceneData:
    """Return the scene data of a log without scalars: its shapes and profiles in the frames nearest to given times [s].

    Raises:
        ParameterError: a time outside the recorded span, or an output `colour` that can colour no shape.
    """
    source = _log_source(log, colour, lambda clock, size: np.unique([nearest_frame(clock, time) for time in times]))
    focus, until = focus_normal(log, source.drawables), validity_limit(log)[0]
    profiles = tuple(_read_profiles(source))
    return SceneData(log_title(log), *_read_shapes(source), profiles=profiles, focus_normal=focus, valid_until=until)


def make_scene(component: Component, title: str | None = None, earlier: int = 0) -> SceneData:
    """Return the scene data of a component's present state (one frame), with `earlier` ticks before its last reset."""
    tick, time = component.tick + earlier, component.time + earlier * component.step_size
    now, ticks = np.array([time]), np.array([tick], dtype=np.int64)

    def curves(variable: Variable) -> Iterator[Curve]:
        values = np.ravel(component.get(variable.name)).astype(np.float64)
        for name, value in zip(curve_names(variable), values, strict=True):
            yield Curve(name, variable.unit, variable.description, now, ticks, np.array([value]))

    variables, source = component.variables.values(), _present_source(component, now, ticks)
    outputs = [one for one in variables if one.causality == "output"]
    scalars = [one for one in outputs if one.shape in ((), (1,)) or one.name in component.balance_names]
    given = (one for one in variables if one.causality == "input")
    inputs = [curve for one in given for curve in present_input_curves(one, component.get(one.name), time, tick)]
    balances = parse_balance_names([balance_facts(balance) for balance in component.balances()])
    return SceneData(
        title or component.name,
        *_read_shapes(source),
        curves={curve.name: curve for variable in scalars for curve in curves(variable)},
        inputs={curve.name: curve for curve in inputs},
        balances=_balances_to_show(balances, component.variables),
        remark=picture_remark(component.name, component.parameters.model_dump()),
    )


def picture_remark(component: Any, parameters: Any) -> str:
    """Return the remark that the domain of a component adds to its pictures; "" for none."""
    remark = find_domain(str(component)).load_attribute("remark")
    return "" if remark is None or not isinstance(parameters, Mapping) else str(remark(parameters))


def log_title(log: Any) -> str:
    """Return the experiment's name or, for a log recorded by a script, the names of the file and the component."""
    experiment = log.metadata.get("experiment")
    named = experiment.get("name") if isinstance(experiment, dict) else None
    # A file name may contain undecodable bytes.
    stem = Path(str(log.path)).stem.encode("utf-8", "replace").decode()
    return str(named or f"{stem} ({log.metadata.get('component') or 'run'})")


def _balances_to_show(balances: Iterable[BalanceNames], variables: Mapping[str, Variable]) -> tuple[BalanceNames, ...]:
    """Return the balances to plot; the name of a vector is replaced by the names of its components' curves."""

    def split_vectors(names: Iterable[str]) -> tuple[str, ...]:
        return tuple(part for name in names if name in variables for part in curve_names(variables[name]))

    return tuple(
        replace(one, stored=split_vectors(one.stored), lost=split_vectors(one.lost), supplied=split_vectors(one.supplied))
        for one in balances
    )


def _read_shapes(source: SceneSource) -> tuple[tuple[Motion, ...], tuple[MeshFrames, ...]]:
    """Return the particles and cells for which an output can be read."""
    motions = (_read_motion(source, points) for points in visible_points(source.drawables))
    meshes = (_read_mesh(source, cells) for cells in visible_cells(source.drawables))
    return tuple(filter(None, motions)), tuple(filter(None, meshes))


def _read_motion(source: SceneSource, points: Points) -> Motion | None:
    # If the displacements were not recorded, use the times at which the output that colours the particles was recorded.
    clock = next((name for name in (points.displacement, points.colour) if source.has(name)), None)
    if clock is None:
        return None
    particles = replace(points, reference=to_three_columns(points.reference))
    total = len(particles.radius)
    every = -(-total // MAXIMUM_SHOWN_PARTICLES)
    shown = slice(None, None, every)
    links = (one for one in source.drawables if isinstance(one, Links) and one.points == points.name and every == 1)
    joined = [one for one in links if 0 < len(one.pairs) <= MAXIMUM_SHOWN_LINKS and source.has(one.state)]
    frames = source.frames(clock, max([-(-total // every), *(len(one.pairs) for one in joined)]))

    def read(name: str) -> FloatArray | None:
        return frames.read(name) if source.has(name) else None

    def link_frames(one: Links) -> LinkFrames:
        inside = points.is_unwrapped(one.pairs)  # without links across a periodic boundary
        return LinkFrames(one.name, one.pairs[inside], frames.read(one.state)[:, inside])

    moved, displacement = _read_displacement(source, frames, points.displacement, total)
    colour = read(points.colour)
    contacts: tuple[FloatArray | None, str, str] = None, "", ""
    if every == 1 and (contact_quantity := find_domain(source.component).load_attribute("contacts")) is not None:
        contacts = contact_quantity(particles, moved, read)
    return Motion(
        frames.times, frames.ticks, particles.reference[shown], particles.radius[shown], displacement[:, shown],
        None if colour is None else colour[:, shown], _find_variable(source, points.colour), *contacts, every, total,
        moved is not None, frames.cuts, is_plane(particles.reference, source.variables.get(points.displacement)),
        tuple(map(link_frames, joined)), points.name, read(points.rotation) if every == 1 else None,
    )  # fmt: skip


def _read_mesh(source: SceneSource, cells: Cells) -> MeshFrames | None:
    clock = next((name for name in (cells.displacement, cells.field) if source.has(name)), None)
    count = len(cells.nodes)
    if clock is None or count > MAXIMUM_SHOWN_NODES:
        return None
    frames = source.frames(clock, count)
    moved, displacement = _read_displacement(source, frames, cells.displacement, count)
    nodes = to_three_columns(cells.nodes)
    return MeshFrames(
        cells.name, frames.times, frames.ticks, nodes, cells.connectivity, displacement,
        frames.read(cells.field) if source.has(cells.field) else None, _find_variable(source, cells.field),
        moved is not None, is_plane(nodes, source.variables.get(cells.displacement)), not cells.displacement,
        frames.read(cells.state) != 0.0 if source.has(cells.state) else None,
    )  # fmt: skip


def _read_profiles(source: SceneSource) -> Iterator[ProfileFrames]:
    for curve in source.drawables:
        if isinstance(curve, DrawnCurve) and len(curve.coordinate) > 1 and source.has(curve.field):
            every = -(-len(curve.coordinate) // MAXIMUM_CURVE_POINTS)
            x = curve.coordinate[::every]
            frames = source.frames(curve.field, len(x))
            values = frames.read(curve.field)[:, ::every]
            yield ProfileFrames(curve.name, frames.times, frames.ticks, x, values, source.variables[curve.field])


def _find_variable(source: SceneSource, name: str) -> Variable:
    return source.variables.get(name) or Variable(name, "output", "", (), name)


def _read_displacement(source: SceneSource, frames: Frames, name: str, count: int) -> tuple[FloatArray | None, FloatArray]:
    """Return recorded displacements (None if not recorded), and those to draw (else zeros), shape (frames, n, 3) [m]."""
    moved = to_vectors(frames.read(name)) if source.has(name) else None
    return moved, np.zeros((len(frames.times), count, 3)) if moved is None else moved


def to_vectors(displacement: FloatArray) -> FloatArray:
    """Return displacements, given along x (frames, n) or as vectors, as vectors in space, shape (frames, n, 3)."""
    return to_three_columns(displacement if displacement.ndim == 3 else displacement[..., np.newaxis])


def _scene_notes(log: Any, scene_data: SceneData) -> Iterator[str]:
    motion, recorded = scene_data.motion, recorded_outputs(log)
    if not log.complete:
        yield "The log is incomplete because the run was interrupted; the recorded part is shown."
    if motion is None and visible_points(log.drawables):
        yield "The motion of the particles was not recorded; record displacements to see them."
    if scene_data.unmoved_shapes:
        yield f"Drawn at the initial positions, because no displacements were recorded: {', '.join(scene_data.unmoved_shapes)}."
    if motion is not None and motion.every > 1:
        yield f"Only every {motion.every}th of {motion.total} particles is shown, without links."
    # Without events, no link breaks, so the log needs no note on links.
    for one in log.drawables if motion is not None and log.event_kinds else ():
        if isinstance(one, Links) and one.state and not is_hidden(one, log.drawables):
            if one.state not in recorded:
                yield f"{one.state} was not recorded: the {one.name} are not shown. Record it as well."
            elif len(one.pairs) > MAXIMUM_SHOWN_LINKS:
                yield f"The {one.name} are not shown: there are {len(one.pairs)}, more than {MAXIMUM_SHOWN_LINKS}."
    for cells in visible_cells(log.drawables):
        if not any(mesh.name == cells.name for mesh in scene_data.meshes):
            missing = f"neither {cells.displacement} nor {cells.field} was recorded"
            yield f"The {cells.name} is not drawn: {missing}, or it is too large."
        if cells.state and cells.state not in recorded:
            yield f"{cells.state} was not recorded: cracks of the {cells.name} are not shown. Record it as well."


def _colour_notes(log: Any, drawn: Sequence[Drawable], scene_data: SceneData) -> Iterator[str]:
    """Yield a sentence for each drawable whose colouring output was not recorded: which other one is used, or could be."""
    recorded, shown = recorded_outputs(log), {one.name for one in scene_data.shapes}
    balanced = {name for balance in log.balances for name in (*balance.entries, balance.residual)}
    arrays = ", ".join(name for name, one in recorded.items() if one.shape and name not in balanced) or "none"
    for own, now in zip(log.drawables, drawn, strict=True):
        missing, colour = colour_name(own), colour_name(now)
        if missing and missing not in recorded and own.name in shown and not is_hidden(own, log.drawables):
            if colour in recorded:
                yield f"{missing} was not recorded: {colour} colours the {own.name}."
            else:
                yield f"{missing} was not recorded: nothing colours the {own.name}. The recorded arrays are {arrays}."
