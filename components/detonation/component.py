"""The gas in the tube as a component: reactive Euler equations in one dimension with a cross-section A(x, t)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from ..balances import Balance
from ..component import Component
from ..drawables import Cells, Curve, Drawable
from ..errors import ParameterError, StepError
from ..events import EventDetail
from ..support.float_arrays import FloatArray
from ..support.round_numbers import round_down_to_125
from ..variables import Variable
from . import ignition, kernel_arrays, kernels, moving_mesh
from .boundaries import DIAPHRAGM, OPEN, PISTON
from .chapman_jouguet import Detonation, Flow, chapman_jouguet
from .input_signals import area_pattern, tick_signals
from .kernel_arrays import Events, Medium, State, Tables, Tube
from .limiters import LIMITERS
from .parameters import DetonationParameters

# Courant number of the default step, for the fastest expected wave.
_SUGGESTED_COURANT = 0.5
# Courant number of the smaller step that an error message advises.
_ADVISED_COURANT = 0.7
# Speed of the fastest expected waves: in a reacting gas (reflected detonation) divided by the detonation speed; in an inert gas
# divided by the speed of sound in its hottest region.
_DETONATION_WAVES, _SOUND_WAVES = 1.3, 2.5
# Memory per cell for state, scratch, tables and temporary arrays of the build: 488 bytes measured.
_BYTES_OF_CELL = 500
# Largest and smallest number of cells over which the front speed is measured. With a burn zone of a few cells, the arrival time
# in a cell is uncertain by a tenth of the time in which the front crosses the cell.
_SPEED_CELLS, _LEAST_SPEED_CELLS = 50, 10
# Smallest and largest length of a tube with pistons, as fractions of the initial length.
_SHORTEST, _LONGEST = 1e-9, 1e9
_STATE = ("density", "momentum", "energy", "fuel", "velocity", "pressure", "progress", "area", "arrival", "flags")


class DetonationTube(Component):
    """A reactive gas in a tube, in one dimension: the detonation of Gato & Shie (2010).

    Euler's equations with a cross-section A(x, t) and one reaction. See `DetonationParameters`.
    """

    name = "detonation"
    version = 3
    Parameters = DetonationParameters
    parameters: DetonationParameters
    # In the order in which `kernels` numbers the kinds.
    event_kinds = {
        "diaphragm_opened": "the pressure on a diaphragm reached its bursting pressure; index 0: left, 1: right",
        "end_reached": "half of the gas at an end had reacted, after ignition elsewhere; index 0: left, 1: right",
        "front_passed": "half of the gas at a gauge had reacted; index: number of the gauge",
        "ignited": "half of the gas in a cell had reacted, for the first time in any cell; index: number of the cell",
    }
    event_details = {
        "diaphragm_opened": EventDetail("Pa"), "end_reached": EventDetail("1"), "front_passed": EventDetail("1"),
        "ignited": EventDetail("1"),
    }  # fmt: skip

    # -- building ---------------------------------------------------------------------------------------------------

    @classmethod
    def memory_needed(cls, parameters: DetonationParameters) -> int:
        """Return the largest memory needed at a time during building and stepping [bytes]."""
        return _BYTES_OF_CELL * parameters.cells

    def _build_system(self) -> None:
        p = self.parameters
        self.gas = p.chosen_gas
        # Positions of and pressures on the ends; position of each cell when the front passed; in the state if an end moves.
        self._walls: FloatArray = np.array([0.0, p.length, 0.0, 0.0])
        self._places: FloatArray = np.zeros(p.cells)
        self.ahead = Flow(p.initial_pressure / (self.gas.gas_constant * p.initial_temperature), 0.0, p.initial_pressure)
        self.front: Detonation = chapman_jouguet(self.gas, p.initial_pressure, self.ahead.density)
        self.areas: FloatArray = np.full(p.cells, 1.0) * np.array(p.cross_section)
        self.step_size = p.step_size or round_down_to_125(self.longest_suggested_step)
        self._medium = Medium(
            self.gas.gamma, self.gas.gas_constant, self.gas.heat_release, p.cell_size, self.step_size, LIMITERS[p.limiter],
            p.initial_temperature,
        )  # fmt: skip
        self._tube = self._make_tube()
        self._scratch = kernel_arrays.make_scratch(p.cells)
        self._failed = np.zeros(2, dtype=np.int64)
        self._lay_out_state()

    @property
    def longest_suggested_step(self) -> float:
        """Default step before rounding [s]: half a cell per step for the fastest expected wave."""
        p = self.parameters
        hottest = max([p.initial_temperature, *(one.temperature or p.initial_temperature for one in p.regions)])
        fastest = max(abs(one.velocity) for one in p.regions) if p.regions else 0.0
        waves = _SOUND_WAVES * float(np.sqrt(self.gas.gamma * self.gas.gas_constant * hottest)) + fastest
        if self.gas.heat_release > 0.0:
            waves = max(waves, _DETONATION_WAVES * self.front.speed)
        return _SUGGESTED_COURANT * self.cell_size / waves

    def _make_tube(self) -> Tube:
        p, n = self.parameters, self.parameters.cells
        constants = p.chosen_reaction.constants(self.gas, self.front, (p.initial_pressure, self.ahead.density), p.cell_size)
        gauges = np.full(n, -1, dtype=np.int64)
        gauges[p.gauge_cells] = np.arange(len(p.gauges))
        return Tube(
            ends=np.array([p.left.code, p.right.code]),
            burst=np.array([getattr(end, "burst_pressure", 0.0) for end in (p.left, p.right)]),
            reaction=constants,
            heated=np.array(self._cells_between(*p.ignition_zone)),
            gauges=gauges,
        )

    def _cells_between(self, begin: float, end: float) -> tuple[int, int]:
        """Return the first cell with its centre in the interval and the cell after the last; without any, the nearest cell."""
        first, last = (int(number) for number in np.searchsorted(self.centres, [begin, end]))
        if first == last:
            first = int(np.abs(self.centres - 0.5 * (begin + end)).argmin())
        return first, max(last, first + 1)

    def _lay_out_state(self) -> None:
        n = self.parameters.cells
        moving: dict[str, Any] = (
            {"walls": ("f8", (moving_mesh.WALLS,)), "places": ("f8", (n,))} if self.parameters.has_pistons else {}
        )
        self._define_state(
            density=("f8", (n,)), momentum=("f8", (n,)), energy=("f8", (n,)), fuel=("f8", (n,)), velocity=("f8", (n,)),
            pressure=("f8", (n,)), progress=("f8", (n,), 0.0, 1.0), area=("f8", (n,)), arrival=("f8", (n,)),
            flags=("i8", (kernel_arrays.FLAGS,), 0, 1), tally=("f8", (kernel_arrays.TALLY,)), start=("f8", (3,)), **moving,
        )  # fmt: skip
        self._state = State(*(self._block[name] for name in _STATE))
        if self.parameters.has_pistons:
            self._walls, self._places = self._block["walls"], self._block["places"]

    def _state_contradiction(self, state: Mapping[str, np.ndarray]) -> str:
        if self.parameters.has_pistons:
            left, right = state["walls"][:2].tolist()
            if not _SHORTEST < (right - left) / self.parameters.length < _LONGEST:
                return f"got a tube from {left:g} to {right:g} m"
        return ""

    @property
    def centres(self) -> FloatArray:
        """Present positions of the cell centres, shape (n,) [m]."""
        return np.asarray(self._walls[moving_mesh.LEFT] + (np.arange(self.parameters.cells) + 0.5) * self.cell_size)

    @property
    def cell_size(self) -> float:
        """Present length of a cell [m]."""
        return float(self._walls[moving_mesh.RIGHT] - self._walls[moving_mesh.LEFT]) / self.parameters.cells

    # -- the contract -----------------------------------------------------------------------------------------------

    def _declare_variables(self) -> Iterable[Variable]:
        p, n, cells, gauges = self.parameters, self.parameters.cells, ("cell",), ("gauge",)
        text = "heating power, distributed uniformly over the ignition zone"
        yield Variable("ignition_power", "input", "W", (), text, start=0.0, minimum=0.0, nominal=1e6)
        if p.has_pistons:
            yield from self._declare_pistons()
        else:
            yield Variable(
                "area", "input", "m^2", (n,), "cross-section of each cell; moving walls do work on the gas",
                start=float(self.areas[0]), minimum=0.0, axes=cells, nominal=float(self.areas.mean()),
            )  # fmt: skip
        for name, end in (("left", p.left), ("right", p.right)):
            if end.code in (OPEN, DIAPHRAGM):
                yield Variable(
                    f"{name}_pressure", "input", "Pa", (), f"pressure of the room beyond the {name} end",
                    start=p.initial_pressure, minimum=0.0, nominal=p.initial_pressure,
                )  # fmt: skip
        for name, unit, text in (
            ("density", "kg/m^3", "density"), ("velocity", "m/s", "velocity along x"), ("pressure", "Pa", "pressure"),
            ("progress", "1", "fraction of the gas that has reacted"),
        ):  # fmt: skip
            least = -np.inf if name == "velocity" else 0.0
            nominal = getattr(self.front.burnt, name, 1.0)
            yield Variable(name, "output", unit, (n,), text, minimum=least, state=True, axes=cells, nominal=nominal or 1.0)
        yield Variable("temperature", "output", "K", (n,), "p / (rho R), with R of the unburnt gas", minimum=0.0, axes=cells)
        yield Variable("arrival_time", "output", "s", (n,), "time at which half of the gas had reacted, else -1", axes=cells)
        yield Variable("left_front", "output", "m", (), "left end of the burnt gas; 0 if no gas has burnt")
        yield Variable("right_front", "output", "m", (), "right end of the burnt gas; 0 if no gas has burnt")
        yield Variable(
            "front_speed", "output", "m/s", (), f"speed of the front over its last {_SPEED_CELLS} cells; 0 if unknown"
        )
        yield Variable("cj_ratio", "output", "1", (), "front_speed / speed of the Chapman-Jouguet detonation")
        seen = ", with u relative to the moving cell" if p.has_pistons else ""
        yield Variable("courant_number", "output", "1", (), f"largest (|u| + c) dt / dx{seen}", minimum=0.0)
        yield Variable("gauge_pressure", "output", "Pa", (len(p.gauges),), "pressure at the `gauges`", axes=gauges)
        yield Variable("gauge_velocity", "output", "m/s", (len(p.gauges),), "velocity at the `gauges`", axes=gauges)

    def _declare_pistons(self) -> Iterable[Variable]:
        """Yield the additional variables of a tube with a piston at one end or both."""
        p, n = self.parameters, self.parameters.cells
        for name, end in (("left", p.left), ("right", p.right)):
            if end.code == PISTON:
                yield Variable(f"{name}_velocity", "input", "m/s", (), f"velocity along x of the piston at the {name} end")
                yield Variable(f"{name}_position", "output", "m", (), f"position of the {name} piston")
                yield Variable(
                    f"{name}_piston_pressure", "output", "Pa", (), f"mean pressure on the {name} piston over the last tick",
                    minimum=0.0, nominal=p.initial_pressure,
                )  # fmt: skip
        yield Variable("cell_position", "output", "m", (n,), "positions of the cell centres", axes=("cell",))
        yield Variable(
            "outline_displacement", "output", "m", (2 * (n + 1), 2), "displacements of the cell corners, for drawing",
            axes=("corner", "direction"),
        )  # fmt: skip

    def _piston_outputs(self) -> dict[str, Callable[[], Any]]:
        p, walls = self.parameters, self._walls
        found: dict[str, Callable[[], Any]] = {
            "cell_position": lambda: self.centres,
            "outline_displacement": self._outline_displacement,
        }
        for side, (name, end) in enumerate((("left", p.left), ("right", p.right))):
            if end.code == PISTON:
                found[f"{name}_position"] = lambda side=side: walls[moving_mesh.LEFT + side]
                found[f"{name}_piston_pressure"] = lambda side=side: walls[moving_mesh.LEFT_WALL_PRESSURE + side]
        return found

    def _outline_displacement(self) -> FloatArray:
        """Return the displacements of the cell corners, lower ones first, shape (2 (n + 1), 2) [m]."""
        p, walls = self.parameters, self._walls
        moved = np.linspace(walls[moving_mesh.LEFT], walls[moving_mesh.RIGHT] - p.length, p.cells + 1)
        return np.stack([np.tile(moved, 2), np.zeros(2 * (p.cells + 1))], axis=1)

    def _output_readers(self) -> dict[str, Callable[[], Any]]:
        state, gauges = self._state, self.parameters.gauge_cells
        moving = self._piston_outputs() if self.parameters.has_pistons else {}
        return moving | {
            "temperature": lambda: state.pressure / (state.density * self.gas.gas_constant),
            "arrival_time": lambda: state.arrival,
            "left_front": lambda: self.fronts()[0],
            "right_front": lambda: self.fronts()[1],
            "front_speed": self._front_speed,
            "cj_ratio": lambda: self._front_speed() / self.front.speed,
            "courant_number": lambda: float(self._courant_numbers(self._tick).max()),
            "gauge_pressure": lambda: state.pressure[gauges],
            "gauge_velocity": lambda: state.velocity[gauges],
        }

    @np.errstate(all="ignore")
    def _courant_numbers(self, tick: int | None = None) -> FloatArray:
        """Return (|u| + c) dt / dx, shape (n,); u is relative to the cells, which move as in the tick beginning at `tick`."""
        state, n = self._state, self.parameters.cells
        left, right = (0.0, 0.0) if tick is None else self._end_velocities(tick)
        relative = state.velocity - (left + (right - left) * (np.arange(n) + 0.5) / n)
        speeds = np.abs(relative) + np.sqrt(self.gas.gamma * state.pressure / state.density)
        return speeds * self.step_size / self.cell_size

    def _end_velocities(self, tick: int) -> tuple[float, float]:
        """Return the velocities of both ends in the tick that begins at `tick`, 0 for an end at rest [m/s]."""
        left, right = tick_signals(self._held, tick, 1)[0, kernel_arrays.LEFT_VELOCITY : kernel_arrays.RIGHT_VELOCITY + 1]
        return float(left), float(right)

    def fronts(self) -> tuple[float, float]:
        """Return the first and last positions at which the progress passes 1/2, interpolated linearly between cells [m]."""
        progress = self._state.progress
        burnt = np.flatnonzero(progress >= kernels.BURNT)
        if not len(burnt):
            return 0.0, 0.0
        first, last = int(burnt[0]), int(burnt[-1])
        begin, end = self._walls[moving_mesh.LEFT], self._walls[moving_mesh.RIGHT]
        if first > 0:
            part = (progress[first] - kernels.BURNT) / (progress[first] - progress[first - 1])
            begin = self.centres[first] - part * self.cell_size
        if last + 1 < len(progress):
            part = (progress[last] - kernels.BURNT) / (progress[last] - progress[last + 1])
            end = self.centres[last] + part * self.cell_size
        return float(begin), float(end)

    def _front_speed(self) -> float:
        """Return the speed of the front that runs to the right or, if there is none, to the left [m/s]."""
        reached = np.flatnonzero(self._state.arrival >= 0.0)
        if len(reached) < _LEAST_SPEED_CELLS:
            return 0.0
        first, last = int(reached[0]), int(reached[-1])
        return self._mean_front_speed(max(first, last - _SPEED_CELLS), last) or self._mean_front_speed(
            min(last, first + _SPEED_CELLS), first
        )

    def _mean_front_speed(self, earlier: int, later: int) -> float:
        """Return the mean speed of a front from one cell to another [m/s], or 0 if no front ran in this direction."""
        begin, end = (float(self._state.arrival[cell]) for cell in (earlier, later))
        way = abs(later - earlier) * self.cell_size
        if self.parameters.has_pistons:
            way = abs(float(self._places[later] - self._places[earlier]))
        return way / (end - begin) if end > begin >= 0.0 else 0.0

    def _write_start_state(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        state, gas = self._state, self.gas
        self._walls[:] = 0.0, self.parameters.length, 0.0, 0.0
        self._fill_regions()
        super()._write_start_state(seed, values)
        self._refuse_invalid_start()
        state.area[:] = values.get("area", self.areas)
        self._walls[moving_mesh.LEFT_WALL_PRESSURE :] = state.pressure[0], state.pressure[-1]
        state.momentum[:] = state.density * state.velocity
        state.fuel[:] = state.density * (1.0 - state.progress)
        state.energy[:] = (
            state.pressure / (gas.gamma - 1.0) + 0.5 * state.momentum * state.velocity + state.fuel * gas.heat_release
        )
        burnt = state.progress >= kernels.BURNT
        state.arrival[:] = np.where(burnt, 0.0, -1.0)
        self._places[:] = np.where(burnt, self.centres, moving_mesh.NOWHERE)
        state.flags[:] = 0
        state.flags[kernel_arrays.LEFT_OPEN] = self.parameters.left.code == OPEN
        state.flags[kernel_arrays.RIGHT_OPEN] = self.parameters.right.code == OPEN
        state.flags[kernel_arrays.IGNITED] = burnt.any()
        sums = self._stored_amounts()
        self._block["start"][:] = sums["mass"], sums["momentum"], sums["energy"]
        return {} if self.parameters.has_pistons else {"area": self.areas}

    def _fill_regions(self) -> None:
        p, state = self.parameters, self._state
        state.density[:], state.pressure[:] = self.ahead.density, p.initial_pressure
        for region in p.regions:
            cells = slice(*self._cells_between(*region.x))
            pressure = p.initial_pressure if region.pressure is None else region.pressure
            temperature = p.initial_temperature if region.temperature is None else region.temperature
            state.density[cells] = pressure / (self.gas.gas_constant * temperature)
            state.pressure[cells] = pressure
            state.velocity[cells], state.progress[cells] = region.velocity, region.progress

    def _refuse_invalid_start(self) -> None:
        state, above_zero = self._state, "more than 0 everywhere: give an array, or use the parameter `regions`"
        for name, values, sound, expected in (
            ("density", state.density, state.density > 0.0, above_zero),
            ("pressure", state.pressure, state.pressure > 0.0, above_zero),
            ("progress", state.progress, (state.progress >= 0.0) & (state.progress <= 1.0), "0 to 1"),
        ):
            if not sound.all():
                cell = int(np.argmin(sound))
                raise ParameterError(f"got {values[cell]:g}", expected=expected, at=("start", name, cell))
        numbers = self._courant_numbers()
        cell = int(numbers.argmax())
        if not numbers[cell] <= kernels.LARGEST_COURANT:
            raise ParameterError(
                f"got {self.step_size:g} s: at the start, waves in cell {cell} cross {numbers[cell]:.4g} cells in a step",
                expected=f"at most {kernels.LARGEST_COURANT * self.step_size / numbers[cell]:.4g} s",
                hint="give a smaller step_size, or a start with slower waves",
                at="step_size",
            )

    def tables(self) -> Tables:
        """Return the arrays of the kernels, for a parent component that calls the kernels directly."""
        return Tables(self._medium, self._tube, self._state, self._scratch, self._block["tally"])

    def _advance_state(self, ticks: int) -> int:
        signals = tick_signals(self._held, self._tick, ticks)
        used = np.array([self._block.count("events")])
        # A run has at most one event for each gauge, for the first ignition, for each end and for each diaphragm.
        events = Events(self._block.reserve_rows("events", len(self.parameters.gauges) + 5), used)
        tables, tick, failed = self.tables(), self._tick, self._failed
        if self.parameters.has_pistons:
            status = moving_mesh.advance(tables, self._walls, self._places, signals, tick, events, failed)
        else:
            status = kernels.advance(tables, signals, area_pattern(self._held), tick, events, failed)
        self._block.set_row_count("events", int(used[0]))
        return int(status)

    def _step_error(self, status: int) -> StepError:
        cell, tick = (int(number) for number in self._failed)
        time, state = tick * self.step_size, self._state
        where = f"in cell {cell}, x = {self.centres[cell]:.6g} m, at {time:.9g} s"

        def limit_error(name: str, value: float, limit: float, description: str, index: int | None = cell) -> StepError:
            return StepError(description, time=time, at=name, variable=name, index=index, value=value, limit=limit)

        if status in (kernel_arrays.TOO_FAST, kernel_arrays.TOO_FAST_AHEAD):
            value, limit = float(self._courant_numbers(tick - 1)[cell]), kernels.LARGEST_COURANT
            if status == kernel_arrays.TOO_FAST:  # the smaller of the two Courant numbers decides, see `kernels.finish_tick`
                value = min(value, float(self._courant_numbers()[cell]))
            fits = f"{_ADVISED_COURANT * self.step_size / value:.2g} s or less, now {self.step_size:g} s"
            said = f"reached {value:.4g} {where}, expected at most {limit:g}; take a step_size of {fits}"
            return limit_error("courant_number", value, limit, said, None)
        if status == kernel_arrays.ENDS_TOO_FAST:
            left, right = self._end_velocities(tick - 1)
            half, closing = 0.5 * self.parameters.cells * self.cell_size, (left - right) * self.step_size
            name, value, limit = "left_velocity", left, right + half / self.step_size
            if left <= -right:
                name, value, limit = "right_velocity", right, left - half / self.step_size
            said = (
                f"got {value:g} m/s: the ends would approach by {closing:.4g} m in the step to {time:.9g} s, expected less "
                f"than {half:.4g} m, half of their distance; take slower pistons, or a smaller step_size"
            )
            return limit_error(name, value, limit, said, None)
        if status == kernel_arrays.BAD_AREA:
            now = float(state.area[cell])
            value = float(tick_signals(self._held, tick - 1, 1)[0, kernel_arrays.AREA] * area_pattern(self._held)[cell])
            limit = now / kernel_arrays.LARGEST_RATIO if value < now else now * kernel_arrays.LARGEST_RATIO
            said = f"got {value:g} m^2 {where}, expected half to twice the previous {now:g} m^2; move the walls more slowly"
            return limit_error("area", value, limit, said)
        name = "pressure" if state.density[cell] > 0.0 else "density"
        value = float(getattr(state, name)[cell])
        said = f"fell to {value:g} {self.variables[name].unit} {where}, expected more than 0"
        return limit_error(name, value, 0.0, f"{said}; take a smaller step_size, or the limiter minmod")

    # -- reading ----------------------------------------------------------------------------------------------------

    @property
    def mass(self) -> float:
        """Present mass of the gas in the tube [kg]."""
        return self._stored_amounts()["mass"]

    @np.errstate(all="ignore")
    def _stored_amounts(self) -> dict[str, float]:
        state = self._state
        volume = state.area * self.cell_size
        energy = float((state.energy * volume).sum())
        kinetic = float((0.5 * state.momentum * state.velocity * volume).sum())
        chemical = float((state.fuel * volume).sum()) * self.gas.heat_release
        mass, momentum = float((state.density * volume).sum()), float((state.momentum * volume).sum())
        return {"mass": mass, "momentum": momentum, "energy": energy, "kinetic": kinetic, "chemical": chemical}

    def balances(self) -> tuple[Balance, ...]:
        """Return the balances of energy, momentum and mass since the reset."""
        sums, tally, start = self._stored_amounts(), self._block["tally"].tolist(), self._block["start"].tolist()
        stored = {
            "internal_energy": sums["energy"] - sums["kinetic"] - sums["chemical"],
            "kinetic_energy": sums["kinetic"],
            "chemical_energy": sums["chemical"],
        }
        supplied = {
            "ignition_energy": tally[kernel_arrays.IGNITION],
            "left_energy": tally[kernel_arrays.ENERGY],
            "right_energy": tally[kernel_arrays.ENERGY + 1],
            "wall_work": tally[kernel_arrays.WALL_WORK],
            "overwritten_energy": tally[kernel_arrays.OVERWRITTEN],
        }
        impulse = {
            "left_impulse": tally[kernel_arrays.IMPULSE],
            "right_impulse": tally[kernel_arrays.IMPULSE + 1],
            "wall_impulse": tally[kernel_arrays.WALL_IMPULSE],
        }
        came = {"left_mass": tally[kernel_arrays.MASS], "right_mass": tally[kernel_arrays.MASS + 1]}
        return (
            Balance("energy", "J", stored, supplied, initial=start[2]),
            Balance("momentum", "kg m/s", {"momentum": sums["momentum"]}, impulse, initial=start[1]),
            Balance("mass", "kg", {"mass": sums["mass"]}, came, initial=start[0]),
        )

    def report(self) -> dict[str, float]:
        """Return the Courant number, and the front's speed and pressure relative to the Chapman-Jouguet detonation."""
        return {
            "largest Courant number now": self.get("courant_number"),
            "front speed / Chapman-Jouguet speed": self.get("cj_ratio"),
            "largest pressure now / Chapman-Jouguet pressure": float(self._state.pressure.max()) / self.front.burnt.pressure,
        }

    @property
    def missing_detonation(self) -> str:
        """Description of gas that could detonate but has not ignited, is extinguished or burns slowly; otherwise ""."""
        return ignition.missing_detonation_text(self)

    @property
    def unburnt_fraction(self) -> float:
        """Unreacted fraction of the gas in the tube."""
        state = self._state
        return float((state.fuel * state.area).sum() / (state.density * state.area).sum())

    def conclusions(self) -> list[str]:
        """Return a sentence that states whether, where and when the gas ignited, and the unburnt fraction."""
        return [ignition.ignition_conclusion(self)]

    def cautions(self) -> list[str]:
        """Return cautions about gas that does not burn, and about assumptions of the reaction law."""
        return [*ignition.ignition_cautions(self), *self.parameters.chosen_reaction.cautions(self.cell_size)]

    def drawables(self) -> tuple[Drawable, ...]:
        """Return a side view of the tube, coloured by pressure, and curves of pressure, velocity, temperature and progress."""
        radius = np.sqrt(self.areas / np.pi)
        radius = np.concatenate([radius[:1], 0.5 * (radius[1:] + radius[:-1]), radius[-1:]])
        x, n = np.arange(len(radius)) * self.parameters.cell_size, len(self.areas)
        nodes: FloatArray = np.array([*zip(x, -radius, strict=True), *zip(x, radius, strict=True)], dtype=np.float64)
        below = np.arange(n)
        cells = np.stack([below, below + 1, below + n + 2, below + n + 1], axis=1)
        fields = ("pressure", "velocity", "temperature", "progress")
        moved = "outline_displacement" if self.parameters.has_pistons else ""
        middles = np.asarray((below + 0.5) * self.parameters.cell_size, dtype=np.float64)
        curves = (Curve(name, middles, name) for name in fields)
        return Cells("tube", nodes, cells, "pressure", moved), *curves
