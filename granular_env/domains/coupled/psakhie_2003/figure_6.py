"""Figure 6: a plane wave goes through the interface, to the rigid side of the automata, and back."""

from __future__ import annotations

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item
from granular_env.atlas.verdicts import Value

from .plane_wave import PEAK, PLACES, PlaneWave, plane_wave
from .thresholds import EXACT_SUM, NOT_SEEN_WORDS, absent, complete

_WAVES = ("square", "hexagonal")
# Which of the places: in the grid before the interface, and the last but one in the automata.
_BEFORE, _IN_AUTOMATA = 1, 3
# Between the curves of two places, in peaks.
_APART = 1.5


def compute(context: Context) -> Findings:
    """Both packings, at the page's size of cells, and the size doubled to see how errors go."""
    waves = {packing: plane_wave(context, packing) for packing in _WAVES}
    coarse = {packing: plane_wave(context, packing, coarser=2) for packing in _WAVES}
    items = [_no_reflection(waves), _no_distortion(waves), _there_and_back(waves), _momentum(waves), _energy(waves)]
    items.append(_small_automata(waves, coarse))
    return Findings(items, [_figure(packing, wave) for packing, wave in waves.items()])


def _no_reflection(waves: dict[str, PlaneWave]) -> Item:
    return Item(
        "“The passage of the wave through the interface was not accompanied by a reflected wave”", "section 3, figure 6, b",
        [absent(f"{name}: velocity left at x = 0.15 m", 100.0 * one.left_behind(_BEFORE)) for name, one in waves.items()],
        remark="Largest velocity in the grid between the wave’s passage and its return, over the peak of the wave. What the "
        "wave itself trails in the grid is in it.",
        reason=NOT_SEEN_WORDS,
    )  # fmt: skip


def _no_distortion(waves: dict[str, PlaneWave]) -> Item:
    return Item(
        "“Nor is a distortion of the pulse’s shape noticeable after it has passed into the discrete region”",
        "section 3, figure 6, b",
        [absent(f"{name}: difference at x = 0.25 m", 100.0 * one.misfit(_IN_AUTOMATA, False)) for name, one in waves.items()],
        remark="L2 difference over time to the wave equation’s solution, with no shift in time taken out.",
        reason=NOT_SEEN_WORDS,
    )  # fmt: skip


def _there_and_back(waves: dict[str, PlaneWave]) -> Item:
    values: list[Value] = []
    for packing, wave in waves.items():
        values.append(absent(f"{packing}: difference at x = 0.15 m", 100.0 * wave.misfit(_BEFORE, True)))
        lost = 100.0 * (1.0 + float(wave.velocity[:, _BEFORE].min()) / PEAK)
        values.append(absent(f"{packing}: height lost", lost))
    return Item(
        "The same “after reflection from the rigid rear surface of the discrete region and the way back through the interface”",
        "section 3, figure 6, b", values,
        remark="The wave has gone through the interface twice; its velocity has changed sign at the rigid side, as it must.",
        reason=NOT_SEEN_WORDS,
    )  # fmt: skip


def _momentum(waves: dict[str, PlaneWave]) -> Item:
    values = [complete(f"{packing}: momentum unaccounted for", wave.residuals["momentum"]) for packing, wave in waves.items()]
    values += [
        complete(f"{packing}: works of the two parts differ by", wave.residuals["work"]) for packing, wave in waves.items()
    ]
    return Item(
        "“The algorithm ensures the complete transfer of momentum in the absence of shear”", "section 3", values,
        remark=f"Over the largest momentum and the largest work in the run. {EXACT_SUM} It holds with shear, too: see figure "
        "7.",
    )  # fmt: skip


def _energy(waves: dict[str, PlaneWave]) -> Item:
    return Item(
        "“At the interface neither loss nor generation of energy occurs”: plane wave", "abstract",
        [complete(f"{packing}: energy unaccounted for", wave.residuals["energy"]) for packing, wave in waves.items()],
        remark="Residual of the energy balance of the whole run over the largest kinetic energy; the balance holds the term of "
        f"leapfrog, −h²/8 Σ F²/m. {EXACT_SUM}",
    )  # fmt: skip


def _small_automata(waves: dict[str, PlaneWave], coarse: dict[str, PlaneWave]) -> Item:
    values: list[Value] = []
    for packing in _WAVES:
        fine, wide = (one[packing].misfit(_IN_AUTOMATA, False) for one in (waves, coarse))
        values.append(Value(
            f"{packing}: twice the size, difference in automata", "tends to the continuum", "tends to the continuum"
            if wide > fine else "does not",
        ))  # fmt: skip
        values.append(Value(f"{packing}: so many times larger", None, wide / fine, digits=2))
    return Item(
        "“As the size of automata tends to zero”, the method “passes to the classical relations of continuum mechanics”",
        "section 1, of the authors’ [10]", values,
        remark="The difference at x = 0.25 m with cells and automata of twice the size over that of this page; 4 is second "
        "order.",
    )  # fmt: skip


def _figure(packing: str, wave: PlaneWave) -> Figure:
    curves: list[Curve] = []
    names: list[tuple[float, str]] = []
    for number, place in enumerate(PLACES):
        ground = -_APART * number
        part = "grid" if place < 0.2 else "interface" if place == 0.2 else "automata"
        names.append((ground, f"{part}\n{place:g} m"))
        label = ("", "")
        if number == 0:
            label = (f"computed, {packing} packing", "exact, without an interface")
        curves.append(Curve(label[0], wave.times * 1e6, wave.velocity[:, number] / PEAK + ground, "line", 0))
        curves.append(Curve(label[1], wave.times * 1e6, wave.exact(float(wave.places[number])) / PEAK + ground, "dashed", 1))
    letter = "Figure 6, b" if packing == "square" else "Figure 6, b, close packing"
    return Figure(
        f"figure-6-{packing}", f"{letter}: velocity at successive points",
        "A push of 40 µs on the left goes through the interface into the automata, is turned round by their rigid side, and "
        "comes back through the interface. Each curve is drawn about its own line; its height is 0.1 m/s.",
        Axis("time, µs", 0.0, 160.0), Axis("", names=names), curves,
    )  # fmt: skip


ENTRY = Entry(
    "3-figure-6",
    "3",
    "Figure 6: a plane wave through the interface and back",
    "The left half of a block is a grid, the right half automata of the same size, in a square or a close packing. Its left "
    "side is pushed; its right side is rigid; the other sides make it endless. The material is the same everywhere, so that "
    "the interface should not be noticed.",
    compute,
    weight=12.0,
    runs=4,
)
