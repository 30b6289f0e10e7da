"""The scene of a log, or of a component while it runs."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from granular_env.components.component import Component
from granular_env.components.drawables import Cells, Drawable, Links, Points, spatial
from granular_env.components.drawables import Curve as DrawnCurve
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.variables import Variable
from granular_env.domains import domain_of
from granular_env.recording.header import BalanceNames, balance_facts, balance_names_from

from .curves import MAXIMUM_CURVE_POINTS, Curve, load_input, present_input
from .domain_views import views_class
from .recorded_fields import (
    coloured_drawables,
    curve_names,
    curves_of,
    cuts_of,
    evenly_picked,
    has_frames,
    recorded_outputs,
    sample_frames,
    validity_of,
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
from .visible_drawables import colour_name, is_hidden, is_plane, visible_cells, visible_points


class Frames(NamedTuple):
    """Instants at which outputs are read.

    Attributes:
        times: shape (frames,) [s].
        ticks: shape (frames,).
        cuts: indices of the first frames of later segments.
        read: returns an output at these instants, shape (frames, *shape).
    """

    times: FloatArray
    ticks: npt.NDArray[np.int64]
    cuts: npt.NDArray[np.int64]
    read: Callable[[str], FloatArray]


@dataclass(frozen=True)
class LogSource:
    """A log whose frames are shown, at most so many of them."""

    log: Any
    drawables: Sequence[Drawable]
    most: int

    @property
    def component(self) -> str:
        """The name of the component."""
        return str(self.log.metadata.get("component"))

    @property
    def variables(self) -> Mapping[str, Variable]:
        """The variables of the log."""
        return self.log.variables

    def has(self, name: str) -> bool:
        """Return whether an output can be read."""
        return has_frames(self.log, name)

    def frames(self, name: str, size: int) -> Frames:
        """Return frames of an output, so few that `size` numbers of each are a bounded amount."""
        log = self.log
        picked = evenly_picked(len(log.times(name)), max(2, min(self.most, MAXIMUM_POINTS // size)))
        times, ticks = np.asarray(log.times(name), dtype=np.float64)[picked], np.asarray(log.ticks(name))[picked]
        return Frames(times, ticks, cuts_of(log, name, picked), lambda name: sample_frames(log, name, picked)[1])


@dataclass(frozen=True)
class PresentSource:
    """A component of which the present state is shown."""

    running: Component
    drawables: Sequence[Drawable]

    @property
    def component(self) -> str:
        """The name of the component."""
        return self.running.name

    @property
    def variables(self) -> Mapping[str, Variable]:
        """The variables of the component."""
        return self.running.variables

    def has(self, name: str) -> bool:
        """Return whether an output can be read."""
        return name in self.running.variables

    def frames(self, name: str, size: int) -> Frames:
        """Return the present instant."""
        times, ticks = np.array([self.running.time]), np.array([self.running.tick], dtype=np.int64)
        return Frames(times, ticks, np.zeros(0, np.int64), lambda name: np.asarray(self.running.get(name))[None])


Source = LogSource | PresentSource


def from_log(
    log: Any, frames: int = MAXIMUM_FRAMES, progress: Callable[[float], None] | None = None, colour: str | None = None
) -> SceneData:
    """Return at most `frames` frames of a log and all its scalar outputs and its inputs, thinned.

    Args:
        log: an open log.
        frames: how many there are at most.
        progress: told the part that is done, 0 to 1.
        colour: a recorded output that colours what it can; default: what the component names.
    """
    source = LogSource(log, coloured_drawables(log, colour), frames)
    motions, meshes = _motions(source), _meshes(source)
    if progress is not None:
        progress(0.5)
    outputs = {name: variable for name, variable in log.variables.items() if variable.causality == "output"}
    vectors = {name for balance in log.balances for name in (*balance.entries, balance.residual)}
    shown = [name for name in outputs if (outputs[name].shape in ((), (1,)) or name in vectors) and source.has(name)]
    acted = [one for name in log.input_variables if (one := load_input(log, name)) is not None]
    profiles = (
        one for one in log.drawables if isinstance(one, DrawnCurve) and len(one.coordinate) > 1 and source.has(one.field)
    )
    until, invalid = validity_of(log)
    scene_data = SceneData(
        title_of(log),
        motions,
        meshes,
        curves={curve.name: curve for name in shown for curve in curves_of(log, name)},
        inputs={curve.name: curve for one in acted for curve in one.curves},
        notes=(
            *_notes(log, motions, meshes),
            *_notes_on_colours(log, source.drawables, {one.name for one in (*motions, *meshes)}),
        ),
        balances=_balances_to_show(log.balances, log.variables),
        profiles=tuple(_profile(source, one) for one in profiles),
        remark=f"{remark_of(log.metadata.get('component'), log.metadata.get('parameters'))} {invalid}".strip(),
        conclusions=tuple(log.metadata["conclusions"]),
        focus_normal=focus_normal(log, source.drawables),
        valid_until=until,
    )
    if progress is not None:
        progress(1.0)
    return scene_data


def from_component(component: Component, title: str | None = None) -> SceneData:
    """Return one frame: the present state of a component."""
    now, tick = np.array([component.time]), np.array([component.tick], dtype=np.int64)

    def curves(variable: Variable) -> Iterator[Curve]:
        values = np.ravel(component.get(variable.name)).astype(np.float64)
        for name, value in zip(curve_names(variable), values, strict=True):
            yield Curve(name, variable.unit, variable.description, now, tick, np.array([value]))

    scalars = [v for v in component.variables.values() if v.shape in ((), (1,)) or v.name in component.balance_names]
    given = (variable for variable in component.variables.values() if variable.causality == "input")
    inputs = [curve for one in given for curve in present_input(one, component.get(one.name), component.time, component.tick)]
    balances = balance_names_from([balance_facts(balance) for balance in component.balances()])
    source = PresentSource(component, component.drawables())
    return SceneData(
        title or component.name,
        _motions(source),
        _meshes(source),
        curves={curve.name: curve for variable in scalars if variable.causality == "output" for curve in curves(variable)},
        inputs={curve.name: curve for curve in inputs},
        balances=_balances_to_show(balances, component.variables),
        remark=remark_of(component.name, component.parameters.model_dump()),
    )


def remark_of(component: Any, parameters: Any) -> str:
    """Return what the domain of a component says beside pictures of it; "" where it says nothing."""
    remark = domain_of(str(component)).load("remark")
    return "" if remark is None or not isinstance(parameters, Mapping) else str(remark(parameters))


def title_of(log: Any) -> str:
    """Return the experiment's name; of a log that a script recorded, the file's name and the component's."""
    experiment = log.metadata.get("experiment")
    named = experiment.get("name") if isinstance(experiment, dict) else None
    # A file's name may hold bytes that are no text.
    stem = Path(str(log.path)).stem.encode("utf-8", "replace").decode()
    return str(named or f"{stem} ({log.metadata.get('component') or 'run'})")


def _balances_to_show(balances: Iterable[BalanceNames], variables: Mapping[str, Variable]) -> tuple[BalanceNames, ...]:
    """Return the balances with the names of vectors' curves in the place of the vectors' own."""

    def split(names: Iterable[str]) -> tuple[str, ...]:
        return tuple(part for name in names if name in variables for part in curve_names(variables[name]))

    return tuple(replace(one, stored=split(one.stored), lost=split(one.lost), supplied=split(one.supplied)) for one in balances)


# -- what is drawn in space -------------------------------------------------------------------------------------------------


def _motions(source: Source) -> tuple[Motion, ...]:
    """Return the particles that are drawn, as far as anything of them can be read."""
    return tuple(motion for points in visible_points(source.drawables) if (motion := _motion(source, points)) is not None)


def _motion(source: Source, points: Points) -> Motion | None:
    # Without displacements or positions, what colours the particles still says when and what.
    moved = next((name for name in (points.displacement, "position") if source.has(name)), None)
    clock = moved or (points.colour if source.has(points.colour) else None)
    if clock is None:
        return None
    particles = replace(points, reference=spatial(points.reference))
    every = -(-len(particles.radius) // MAXIMUM_SHOWN_PARTICLES)
    shown = slice(None, None, every)
    joined = _links_to_show(source.drawables, particles, source.has) if every == 1 else []
    frames = source.frames(clock, max([len(particles.radius[shown]), *(len(one.pairs) for one in joined)]))
    displacement = np.zeros((len(frames.times), len(particles.radius), 3))
    if moved is not None:
        values = frames.read(moved)
        displacement = _as_vectors(values)
        if moved != points.displacement:
            displacement -= particles.reference if values.ndim == 3 else particles.reference * [1.0, 0.0, 0.0]

    def read(name: str) -> FloatArray | None:
        return frames.read(name) if source.has(name) else None

    colour = read(points.colour)
    contacts = (None, "", "")
    if every == 1:
        contacts = views_class(source.component).contacts(particles, displacement if moved else None, read)
    return Motion(
        frames.times, frames.ticks, particles.reference[shown], particles.radius[shown], displacement[:, shown],
        None if colour is None else colour[:, shown], _variable(source, points.colour), *contacts,
        every, len(particles.radius), moved is not None, frames.cuts,
        is_plane(particles.reference, source.variables.get(points.displacement)),
        tuple(_link_frames(points, one, frames.read(one.state)) for one in joined),
        points.name, read(points.rotation) if every == 1 else None,
    )  # fmt: skip


def _link_frames(points: Points, links: Links, state: FloatArray) -> LinkFrames:
    """Return links that are drawn: not those from one side of a periodic body to the other."""
    inside = points.stays_inside(links.pairs)
    return LinkFrames(links.name, links.pairs[inside], state[:, inside], links.state)


def _links_to_show(drawables: Iterable[Drawable], points: Points, is_known: Callable[[str], bool]) -> list[Links]:
    """Return the links between these points, so few that they can be drawn, whose state is known."""
    links = (one for one in drawables if isinstance(one, Links) and one.points == points.name and len(one.pairs))
    return [one for one in links if len(one.pairs) <= MAXIMUM_SHOWN_LINKS and is_known(one.state)]


def _meshes(source: Source) -> tuple[MeshFrames, ...]:
    """Return the cells that are drawn, as far as anything of them can be read and they are not too many."""
    return tuple(mesh for cells in visible_cells(source.drawables) if (mesh := _mesh(source, cells)) is not None)


def _mesh(source: Source, cells: Cells) -> MeshFrames | None:
    clock = next((name for name in (cells.displacement, cells.field) if source.has(name)), None)
    count = len(cells.nodes)
    if clock is None or count > MAXIMUM_SHOWN_NODES:
        return None
    frames, located = source.frames(clock, count), source.has(cells.displacement)
    displacement = _as_vectors(frames.read(cells.displacement)) if located else np.zeros((len(frames.times), count, 3))
    nodes = spatial(cells.nodes)
    return MeshFrames(
        cells.name, frames.times, frames.ticks, nodes, cells.connectivity, displacement,
        frames.read(cells.field) if source.has(cells.field) else None, _variable(source, cells.field),
        located, is_plane(nodes, source.variables.get(cells.displacement)), not cells.displacement,
        frames.read(cells.state) != 0.0 if source.has(cells.state) else None,
    )  # fmt: skip


def _profile(source: LogSource, curve: DrawnCurve) -> ProfileFrames:
    every = -(-len(curve.coordinate) // MAXIMUM_CURVE_POINTS)
    x = curve.coordinate[::every]
    frames = source.frames(curve.field, len(x))
    values = frames.read(curve.field)[:, ::every]
    return ProfileFrames(curve.name, frames.times, frames.ticks, x, values, source.variables[curve.field])


def _variable(source: Source, name: str) -> Variable:
    return source.variables.get(name) or Variable(name, "output", "", (), name)


def _as_vectors(moved: FloatArray) -> FloatArray:
    """Displacements along x, shape (frames, n), as vectors (frames, n, 3); vectors as a copy."""
    return spatial(moved if moved.ndim == 3 else moved[..., np.newaxis])


# -- notes ------------------------------------------------------------------------------------------------------------------


def _notes(log: Any, motions: Sequence[Motion], meshes: Sequence[MeshFrames]) -> Iterable[str]:
    motion = motions[0] if motions else None
    if not log.complete:
        yield "The log is incomplete: the run was interrupted, what was written until then is shown."
    if motion is None and visible_points(log.drawables):
        yield "The motion of the particles was not recorded; record displacement or position to see them."
    if motion is not None and not motion.located:
        yield "Displacements were not recorded: the particles are drawn at their positions at the start."
    # Where nothing can happen, no link breaks.
    if motion is not None and log.event_kinds:
        yield from _notes_on_links(log, motion)
    if motion is not None and motion.every > 1:
        yield f"Only each {motion.every}th of {motion.total} particles is shown."
    for cells in visible_cells(log.drawables):
        if not any(mesh.name == cells.name for mesh in meshes):
            missing = f"neither {cells.displacement} nor {cells.field} was recorded"
            yield f"The {cells.name} is not drawn: {missing}, or it is too large."
        if cells.state and not has_frames(log, cells.state):
            yield f"{cells.state} was not recorded: cracks of the {cells.name} are not seen. Record it as well."
    for mesh in meshes:
        if not mesh.located and not mesh.is_fixed:
            yield f"The {mesh.name} is drawn as it was at the start: its displacements were not recorded."


def _notes_on_colours(log: Any, drawn: Sequence[Drawable], shown: Container[str]) -> Iterator[str]:
    """Yield a sentence for each of the drawables shown whose own output was not recorded: what colours it, or what was."""
    recorded = recorded_outputs(log)
    balanced = {name for balance in log.balances for name in (*balance.entries, balance.residual)}
    arrays = ", ".join(name for name, one in recorded.items() if one.shape and name not in balanced) or "none"
    for own, now in zip(log.drawables, drawn, strict=True):
        missing, colour = colour_name(own), colour_name(now)
        if not missing or missing in recorded or own.name not in shown or is_hidden(own, log.drawables):
            continue
        if colour in recorded:
            yield f"{missing} was not recorded: {colour} colours the {own.name}."
        else:
            yield f"{missing} was not recorded: nothing colours the {own.name}. The recorded arrays are {arrays}."


def _notes_on_links(log: Any, motion: Motion) -> Iterator[str]:
    for one in log.drawables:
        if not isinstance(one, Links) or not one.state or not len(one.pairs) or is_hidden(one, log.drawables):
            continue
        if not has_frames(log, one.state):
            yield f"{one.state} was not recorded: the {one.name} are not shown. Record it as well."
        elif len(one.pairs) > MAXIMUM_SHOWN_LINKS:
            yield f"The {one.name} are not shown: there are {len(one.pairs)}, more than {MAXIMUM_SHOWN_LINKS}."
        elif one.points == motion.name and motion.every > 1:
            yield f"The {one.name} are not shown, since not all {motion.name} are."
