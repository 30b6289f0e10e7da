"""The parts of an atlas: a paper, its entries, and what an entry finds: items with verdicts, and figures."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from .verdicts import Value, Verdict, combine

if TYPE_CHECKING:
    from .context import Context

Numbers = npt.ArrayLike
CurveStyle = Literal["line", "dashed", "thin", "points", "bar", "steps"]


@dataclasses.dataclass(frozen=True)
class Item:
    """A statement of the paper beside what we compute.

    Attributes:
        name: what it is about.
        where: where the paper prints it: a section, an equation, a figure.
        values: the paper's numbers and ours, with their tolerances.
        remark: what a reader should know; how it was measured.
        reason: why it is not reproduced, where it is not.
    """

    name: str
    where: str
    values: Sequence[Value]
    remark: str = ""
    reason: str = ""

    @property
    def verdict(self) -> Verdict:
        """Return the verdict, from the values alone; see `verdicts`."""
        return combine(self.values)

    @property
    def unmet(self) -> bool:
        """Return whether any of its values is not, or only roughly, as printed: then the reason is wanted."""
        return any(value.verdict.kind in ("not reproduced", "in part") for value in self.values)


@dataclasses.dataclass(frozen=True)
class Axis:
    """An axis of a figure.

    Attributes:
        label: quantity and unit.
        low: where it begins; default: by the data.
        high: where it ends; default: by the data.
        names: (place, name) of its ticks instead of numbers.
    """

    label: str
    low: float | None = None
    high: float | None = None
    names: Sequence[tuple[float, str]] = ()


@dataclasses.dataclass(frozen=True)
class Curve:
    """Data of a figure.

    Attributes:
        label: for the legend; empty: none.
        x: shape (points,).
        y: shape (points,); a NaN breaks the line.
        style: line, dashed, thin (a faint line), points, bar (a thick line), or steps.
        colour: 0 to 5 of the palette; curves of one colour belong together.
    """

    label: str
    x: Numbers
    y: Numbers
    style: CurveStyle = "line"
    colour: int = 0

    def points(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Both coordinates as float arrays of one shape."""
        return np.asarray(self.x, dtype=np.float64).ravel(), np.asarray(self.y, dtype=np.float64).ravel()


@dataclasses.dataclass(frozen=True)
class Mark:
    """A number that the paper states, drawn into the figure: a line across it where one coordinate is None, else a point."""

    label: str
    x: float | None = None
    y: float | None = None

    @property
    def is_point(self) -> bool:
        """Tell whether both coordinates are stated; the page's template asks."""
        return self.x is not None and self.y is not None


@dataclasses.dataclass(frozen=True)
class Shading:
    """A quantity over the plane, drawn the darker the more there is of it, with a scale beside the figure.

    Attributes:
        label: quantity and unit, for the scale.
        x: of the columns, evenly spaced, shape (columns,).
        y: of the rows, evenly spaced, shape (rows,).
        values: shape (rows, columns); NaN where there is nothing.
        most: the magnitude that is drawn darkest, as is what exceeds it; default: the largest.
        power: the shade goes as this power of the magnitude; less than 1 shows what is weak.
        signed: whether negative values have a colour of their own; otherwise there are none.
    """

    label: str
    x: Numbers
    y: Numbers
    values: Numbers
    most: float | None = None
    power: float = 1.0
    signed: bool = False


@dataclasses.dataclass(frozen=True)
class Arrows:
    """Vectors in the plane.

    Attributes:
        label: quantity and unit, for the legend.
        x: where they stand, shape (arrows,).
        y: shape (arrows,).
        u: their components along x, shape (arrows,).
        v: along y, shape (arrows,).
        longest: the length of the longest one, in the unit of x.
        most: the magnitude that is drawn so long, as is what exceeds it; default: the largest.
        power: lengths go as this power of the magnitude; less than 1 shows what is weak.
    """

    label: str
    x: Numbers
    y: Numbers
    u: Numbers
    v: Numbers
    longest: float
    most: float | None = None
    power: float = 1.0


@dataclasses.dataclass(frozen=True)
class Letter:
    """A short name at a place in a figure; it has the colour of the curves that it names."""

    text: str
    x: float
    y: float
    colour: int = 0


@dataclasses.dataclass(frozen=True)
class Figure:
    """A drawing with its data.

    Attributes:
        name: unique in the atlas, such as "figure-6".
        title: one line.
        caption: what is to be seen.
        x: the horizontal axis.
        y: the vertical axis.
        curves: what we compute.
        marks: what the paper states.
        shading: a quantity over the plane of both axes, under everything else.
        arrows: vectors in that plane.
        letters: names of places.
        equal: whether a length is as long along one axis as along the other; both axes then need limits.
    """

    name: str
    title: str
    caption: str
    x: Axis
    y: Axis
    curves: Sequence[Curve] = ()
    marks: Sequence[Mark] = ()
    shading: Shading | None = None
    arrows: Arrows | None = None
    letters: Sequence[Letter] = ()
    equal: bool = False


@dataclasses.dataclass(frozen=True)
class Table:
    """Results of ours beside each other, a row for each run; what the paper has of them stands in a column of its own.

    Attributes:
        name: for addresses, such as "table-outcomes".
        title: one line.
        caption: what a reader should know.
        head: what stands in each column.
        rows: words or numbers with their units, one for each column.
    """

    name: str
    title: str
    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclasses.dataclass(frozen=True)
class Findings:
    """The items, figures and tables that an entry computed."""

    items: Sequence[Item] = ()
    figures: Sequence[Figure] = ()
    tables: Sequence[Table] = ()


@dataclasses.dataclass(frozen=True)
class Entry:
    """A section or a figure of the paper, and how it is computed anew.

    Attributes:
        name: for addresses and the command line, such as "3.4-piston".
        section: as the paper numbers it.
        title: one line.
        text: what the paper does there, in a few sentences for a reader who does not have it.
        compute: from a context to the findings; it is a function of a module, so that another process finds it.
        weight: how long it takes, in seconds of one core, for the progress bar and so that long ones begin first.
        runs: how many runs it asks for, for the progress bar; or a function of a module that says so for the
            constants.
    """

    name: str
    section: str
    title: str
    text: str
    compute: Callable[[Context], Findings]
    weight: float = 1.0
    runs: int | Callable[[Mapping[str, float]], int] = 1

    def expected_runs(self, constants: Mapping[str, float]) -> int:
        """Return how many runs it asks for with these constants."""
        return self.runs if isinstance(self.runs, int) else self.runs(constants)


@dataclasses.dataclass(frozen=True)
class Constant:
    """A number that a reader may change to see the figures move.

    Attributes:
        value: the paper's, or the page's by default.
        unit: SI.
        description: what it is.
        low: the smallest value that makes sense.
        high: the largest one.
        whole: whether it counts something.
        of_page: whether it is a choice of the page, such as the size of a mesh, and no number of the paper.
    """

    value: float
    unit: str
    description: str
    low: float
    high: float
    whole: bool = False
    of_page: bool = False


@dataclasses.dataclass(frozen=True)
class Paper:
    """A paper: a folder of entries.

    Attributes:
        name: as on the command line, such as "nesterenko-1983".
        title: in English.
        citation: where it was published.
        summary: what it is about and what this page does, one string a paragraph.
        constants: what may be changed, by name.
        entries: in the order of the page.
        cost: from the constants and the names of entries, what these take, in words; the command says so beforehand where
            constants are changed.
    """

    name: str
    title: str
    citation: str
    summary: Sequence[str]
    constants: Mapping[str, Constant]
    entries: Sequence[Entry]
    cost: Callable[[Mapping[str, float], Sequence[str]], str] | None = None
