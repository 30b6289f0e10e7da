"""Data of a run for viewers and figures, in arrays of bounded size."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.variables import Variable
from granular_env.recording.header import BalanceNames
from granular_env.recording.preview.visible_drawables import is_solid

from .curves import Curve
from .viewpoint import viewpoint

# Largest amounts of displayed data (see the names); with more, viewers run out of memory.
MAXIMUM_FRAMES = 400
MAXIMUM_SHOWN_PARTICLES = 20_000
MAXIMUM_SHOWN_LINKS = 60_000
MAXIMUM_SHOWN_NODES = 500_000
MAXIMUM_POINTS = 1_000_000
# Room next to the extremes of a profile, as a fraction of its range.
_ROOM = 0.05


@dataclass(frozen=True)
class LinkFrames:
    """Links between the particles of a `Motion`, with their state in each of its frames.

    Attributes:
        name: name of the links, such as "links".
        pairs: indices of the two particles of each link, shape (m, 2).
        state: 0 where the pair is not linked (any more), shape (frames, m).
    """

    name: str
    pairs: npt.NDArray[np.int64]
    state: FloatArray


@dataclass(frozen=True)
class Motion:
    """Particles in some frames of a run.

    Attributes:
        times: shape (frames,) [s].
        ticks: shape (frames,).
        reference: positions at rest of the particles shown, shape (n, 3) [m].
        radius: shape (n,) [m].
        displacement: shape (frames, n, 3) [m]; zeros if it was not recorded.
        colour: values of the colouring variable, shape (frames, n); None if it was not recorded.
        colour_variable: name, unit and meaning of the colouring variable.
        contact: contact force or overlap, as the domain chooses, never negative, shape (frames, contacts); None if unknown.
        contact_name, contact_unit: name and unit of the contact quantity.
        every: every `every`-th particle is shown; 1 shows all.
        total: the number of particles.
        located: whether the displacements were recorded; otherwise the particles stay at their positions at the start.
        cuts: indices of the first frames of later segments.
        is_plane: whether they lie, or can move, in two dimensions; otherwise they are a row along x.
        links: between the particles; empty if particles are left out.
        name: name of the particles, such as "grains".
        rotation: angles of the particles, shape (frames, n) [rad]; None if they were not recorded.
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
        name: name of the cells, such as "grid".
        times: shape (frames,) [s].
        ticks: shape (frames,).
        nodes: initial positions, shape (n, 3) [m].
        connectivity: nodes of each cell in cyclic order, shape (m, k).
        displacement: displacements of the nodes, shape (frames, n, 3) [m]; zeros if not recorded.
        field: values that colour the nodes or cells, shape (frames, n) or (frames, m); None if not recorded.
        field_variable: name, unit and meaning of the field.
        located: whether the displacements were recorded.
        is_plane: whether they lie, or can move, in two dimensions.
        is_fixed: whether the cells never move and have no displacements to record.
        whole: mask of the unbroken cells, shape (frames, m); None if no cell breaks or the state was not recorded.
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
        """Whether the cells are the surface of a body in space."""
        return is_solid(self.nodes)

    @property
    def has_cell_values(self) -> bool:
        """Whether the field has one value per cell; otherwise it has one per node."""
        return self.field is not None and self.field.shape[1] == len(self.connectivity) != len(self.nodes)


def drawn_positions(shape: Motion | MeshFrames, factor: float, frames: int | slice = slice(None)) -> FloatArray:
    """Return drawn positions of points or nodes, shape (..., n, 3) [m]: positions at rest plus `factor` times displacements."""
    rest = shape.reference if isinstance(shape, Motion) else shape.nodes
    return rest + factor * shape.displacement[frames]


@dataclass(frozen=True)
class ProfileFrames:
    """A field along a line in some frames of a run.

    Attributes:
        name: name of the drawable.
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

    @property
    def limits(self) -> tuple[float, float]:
        """The ends of an axis for the values, with zero and some room for non-zero values."""
        low, high = float(self.values.min(initial=0.0)), float(self.values.max(initial=0.0))
        room = _ROOM * (high - low) or 1.0
        return low - room * (low < 0.0), high + room * (high > 0.0 or low == 0.0)


@dataclass(frozen=True)
class SceneData:
    """The displayed data of a run: moving shapes and curves.

    Attributes:
        title: title of the run.
        motions: particles.
        meshes: cells.
        inputs: the curves of each input by name; of an array, those of its non-zero elements or of its extremes.
        profiles: fields along a line; only for a log, whose ranges are known.
        remark: sentences of the domain on pictures of the component; "" for none.
        conclusions: sentences on the state at the end of the run.
        focus_normal: outward normal of the side of a body in space to show; None for the usual view.
        valid_until: time of the first event that ends the validity of the results [s]; infinity without such an event.
    """

    title: str
    motions: tuple[Motion, ...] = ()
    meshes: tuple[MeshFrames, ...] = ()
    curves: dict[str, Curve] = field(default_factory=dict)
    inputs: dict[str, Curve] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    balances: tuple[BalanceNames, ...] = ()
    """The names of the curves of each balance; a vector has one curve for each axis."""
    profiles: tuple[ProfileFrames, ...] = ()
    remark: str = ""
    conclusions: tuple[str, ...] = ()
    focus_normal: FloatArray | None = None
    valid_until: float = np.inf

    @property
    def motion(self) -> Motion | None:
        """The first particles; None if there are none."""
        return self.motions[0] if self.motions else None

    @property
    def shapes(self) -> tuple[Motion | MeshFrames, ...]:
        """All shapes that have positions (particles and cells), in contrast to curves and profiles."""
        return (*self.motions, *self.meshes)

    @property
    def is_plane(self) -> bool:
        """Whether any shape lies or can move in a plane; otherwise all shapes are in a row along x."""
        return any(shape.is_plane for shape in self.shapes)

    @property
    def is_solid(self) -> bool:
        """Whether a body in space is drawn."""
        return any(mesh.is_solid for mesh in self.meshes)

    @property
    def viewpoint(self) -> FloatArray:
        """The direction towards the eye for bodies in space, shape (3,)."""
        return viewpoint(self.focus_normal)

    @property
    def movable_shapes(self) -> list[Motion | MeshFrames]:
        """All shapes that can move."""
        return [shape for shape in self.shapes if isinstance(shape, Motion) or not shape.is_fixed]

    @property
    def unmoved_shapes(self) -> list[str]:
        """The names of the shapes drawn at their initial positions because no displacements were recorded."""
        return [shape.name.replace("_", " ") for shape in self.movable_shapes if not shape.located]

    def coloured_outputs(self) -> Iterator[tuple[Variable, FloatArray]]:
        """Yield each output that colours a shape, with its values in all frames."""
        for motion in self.motions:
            if motion.colour is not None:
                yield motion.colour_variable, motion.colour
        for mesh in self.meshes:
            if mesh.field is not None:
                yield mesh.field_variable, mesh.field

    def named_curves(self, names: Iterable[str]) -> list[Curve]:
        """Return the curves with these names, except curves that are always zero; missing names are ignored."""
        return [self.curves[name] for name in names if name in self.curves and np.any(self.curves[name].values != 0.0)]
