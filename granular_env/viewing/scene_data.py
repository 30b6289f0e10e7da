"""The data of a run for viewers, in arrays of bounded size: the one source of scenes and figures."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.components import drawables
from granular_env.components.component import Component
from granular_env.components.drawables import Cells, Drawable, Links, Points, spatial
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.variables import Variable
from granular_env.domains import domain_of
from granular_env.recording.header import BalanceNames, balance_facts, balance_names_from

from .curves import MAXIMUM_CURVE_POINTS, Curve, pick_with_extremes
from .domain_views import views_class
from .input_curves import load_input, present_input
from .viewpoint import focus_normal, viewpoint
from .visible_drawables import (
    colour_name,
    colouring_outputs,
    is_hidden,
    is_plane,
    is_solid,
    recolour,
    visible_cells,
    visible_points,
    with_colour,
)

# Bounds of what is shown: viewers die of more.
MAXIMUM_FRAMES = 400
MAXIMUM_SHOWN_PARTICLES = 20_000
MAXIMUM_SHOWN_LINKS = 60_000
MAXIMUM_SHOWN_NODES = 500_000
MAXIMUM_POINTS = 1_000_000
# Up to so many numbers a whole series is read at once; beyond, frame by frame.
_READ_AT_ONCE = 50_000_000

_AXES = "xyz"


@dataclass(frozen=True)
class LinkFrames:
    """Links between the particles of a `Motion`, in its frames.

    Attributes:
        name: what they are.
        pairs: indices of the particles, shape (m, 2).
        state: 0 where a pair is not linked, shape (frames, m).
        state_name: of the output that holds it.
    """

    name: str
    pairs: npt.NDArray[np.int64]
    state: FloatArray
    state_name: str


@dataclass(frozen=True)
class Motion:
    """Particles in some frames of a run.

    Attributes:
        times: shape (frames,) [s].
        ticks: shape (frames,).
        reference: positions at rest of the particles shown, shape (n, 3) [m].
        radius: shape (n,) [m].
        displacement: shape (frames, n, 3) [m]; zeros where it was not recorded.
        colour: the variable that colours them, shape (frames, n); None where it was not recorded.
        colour_variable: name, unit and meaning of it.
        contact: what the domain knows of the contacts, never negative, shape (frames, contacts); None where it knows nothing.
        contact_name, contact_unit: what that is.
        every: each `every`-th particle is shown; 1 shows all.
        total: how many particles there are.
        located: whether the displacements were recorded; otherwise the particles stay at their positions at the start.
        cuts: indices of the first frames of later segments.
        is_plane: whether they lie, or can move, in two dimensions; otherwise they are a row along x.
        links: between them; none where particles are left out.
        name: what they are, such as "grains".
        rotation: their angles, shape (frames, n) [rad]; None where they were not recorded.
    """

    times: FloatArray
    ticks: npt.NDArray[np.int64]
    reference: FloatArray
    radius: FloatArray
    displacement: FloatArray
    colour: FloatArray | None
    colour_variable: Variable
    contact: FloatArray | None
    contact_name: str
    contact_unit: str
    every: int = 1
    total: int = 0
    located: bool = True
    cuts: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    is_plane: bool = False
    links: tuple[LinkFrames, ...] = ()
    name: str = "particles"
    rotation: FloatArray | None = None


@dataclass(frozen=True)
class MeshFrames:
    """Cells in some frames of a run.

    Attributes:
        name: what they are, such as "grid".
        times: shape (frames,) [s].
        ticks: shape (frames,).
        nodes: before anything moves, shape (n, 3) [m].
        connectivity: nodes of each cell in order around it, shape (m, k).
        displacement: of the nodes, shape (frames, n, 3) [m]; zeros where it was not recorded.
        field: what colours them, shape (frames, n) or (frames, m); None where it was not recorded.
        field_variable: name, unit and meaning of it.
        located: whether the displacements were recorded.
        is_plane: whether they lie, or can move, in two dimensions.
        is_fixed: whether they never move, so that there are no displacements to record.
        whole: which cells are not broken, shape (frames, m); None where none breaks, or their state was not recorded.
    """

    name: str
    times: FloatArray
    ticks: npt.NDArray[np.int64]
    nodes: FloatArray
    connectivity: npt.NDArray[np.int64]
    displacement: FloatArray
    field: FloatArray | None
    field_variable: Variable
    located: bool
    is_plane: bool
    is_fixed: bool = False
    whole: npt.NDArray[np.bool_] | None = None

    @property
    def is_solid(self) -> bool:
        """True where they are the surface of a body in space."""
        return is_solid(self.nodes)


@dataclass(frozen=True)
class ProfileFrames:
    """A field along a line in some frames of a run.

    Attributes:
        name: of the drawable.
        times: shape (frames,) [s].
        ticks: shape (frames,).
        coordinate: shape (n,) [m].
        values: shape (frames, n), in the variable's unit.
        variable: name, unit and meaning of the field.
    """

    name: str
    times: FloatArray
    ticks: npt.NDArray[np.int64]
    coordinate: FloatArray
    values: FloatArray
    variable: Variable


@dataclass(frozen=True)
class SceneData:
    """A run as it is shown: what moves, and curves.

    Attributes:
        title: of the run.
        motion: the first particles; None where there are none.
        more: further particles.
        meshes: cells.
        inputs: by their names; of an array those of its elements that act, or of its extremes.
        profiles: fields along a line; of a log only, whose ranges are known.
        remark: what pictures have to say beside what they show; "" for nothing.
        conclusions: what has become of the system at the end of the run, in sentences.
        focus_normal: the outward direction of a body in space where most happens; None where nothing tells, as while it runs.
        valid_until: time of the first event that ends the validity of the results [s]; infinity where there is none.
    """

    title: str
    motion: Motion | None
    curves: dict[str, Curve] = field(default_factory=dict)
    inputs: dict[str, Curve] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    balances: tuple[BalanceNames, ...] = ()
    """The names of the curves behind each balance; a vector has one curve for each axis."""
    more: tuple[Motion, ...] = ()
    meshes: tuple[MeshFrames, ...] = ()
    profiles: tuple[ProfileFrames, ...] = ()
    remark: str = ""
    conclusions: tuple[str, ...] = ()
    focus_normal: FloatArray | None = None
    valid_until: float = np.inf

    @property
    def motions(self) -> tuple[Motion, ...]:
        """All particles."""
        return self.more if self.motion is None else (self.motion, *self.more)

    @property
    def shapes(self) -> tuple[Motion | MeshFrames, ...]:
        """All that is drawn in space."""
        return (*self.motions, *self.meshes)

    @property
    def is_plane(self) -> bool:
        """True where anything drawn lies in a plane, or can move in it; otherwise all is in a row along x."""
        return any(shape.is_plane for shape in self.shapes)

    @property
    def is_solid(self) -> bool:
        """True where a body in space is drawn."""
        return any(mesh.is_solid for mesh in self.meshes)

    @property
    def viewpoint(self) -> FloatArray:
        """The direction towards the eye that sees the bodies in space, shape (3,)."""
        return viewpoint(self.focus_normal)

    @property
    def can_move(self) -> bool:
        """False where everything drawn is fixed for good."""
        return any(isinstance(shape, Motion) or not shape.is_fixed for shape in self.shapes)

    def coloured(self) -> Iterator[tuple[Variable, FloatArray]]:
        """Yield each output that colours something, and its values in all frames."""
        for motion in self.motions:
            if motion.colour is not None:
                yield motion.colour_variable, motion.colour
        for mesh in self.meshes:
            if mesh.field is not None:
                yield mesh.field_variable, mesh.field

    def group(self, names: Iterable[str]) -> list[Curve]:
        """Return the curves of these names that there are, without those that stay zero."""
        return [self.curves[name] for name in names if name in self.curves and np.any(self.curves[name].values != 0.0)]


# -- from a log ---------------------------------------------------------------------------------------------------------


def from_log(
    log: Any, frames: int = MAXIMUM_FRAMES, progress: Callable[[float], None] | None = None, colour: str | None = None
) -> SceneData:
    """Return at most `frames` frames of a log and all its scalar outputs and its inputs, thinned.

    Args:
        log: an open log.
        frames: how many there are at most.
        progress: as in `sample_frames`.
        colour: a recorded output that colours what it can; default: what the component names.
    """
    tell = progress or (lambda part: None)
    drawn = coloured_drawables(log, colour)
    found: list[Motion] = []
    for points in visible_points(drawn):
        motion = _motion(log, points, frames, (lambda part: None) if found else tell)
        found += [] if motion is None else [motion]
    motion = found[0] if found else None
    meshes = tuple(mesh for cells in visible_cells(drawn) if (mesh := _mesh(log, cells, frames)))
    outputs = {name: variable for name, variable in log.variables.items() if variable.causality == "output"}
    vectors = {name for balance in log.balances for name in (*balance.entries, balance.residual)}
    shown = [name for name in outputs if (outputs[name].shape in ((), (1,)) or name in vectors) and len(log.times(name))]
    curves = {curve.name: curve for name in shown for curve in curves_of(log, name)}
    acted = [one for name in log.input_variables if (one := load_input(log, name)) is not None]
    inputs = {curve.name: curve for one in acted for curve in one.curves}
    notes = (*_notes(log, motion, meshes), *_notes_on_colours(log, drawn, {one.name for one in (*found, *meshes)}))
    balances = _balances_to_show(log.balances, log.variables)
    profiles = tuple(_profile(log, one, frames) for one in log.drawables if _is_drawn_along_a_line(log, one))
    until, invalid = validity_of(log)
    remark = f"{remark_of(log.metadata.get('component'), log.metadata.get('parameters'))} {invalid}".strip()
    concluded = tuple(log.metadata["conclusions"])
    return SceneData(
        title_of(log), motion, curves, inputs, notes, balances, tuple(found[1:]), meshes, profiles, remark, concluded,
        focus_normal(log, drawn), until,
    )  # fmt: skip


def validity_of(log: Any) -> tuple[float, str]:
    """Return until when the results of a run are valid [s], and a sentence on it; infinity and "" where nothing ends that."""
    details = log.event_details
    for event in (*(log.earlier_events() or ()), *log.events()):
        if event.kind in details and details[event.kind].ends_validity:
            time = event.tick * log.step_size
            return time, f"Not valid from {1e6 * time:.4g} \u00b5s on: {event.kind.replace('_', ' ')}."
    return np.inf, ""


def _balances_to_show(balances: Iterable[BalanceNames], variables: Mapping[str, Variable]) -> tuple[BalanceNames, ...]:
    """Return the balances with the names of vectors' curves in the place of the vectors' own."""

    def split(names: Iterable[str]) -> tuple[str, ...]:
        return tuple(part for name in names if name in variables for part in curve_names(variables[name]))

    return tuple(replace(one, stored=split(one.stored), lost=split(one.lost), supplied=split(one.supplied)) for one in balances)


def recorded_outputs(log: Any) -> dict[str, Variable]:
    """Return the outputs of which a log has frames, by name."""
    return {name: one for name, one in log.variables.items() if one.causality == "output" and len(log.times(name))}


def coloured_drawables(log: Any, colour: str | None) -> tuple[Drawable, ...]:
    """Return what a log draws, coloured by an output; None for that which the component names.

    Points and cells whose output was not recorded take the first output that was and that can colour them.

    Raises:
        ParameterError: nothing can be coloured by that output.
    """
    recorded = recorded_outputs(log)
    if colour is not None:
        return recolour(log.drawables, recorded, colour)
    found: list[Drawable] = []
    for one in log.drawables:
        named = colour_name(one)
        others = colouring_outputs([one], recorded) if named and named not in recorded else []
        others = [name for name in others if name != getattr(one, "state", "")]
        found.append(with_colour(one, others[0]) if others else one)
    return tuple(found)


def curve_names(variable: Variable) -> list[str]:
    """Return the name of the curve of a scalar, or of an array of one, or those of the curves of a short vector."""
    if variable.shape in ((), (1,)):
        return [variable.name]
    if len(variable.shape) == 1 and variable.shape[0] <= len(_AXES):
        return [f"{variable.name}_{axis}" for axis in _AXES[: variable.shape[0]]]
    return []


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


def _motion(log: Any, points: Points, frames: int, progress: Callable[[float], None]) -> Motion | None:
    particles = replace(points, reference=spatial(points.reference))
    source = _displacement_source(log, particles)
    # Without displacements, what colours the particles still says when and what.
    clock = source or (particles.colour if _has_frames(log, particles.colour) else None)
    if clock is None:
        return None
    every = -(-len(particles.radius) // MAXIMUM_SHOWN_PARTICLES)
    shown = slice(None, None, every)
    count = len(particles.radius[shown])
    joined = _links_to_show(log.drawables, particles, lambda name: _has_frames(log, name)) if every == 1 else []
    count = max([count, *(len(one.pairs) for one in joined)])
    picked = evenly_picked(len(log.times(clock)), max(2, min(frames, MAXIMUM_POINTS // count)))
    displacement = _displacement(log, particles, source, picked, lambda part: progress(0.5 * part))
    colour = None
    if _has_frames(log, particles.colour):
        colour = sample_frames(log, particles.colour, picked, lambda part: progress(0.5 + 0.5 * part))[1][:, shown]

    def read(name: str) -> FloatArray | None:
        return sample_frames(log, name, picked)[1] if name in log.variables else None

    contacts = views_class(str(log.metadata.get("component"))).contacts
    rotation = read(particles.rotation) if _has_frames(log, particles.rotation) and every == 1 else None
    return Motion(
        np.asarray(log.times(clock), dtype=np.float64)[picked], np.asarray(log.ticks(clock))[picked],
        particles.reference[shown], particles.radius[shown], displacement[:, shown],
        colour, log.variables.get(particles.colour) or Variable(particles.colour, "output", "", (), particles.colour),
        *(contacts(particles, displacement if source else None, read) if every == 1 else (None, "", "")),
        every, len(particles.radius), source is not None, cuts_of(log, clock, picked),
        is_plane(particles.reference, log.variables.get(particles.displacement)),
        tuple(_link_frames(points, one, sample_frames(log, one.state, picked)[1]) for one in joined),
        particles.name, rotation,
    )  # fmt: skip


def _link_frames(points: Points, links: Links, state: FloatArray) -> LinkFrames:
    """Return links that are drawn: not those from one side of a periodic body to the other."""
    inside = points.stays_inside(links.pairs)
    return LinkFrames(links.name, links.pairs[inside], state[:, inside], links.state)


def _mesh(log: Any, cells: Cells, frames: int) -> MeshFrames | None:
    clock = next((name for name in (cells.displacement, cells.field) if _has_frames(log, name)), None)
    count = len(cells.nodes)
    if clock is None or count > MAXIMUM_SHOWN_NODES:
        return None
    picked = evenly_picked(len(log.times(clock)), max(2, min(frames, MAXIMUM_POINTS // count)))
    nodes, displacement = spatial(cells.nodes), np.zeros((len(picked), count, 3))
    if located := _has_frames(log, cells.displacement):
        displacement = _as_vectors(sample_frames(log, cells.displacement, picked)[1])
    field = sample_frames(log, cells.field, picked)[1] if _has_frames(log, cells.field) else None
    whole = sample_frames(log, cells.state, picked)[1] != 0.0 if _has_frames(log, cells.state) else None
    return MeshFrames(
        cells.name, np.asarray(log.times(clock), dtype=np.float64)[picked], np.asarray(log.ticks(clock))[picked],
        nodes, cells.connectivity, displacement, field,
        log.variables.get(cells.field) or Variable(cells.field, "output", "", (), cells.field),
        located, is_plane(nodes, log.variables.get(cells.displacement)), not cells.displacement, whole,
    )  # fmt: skip


def _is_drawn_along_a_line(log: Any, drawable: Drawable) -> bool:
    return isinstance(drawable, drawables.Curve) and len(drawable.coordinate) > 1 and _has_frames(log, drawable.field)


def _profile(log: Any, curve: drawables.Curve, frames: int) -> ProfileFrames:
    every = -(-len(curve.coordinate) // MAXIMUM_CURVE_POINTS)
    x = curve.coordinate[::every]
    picked = evenly_picked(len(log.times(curve.field)), max(2, min(frames, MAXIMUM_POINTS // len(x))))
    times, values = sample_frames(log, curve.field, picked)
    ticks = np.asarray(log.ticks(curve.field))[picked]
    return ProfileFrames(curve.name, times, ticks, x, values[:, ::every], log.variables[curve.field])


def _links_to_show(drawables: Iterable[Drawable], points: Points, is_known: Callable[[str], bool]) -> list[Links]:
    """Return the links between these points, so few that they can be drawn, whose state is known."""
    links = (one for one in drawables if isinstance(one, Links) and one.points == points.name and len(one.pairs))
    return [one for one in links if len(one.pairs) <= MAXIMUM_SHOWN_LINKS and is_known(one.state)]


def _displacement(
    log: Any, particles: Points, source: str | None, picked: npt.NDArray[np.int64], progress: Callable[[float], None]
) -> FloatArray:
    if source is None:
        return np.zeros((len(picked), len(particles.radius), 3))
    _, moved = sample_frames(log, source, picked, progress)
    displacement = _as_vectors(moved)
    if source != particles.displacement:
        displacement -= particles.reference if moved.ndim == 3 else particles.reference * [1.0, 0.0, 0.0]
    return displacement


def _displacement_source(log: Any, particles: Points) -> str | None:
    return next((name for name in (particles.displacement, "position") if _has_frames(log, name)), None)


def _has_frames(log: Any, name: str) -> bool:
    return name in log.variables and len(log.times(name)) > 0


def _as_vectors(moved: FloatArray) -> FloatArray:
    """Displacements along x, shape (frames, n), as vectors (frames, n, 3); vectors as a copy."""
    return spatial(moved if moved.ndim == 3 else moved[..., np.newaxis])


def evenly_picked(available: int, wanted: int) -> npt.NDArray[np.int64]:
    """Return indices of evenly spaced frames, the first and the last among them."""
    if available <= wanted:
        return np.arange(available)
    return np.unique(np.rint(np.linspace(0, available - 1, wanted)).astype(np.int64))


def cuts_of(log: Any, name: str, picked: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Return which of the frames picked are the first of a later segment."""
    ticks, lengths = np.asarray(log.ticks(name)), [segment.end - segment.start for segment in log.segments]
    bounds = log.start_tick + np.cumsum(lengths[:-1], dtype=np.int64)
    # Where two segments meet, a frame of each may lie on the same tick; the later one begins the segment.
    after = np.searchsorted(ticks, bounds, side="right")
    firsts = np.where(np.isin(bounds, ticks), after - 1, after)
    cuts = np.unique(np.searchsorted(picked, firsts))
    return cuts[(cuts > 0) & (cuts < len(picked))]


def sample_frames(
    log: Any, name: str, picked: npt.NDArray[np.int64], progress: Callable[[float], None] | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return times (frames,) [s] and values (frames, *shape) of some frames; `progress` is told the part that is read."""
    times = np.asarray(log.times(name), dtype=np.float64)
    tell = progress or (lambda part: None)
    if len(times) * int(np.prod(log.variables[name].shape, dtype=np.int64)) <= _READ_AT_ONCE:
        values = np.asarray(log.series(name)[1], dtype=np.float64)[picked]
        tell(1.0)
        return times[picked], values
    rows = []
    for time in times[picked]:
        rows.append(np.asarray(log.get(name, float(time)), dtype=np.float64))
        tell(len(rows) / len(picked))
    return times[picked], np.stack(rows)


def curves_of(log: Any, name: str) -> Iterator[Curve]:
    """Yield a recorded scalar in time, or each component of a short vector, thinned so that no peak is lost."""
    variable = log.variables[name]
    times, values = sample_frames(log, name, np.arange(len(log.times(name))))
    for column, shown in enumerate(curve_names(variable)):
        own = values if values.ndim == 1 else values[:, column]
        picked = pick_with_extremes(own)
        ticks, cuts = np.asarray(log.ticks(name))[picked], cuts_of(log, name, picked)
        yield Curve(shown, variable.unit, variable.description, times[picked], ticks, own[picked], cuts)


def _notes(log: Any, motion: Motion | None, meshes: Sequence[MeshFrames]) -> Iterable[str]:
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
        if cells.state and not _has_frames(log, cells.state):
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
        if not _has_frames(log, one.state):
            yield f"{one.state} was not recorded: the {one.name} are not shown. Record it as well."
        elif len(one.pairs) > MAXIMUM_SHOWN_LINKS:
            yield f"The {one.name} are not shown: there are {len(one.pairs)}, more than {MAXIMUM_SHOWN_LINKS}."
        elif one.points == motion.name and motion.every > 1:
            yield f"The {one.name} are not shown, since not all {motion.name} are."


# -- from a component that runs -------------------------------------------------------------------------------------------


def from_component(component: Component, title: str | None = None) -> SceneData:
    """One frame: the present state of a component."""
    now, tick = np.array([component.time]), np.array([component.tick], dtype=np.int64)

    def curves(variable: Variable) -> Iterator[Curve]:
        values = np.ravel(component.get(variable.name)).astype(np.float64)
        for name, value in zip(curve_names(variable), values, strict=True):
            yield Curve(name, variable.unit, variable.description, now, tick, np.array([value]))

    scalars = [v for v in component.variables.values() if v.shape in ((), (1,)) or v.name in component.balance_names]
    given = (variable for variable in component.variables.values() if variable.causality == "input")
    inputs = [curve for one in given for curve in present_input(one, component.get(one.name), component.time, component.tick)]
    balances = balance_names_from([balance_facts(balance) for balance in component.balances()])
    drawn = component.drawables()
    found = [_present_motion(component, points, now, tick) for points in visible_points(drawn)]
    return SceneData(
        title or component.name,
        found[0] if found else None,
        {curve.name: curve for variable in scalars if variable.causality == "output" for curve in curves(variable)},
        {curve.name: curve for curve in inputs},
        balances=_balances_to_show(balances, component.variables),
        more=tuple(found[1:]),
        meshes=tuple(
            _present_mesh(component, cells, now, tick)
            for cells in visible_cells(drawn)
            if len(cells.nodes) <= MAXIMUM_SHOWN_NODES
        ),
        remark=remark_of(component.name, component.parameters.model_dump()),
    )


def _present_motion(component: Component, points: Points, now: FloatArray, tick: npt.NDArray[np.int64]) -> Motion:
    particles = replace(points, reference=spatial(points.reference))
    total = len(particles.radius)
    every = -(-total // MAXIMUM_SHOWN_PARTICLES)
    shown = slice(None, None, every)
    displacement = _as_vectors(np.asarray(component.get(particles.displacement))[None])
    contacts = views_class(component.name).contacts

    def read(name: str) -> FloatArray | None:
        return np.asarray(component.get(name))[None] if name in component.variables else None

    joined = _links_to_show(component.drawables(), particles, component.variables.__contains__) if every == 1 else []
    links = tuple(_link_frames(points, one, np.asarray(component.get(one.state))[None]) for one in joined)
    return Motion(
        now, tick, particles.reference[shown], particles.radius[shown], displacement[:, shown],
        np.asarray(component.get(particles.colour))[None, shown] if particles.colour else None,
        component.variables.get(particles.colour) or Variable("", "output", "", (), ""),
        *(contacts(particles, displacement, read) if every == 1 else (None, "", "")),
        every, total, is_plane=is_plane(particles.reference, component.variables.get(particles.displacement)), links=links,
        name=particles.name, rotation=read(particles.rotation) if every == 1 else None,
    )  # fmt: skip


def _present_mesh(component: Component, cells: Cells, now: FloatArray, tick: npt.NDArray[np.int64]) -> MeshFrames:
    nodes = spatial(cells.nodes)
    displacement = np.zeros((1, *nodes.shape))
    if cells.displacement:
        displacement = _as_vectors(np.asarray(component.get(cells.displacement))[None])
    return MeshFrames(
        cells.name, now, tick, nodes, cells.connectivity, displacement,
        np.asarray(component.get(cells.field))[None], component.variables[cells.field],
        bool(cells.displacement), is_plane(nodes, component.variables.get(cells.displacement)), not cells.displacement,
        np.asarray(component.get(cells.state))[None] != 0.0 if cells.state else None,
    )  # fmt: skip
