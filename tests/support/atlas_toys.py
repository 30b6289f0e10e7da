"""A paper of four short entries, one of which fails: what the atlas's framework is tested with."""

from __future__ import annotations

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Constant, Curve, Entry, Figure, Findings, Item, Mark, Paper
from granular_env.atlas.seed_statistics import Band
from granular_env.atlas.verdicts import Value
from granular_env.components.errors import GranularError
from granular_env.domains.chain import measurement

HOSTILE = '<script>alert(1)</script> & "quoted"'


def experiment(grains: int, stiffness: float) -> dict:
    return {
        "name": "toy/struck",
        "duration": 1e-4,
        "component": {"type": "chain", "grains": grains, "contact_stiffness": stiffness, "step_size": 5e-7},
        "start": {"velocity": {"0": 1.0}},
        "record": {"every": 1e-6, "variables": ["velocity", "displacement"]},
    }


def struck(context: Context) -> Findings:
    """The velocity of the third grain, by the constants."""
    log = context.run(experiment(int(context.constants["N"]), context.constants["k"]))
    history = measurement.history(log)
    items = [Item("Largest velocity", "section 1", [Value("grain 3", "0.68", float(history.velocity[:, 2].max()))])]
    curve = Curve("grain 3", history.time * 1e6, history.velocity[:, 2])
    return Findings(items, [Figure("figure-struck", "Struck", "A chain.", Axis("time, µs"), Axis("v"), [curve])])


def strange(context: Context) -> Findings:
    """Text that wants to be markup, a gap in the data, a band, every style."""
    x = np.linspace(-1.0, 1.0, 21)
    y = np.where(np.abs(x) < 0.11, np.nan, x**2)
    styles = ("line", "dashed", "thin", "points", "bar", "steps")
    curves = [Curve(f"{HOSTILE} {style}", x, y + i, style, i) for i, style in enumerate(styles)]
    marks = [Mark(HOSTILE, y=1.0), Mark("point", 0.5, 2.0), Mark("across", x=-0.5), Mark("outside", y=99.0)]
    figure = Figure("figure-strange", HOSTILE, HOSTILE, Axis(HOSTILE), Axis("y", high=8.0), curves, marks)
    band = Band.of([1.0, 2.0, 3.0, 4.0])
    items = [
        Item(HOSTILE, HOSTILE, [Value(HOSTILE, HOSTILE, "other")], HOSTILE, HOSTILE),
        Item("a draw", "section 2", [Value("", "2.5", band.mean, band=band)]),
    ]
    return Findings(items, [figure])


def failing(context: Context) -> Findings:
    """An error of ours."""
    raise GranularError("the piston fell off <b>")


def broken(context: Context) -> Findings:
    """An error of nobody's."""
    return Findings([Item("never", "", [Value("", "1", float(np.zeros(1)[7]))])])


def toy(*, fails: bool = True) -> Paper:
    entries = [
        Entry("struck", "1", "A chain is struck", "Text.", struck, weight=2.0),
        Entry("again", "1.1", "The same again", "Text.", struck),
        Entry("strange", "2", HOSTILE, HOSTILE, strange),
    ]
    if fails:
        entries[2:2] = [Entry("failing", "3", "Fails", "Text.", failing), Entry("broken", "4", "Breaks", "Text.", broken)]
    constants = {
        "k": Constant(5e9, "N/m^1.5", "stiffness", 1e8, 1e11),
        "N": Constant(8, "", "grains", 4, 100, whole=True),
    }
    return Paper("toy-2000", "A toy", "Nowhere.", ["A paper for tests."], constants, entries)
