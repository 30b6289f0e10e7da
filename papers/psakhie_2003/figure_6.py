"""Section 3, figure 6: a plane wave through the interface and back

The left half of a block is a grid, the right half automata of the same size, in a square or a close packing. Its left side is
driven, its right side is rigid, and the other sides are planes of symmetry. The material is the same everywhere, so the
interface should have no effect.
"""

from typing import Any, NamedTuple

import numpy as np

from granular_env.components.drawables import Points
from granular_env.components.support.float_arrays import FloatArray
from granular_env.experiments import load_experiment
from half_space import BY_EYE, CELLS, NOT_SEEN, P_SPEED, PULSE, ROW, internal_step, smooth_pulse
from pages import Page, record, show

# Length of the grid [m], length [s] and peak [m/s] of the pulse; positions [m] before, at and behind the interface.
LENGTH, DURATION, PEAK = 0.2, 4e-5, 0.1
PLACES = (0.05, 0.15, 0.2, 0.25, 0.35)
NAMES = {"square": "plane-wave-coupled", "hexagonal": "plane-wave-hexagonal"}
ACROSS, EVERY = 8, 1e-6


class PlaneWave(NamedTuple):
    """Velocities along the path of the wave, shape (frames, places); `end` is the position of the rigid side [m]."""

    times: FloatArray
    velocity: FloatArray
    places: FloatArray
    end: float
    log: Any

    def exact(self, number: int) -> FloatArray:
        """Return the velocities of the incident and the reflected wave at a position [m/s]."""
        place = self.places[number]
        return pulse(self.times - place / P_SPEED) - pulse(self.times - (2.0 * self.end - place) / P_SPEED)

    def misfit(self, number: int, returned: bool) -> float:
        """Return the relative L2 difference from the exact solution at a position, for the incident or reflected wave [%]."""
        own = (self.times >= self.end / P_SPEED + 0.5 * DURATION) == returned
        exact = self.exact(number)[own]
        return 100.0 * float(np.sqrt(((self.velocity[own, number] - exact) ** 2).sum() / (exact**2).sum()))

    def relative_residual(self, residual: str, amount: str) -> float:
        """Return the largest residual divided by the largest amount."""
        return float(np.abs(self.log.series(residual)[1]).max() / np.abs(self.log.series(amount)[1]).max())


def pulse(time: FloatArray) -> FloatArray:
    """Return the velocity of the driven side [m/s]."""
    return PEAK * np.polynomial.Polynomial(PULSE)(np.clip(time / DURATION, 0.0, 1.0))


def plane_wave(packing: str, coarser: int = 1) -> PlaneWave:
    """Run the shipped experiment with finer cells."""
    document = load_experiment(f"psakhie-2003/{NAMES[packing]}").to_dict()
    component, axis = document["component"], int(packing == "hexagonal")
    along = 4 * round(20 * CELLS / (272 * coarser))
    size = LENGTH / along
    ordered = (lambda one, other: (other, one)) if axis else (lambda one, other: (one, other))
    columns, rows = ordered(along, ACROSS)
    component["grid"]["mesh"] |= {"columns": columns, "rows": rows, "cell_size": size}
    component["grid"]["receivers"] = [ordered(place, 0.5 * ACROSS * size) for place in PLACES[:3]]
    spacing = size * (ROW if axis else 1.0)
    width, height = ordered(round(LENGTH / spacing) * spacing, ACROSS * size)
    component["automata"]["shape"] |= {"width": width, "height": height}
    component["automata"]["diameter"] = size
    component["step_size"] = internal_step(size, EVERY)
    [driven] = document["input"]
    document["input"] = {driven: smooth_pulse(PEAK, DURATION, ordered(1.0, 0.0))}
    names = ["grid_receiver_velocity", "automata_velocity", "interface_work_on_grid", "interface_work_difference"]
    log = record(document | {"record": {"every": EVERY, "variables": names}, "duration": 1.6e-4})
    [points] = [np.array(one.reference) for one in log.drawables if isinstance(one, Points) and one.name == "automata"]
    times, received = log.series("grid_receiver_velocity")
    nearest = [int(np.hypot(*(points - ordered(place, 0.5 * ACROSS * size)).T).argmin()) for place in PLACES[3:]]
    velocity = np.hstack([received[:, :, axis], log.series("automata_velocity")[1][:, nearest, axis]])
    places = np.array([*PLACES[:3], *points[nearest, axis]])
    return PlaneWave(times, velocity, places, float(points[:, axis].max()), log)


# Packing -> residual velocity, difference behind the interface, difference and height loss after return, coarser cells.
FOUND = {"square": ("0.11", "0.18", "0.58", "0.011", "4.2"), "hexagonal": ("0.11", "0.16", "0.46", "0.13", "4.2")}


def main(page: Page) -> None:
    """Compare both packings with the solution of the wave equation, and with cells of twice the size."""
    for packing, (behind, there, back, lost, coarse) in FOUND.items():
        wave = plane_wave(packing)
        unseen = {"near": 0.0, "within": NOT_SEEN, "reading": f"below {NOT_SEEN:g} %"}
        quiet = (wave.times > 0.15 / P_SPEED + DURATION) & (wave.times < (2.0 * wave.end - 0.15) / P_SPEED)
        left = 100.0 * float(np.abs(wave.velocity[quiet, 1]).max()) / PEAK
        page.add_heading(f"{packing.capitalize()} packing")
        page.compare("no reflected wave: residual velocity at 0.15 m", "not noticeable", left, "%", **unseen, found=behind)
        page.compare(
            "no distortion at 0.25 m, in the automata", "not noticeable", wave.misfit(3, False), "%", **unseen, found=there
        )
        page.compare("the same at 0.15 m after the return", "not noticeable", wave.misfit(1, True), "%", **unseen, found=back)
        height = 100.0 * (1.0 + float(wave.velocity[:, 1].min()) / PEAK)
        page.compare("height lost after the return", "not noticeable", height, "%", **unseen, found=lost)
        for what, residual, amount in (
            ("transfer of momentum: missing", "momentum_residual", "momentum"),
            ("works of the two parts: difference", "interface_work_difference", "interface_work_on_grid"),
            ("no loss of energy: missing", "energy_residual", "kinetic_energy"),
        ):
            page.compare(what, "none", wave.relative_residual(residual, amount), near=0.0, within=1e-10)
        larger = plane_wave(packing, coarser=2).misfit(3, False) / wave.misfit(3, False)
        limit = "tends to the continuum" if larger > 1.0 else "does not"
        page.compare("as the size of automata tends to zero", "tends to the continuum", limit)
        page.add_value("difference at 0.25 m with twice the size, relative to this size", larger, found=coarse)
        with page.plot(f"Figure 6 b, {packing} packing: velocity at five places. A pulse of 40 µs crosses the interface, "
                       "is reflected by the rigid side, and returns.", "time, µs", "") as axes:  # fmt: skip
            for number in range(len(PLACES)):
                ground = -1.5 * number
                axes.plot(
                    1e6 * wave.times, wave.velocity[:, number] / PEAK + ground, "C0", label=None if number else "computed"
                )
                axes.plot(1e6 * wave.times, wave.exact(number) / PEAK + ground, "C1--", label=None if number else "exact")
            names = [f"{'grid' if x < LENGTH else 'interface' if x == LENGTH else 'automata'}, {x:g} m" for x in PLACES]
            axes.set_yticks([-1.5 * number for number in range(len(PLACES))], names)
    page.text(f"""{BY_EYE} Velocities are relative to the peak of the wave. Differences are L2 differences over time from the
        solution of the wave equation, without correction of a time shift. Residuals of the balances are relative to the
        largest amounts; values below 1e-10 are rounding errors. The energy balance includes the leapfrog term, -h²/8 Σ F²/m.
        Doubling the size makes the difference four times larger: second order.""")


if __name__ == "__main__":
    show(main)
