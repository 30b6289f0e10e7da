"""The helper of the papers' scripts: a page of rows, figures and text, with verdicts that follow from the numbers.

    python papers/nesterenko_1983/figure_3.py       # prints its rows, and writes its figures into build/papers

A script has a docstring (a title, an empty line, text) and a function ``main(page)``, which compares printed numbers with
computed ones (`Page.compare`), draws (`Page.plot`) and explains (`Page.text`). Each row states the known result of the script;
a different number is a failure. With ``FULL=1`` in the environment, scripts use the paper's sizes instead of coarse meshes, and
known numbers are not checked. ``papers/collect.py`` makes HTML pages of all scripts. The verdicts are:

- *reproduced*: our number rounds to the printed number, or lies within an error stated in the paper.
- *bound kept*: the paper states an upper bound that any correct program satisfies.
- *as read*: the paper has a word such as "satisfactory", and our number satisfies our numerical reading of it.
- *percentile*: the paper has one random sample; its number lies at this percentile of our samples.
- *not reproduced*: anything else.
"""

from __future__ import annotations

import functools
import os
import re
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

import granular_env as ge

OUT = Path(__file__).resolve().parents[2] / "build" / "papers"
FULL = os.environ.get("FULL", "0") not in ("", "0")

_DECIMAL = re.compile(r"(?:about )?([-+]?\d*\.?\d+(?:e[-+]?\d+)?)")


def last_digit_unit(text: str) -> float:
    """Return a unit of the last digit of a decimal number such as "2.708" or "5.6e12"."""
    digits, _, power = text.lower().partition("e")
    return 10.0 ** (int(power or 0) - len(digits.partition(".")[2]))


@dataclass(frozen=True)
class Row:
    """A number or word of the paper, and our result.

    Attributes:
        what: the quantity.
        paper: printed value; None if the paper gives no value.
        ours: the computed number or word.
        unit: unit of both values.
        near: numerical meaning of `paper`, if it is not a decimal number ("unchanged" is 0).
        within: largest accepted difference; default: half a unit of the last printed digit.
        most: an upper bound stated in the paper instead of a number.
        reading: our reading of the paper's words; this row is never "reproduced".
        found: our known result, with the converged digits; it is shown, and a different number is a failure.
        draws: results of many random samples, whose mean is `ours`.
    """

    what: str
    paper: str | None
    ours: float | str
    unit: str = ""
    near: float | None = None
    within: float | None = None
    most: float | None = None
    reading: str = ""
    found: str | None = None
    draws: Sequence[float] = ()

    @property
    def number(self) -> float:
        """The paper's number."""
        if self.near is not None:
            return self.near
        match = _DECIMAL.fullmatch(self.paper or "")
        if match is None:
            raise ValueError(f"{self.what}: {self.paper!r} is no number; give its numerical meaning with near=")
        return float(match[1])

    @property
    def tolerance(self) -> float:
        """The largest accepted difference."""
        if self.within is not None:
            return self.within
        exact = isinstance(self.ours, int) or self.near is not None
        return 0.0 if exact else 0.5 * last_digit_unit(str(self.paper).removeprefix("about "))

    @property
    def verdict(self) -> str:
        """The verdict, which follows from the numbers."""
        if self.paper is None:
            return ""
        if isinstance(self.ours, str):
            return self._verdict_text(self.ours == self.paper, "")
        if len(self.draws):
            share = 100.0 * float(np.mean(np.less(self.draws, self.number)))
            return f"percentile {share:.0f}" if 0.0 < share < 100.0 else "not reproduced: outside all samples"
        if self.most is not None:
            return self._verdict_text(self.ours <= self.most, f"{_digits(self.ours - self.most)} above")
        gap = self.ours - self.number
        away = (
            f"{_digits(100.0 * gap / self.number)} % off"
            if self.number and not isinstance(self.ours, int)
            else f"{_digits(gap)} off"
        )
        if self.number and abs(gap) > 10.0 * abs(self.number):
            away = f"{_digits(self.ours / self.number)} times as large"
        return self._verdict_text(abs(gap) <= self.tolerance * (1.0 + 1e-9), away)

    def _verdict_text(self, agrees: bool, away: str) -> str:
        if not agrees:
            return f"not reproduced: {away}" if away else "not reproduced"
        return "as read" if self.reading else "bound kept" if self.most is not None else "reproduced"

    @property
    def display_text(self) -> str:
        """Our result as displayed, with the converged digits of `found`."""
        if isinstance(self.ours, str | int):
            return str(self.ours)
        if self.found is None or "e" in self.found:
            return _digits(self.ours, 4 if self.found is None else len(self.found.partition("e")[0].replace(".", "")))
        text = f"{self.ours:.{len(self.found.partition('.')[2])}f}"
        if len(self.draws):
            low, high = np.percentile(self.draws, (5, 95))
            text += f" ± {_digits(float(np.std(self.draws, ddof=1)))} [{_digits(low)}, {_digits(high)}]"
        return text

    @property
    def failure(self) -> str:
        """The message of a row whose number differs from the known number; empty for other rows."""
        if self.found is None:
            return f"{self.what}: {self.verdict}" if self.verdict.startswith("not") else ""
        if isinstance(self.ours, str):
            return "" if self.ours == self.found else f"{self.what}: got {self.ours!r}, known {self.found!r}"
        same = abs(self.ours - float(self.found)) <= 1.05 * last_digit_unit(self.found) * (not isinstance(self.ours, int))
        return "" if same else f"{self.what}: got {self.ours!r}, known {self.found}"


def _digits(value: float, digits: int = 2) -> str:
    """Return a number with a few significant digits."""
    return f"{float(f'{value:.{digits}g}'):.6g}"


@dataclass
class Page:
    """The part of a page from one script: blocks in order, and the folder of its figures.

    Attributes:
        name: name of the script, such as "figure_3".
        folder: folder of the figures.
        title: the first line of the script's docstring.
        blocks: (kind, content) in order: "say", "head", "row", "table", "figure", "error".
        failures: rows that differ from their known number.
    """

    name: str
    folder: Path
    title: str = ""
    blocks: list[tuple[str, Any]] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)

    @property
    def rows(self) -> list[Row]:
        """The comparisons."""
        return [content for kind, content in self.blocks if kind == "row"]

    def text(self, text: str) -> None:
        """Add paragraphs, separated by empty lines."""
        self.blocks += [("say", " ".join(part.split())) for part in re.split(r"\n\s*\n", text.strip())]

    def add_heading(self, text: str) -> None:
        """Add a heading for the following rows."""
        self.blocks.append(("head", text))

    def compare(self, what: str, paper: str | None, ours: float | str, unit: str = "", **how: Any) -> None:
        """Add a row; the other arguments are those of `Row`: near, within, most, reading, found, draws."""
        row = Row(what, paper, ours if isinstance(ours, str | int) else float(ours), unit, **how)
        self.blocks.append(("row", row))
        if row.failure and not FULL:
            self.failures.append(row.failure)

    def add_value(self, what: str, ours: float | str, unit: str = "", found: str | None = None) -> None:
        """Add a row for a number that is not in the paper."""
        self.compare(what, None, ours, unit, found=found)

    def compare_samples(
        self, what: str, paper: str | None, draws: npt.ArrayLike, unit: str = "", found: str | None = None
    ) -> None:
        """Add a row for the result of many random samples, of which the paper has one; `found` is their mean."""
        values = np.asarray(draws, dtype=float)
        self.compare(what, paper, float(values.mean()), unit, found=found, draws=values.tolist())

    def add_table(self, caption: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        """Add a table of our own results."""
        self.blocks.append(("table", (caption, head, rows)))

    @contextmanager
    def plot(
        self, caption: str, x: str, y: str, size: tuple[float, float] = (7.0, 3.6), legend: Any = "best"
    ) -> Iterator[Axes]:
        """Draw a figure in the body of a ``with`` statement; label and save it at the end."""
        figure, axes = plt.subplots(figsize=size, layout="constrained")
        yield axes
        axes.set(xlabel=x, ylabel=y)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(frameon=False, fontsize="small", loc=legend)
        count = sum(kind == "figure" for kind, _ in self.blocks) + 1
        path = self.folder / f"{self.name}-{count}.png"
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=120)
        plt.close(figure)
        self.blocks.append(("figure", (path.name, caption)))


def record(experiment: Any, **overrides: Any) -> Any:
    """Run an experiment and return its opened log, which is in a temporary folder."""
    path = Path(_scratch_folder().name) / f"{time.monotonic_ns()}.mcap"
    with warnings.catch_warnings(action="ignore", category=ge.GranularWarning):
        ge.run(experiment, log=path, overrides=overrides)
    return ge.open_log(path)


@functools.cache
def _scratch_folder() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="papers-")


def compute_page(main: Callable[[Page], None], path: Path, text: str | None, folder: Path) -> Page:
    """Run the ``main`` of a script."""
    page = Page(path.stem, folder)
    page.title, _, body = (text or path.stem).partition("\n")
    if body.strip():
        page.text(body)
    main(page)
    return page


def show(main: Callable[[Page], None]) -> None:
    """Run a script: print its rows, and exit with status 1 if a row differs from its known number."""
    path = Path(sys.argv[0]).resolve()
    page = compute_page(main, path, sys.modules["__main__"].__doc__, OUT / path.parent.name)
    for kind, content in page.blocks:
        if kind == "row":
            paper = "" if content.paper is None else f"paper {content.paper}"
            print(f"  {content.what:<56} {f'{content.display_text} {content.unit}':<28} {paper:<24} {content.verdict}")
        elif kind in ("say", "head"):
            print(content)
        elif kind == "table":
            print(*(content[0], *("  ".join(row) for row in (content[1], *content[2]))), sep="\n  ")
        else:
            print(f"  figure: {page.folder / content[0]}")
    sys.exit("\n".join(page.failures) or 0)
