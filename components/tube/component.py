"""The gas in a tube and a deformable section of the tube as one component: both advance in one tick, in one memory."""

from __future__ import annotations

import dataclasses
import gc
import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from ..balances import Balance
from ..component import Component
from ..detonation.component import DetonationTube
from ..drawables import Cells, Drawable, Points
from ..errors import Fault, ParameterError, StepError
from ..events import EventDetail
from ..inputs import input_mean
from ..parts import Part, make_part, part_drawable, part_readers, part_values, part_variables
from ..shell.component import Shell
from ..support.float_arrays import FloatArray, ordered_sum, ordered_sum_of_rows
from ..variables import Variable
from . import balances, exchange
from .interface_overlaps import Interface, find_overlaps
from .parameters import MOST_STEPS, TubeParameters

# Number of state words above which the memory of an unused component is collected at once.
_LARGE_STATE = 100_000
# Smallest load that activates the shell, as a fraction of the outside pressure; smaller loads are rounding errors.
_WAKING = 1e-9
# Status offsets of `_advance_state` for failures of the gas, the shell and the exchange; the part's own status is added.
_GAS, _SHELL, _WALL = 16, 32, 48
# Relative change of the wall's cross-section above which a caution is issued if the gas ignores the change.
_LARGE_CHANGE = 0.02
# Relative growth of the wall's cross-section above which the pressure of a gas that ignores it is no longer valid.
_LARGEST_GROWTH = 0.5
_GROWN = "cross_section_grown"


class Tube(Component):
    """A detonation in a rigid tube, a section of which is a shell: the experiment of Gato & Shie (2010).

    The gas loads the wall; with two-way coupling the motion of the wall acts back on the gas. See `TubeParameters`.
    """

    name = "tube"
    version = 6
    Parameters = TubeParameters
    parameters: TubeParameters
    event_kinds = {
        _GROWN: "the cross-section had grown by more than half, without effect on the gas; index: number of the station"
    }
    event_details = {_GROWN: EventDetail("1", ends_validity=True)}

    # -- building ---------------------------------------------------------------------------------------------------

    @classmethod
    def memory_needed(cls, parameters: TubeParameters) -> int:
        """Return the memory that both parts need."""
        return DetonationTube.memory_needed(parameters.gas) + Shell.memory_needed(parameters.shell)

    def _build_system(self) -> None:
        # Both parts are first built on their own, to obtain their steps and the sizes of their states.
        gas, shell = make_part(DetonationTube, self, "gas"), make_part(Shell, self, "shell")
        self._choose_steps(gas, shell)
        stations, words = shell.parameters.body.node_counts[0], shell.memory.size
        self._define_state(
            gas=("f8", (gas.memory.size,)), shell=("f8", (words,)), peak_pressure=("f8", (stations,)),
            widening=("f8", (stations,)), tally=("f8", (exchange.TALLY,)), awake=("i8", (1,), 0, 1),
        )  # fmt: skip
        # While the tables of the first shell exist, the second shell shares them.
        tables = shell.assembly
        del shell
        if words > _LARGE_STATE:
            gc.collect()  # a component is part of reference cycles, and would stay in memory for long
        gas_step, shell_step = self.step_size / self.gas_steps, self.step_size / self.shell_steps
        self.gas: DetonationTube = self._make_part_with_step(DetonationTube, "gas", gas_step)
        self.shell: Shell = self._make_part_with_step(Shell, "shell", shell_step)
        del tables
        self._include_part(self.gas, "gas", self.gas_steps)
        self._include_part(self.shell, "shell", self.shell_steps)
        self.interface: Interface = self._find_interface()
        # Read from the output: in a meshfree body the displacement of a node differs from the parameter of the node.
        self._rest_radii: FloatArray = self.shell.get("mean_inner_radius")
        # After a failure: the step of the gas or the shell that failed, and the cell in which the pressure vanished.
        self._failed_tick = self._failed_cell = 0

    def _choose_steps(self, gas: DetonationTube, shell: Shell) -> None:
        """Choose the internal step and the number of steps of each part in it, from the steps that the parts suggest.

        The default internal step is a round number. The steps of the parts divide it evenly and need not be round.
        """
        p = self.parameters
        self.step_size = max(gas.step_size, shell.step_size) if p.step_size is None else p.step_size
        self.gas_steps: int = p.gas_steps or self._step_count("gas", gas.longest_suggested_step)
        self.shell_steps: int = p.shell_steps or self._step_count("shell", shell.longest_suggested_step)

    def _make_part_with_step(self, kind: type[Part], part: str, step: float) -> Part:
        """Return a part in this component's memory; report a step that is too large as a fault of the number of steps."""
        try:
            return make_part(kind, self, part, step_size=step, memory=self._block[part])
        except ParameterError as error:
            fault = error.faults[0]
            if fault.location != (part, "step_size"):
                raise
            raise ParameterError(
                f"got {getattr(self, f'{part}_steps')}, steps of {step:g} s in an internal step of {self.step_size:g} s",
                expected=f"steps of {fault.expected}", hint="give more steps, or leave it out", at=f"{part}_steps",
            ) from None  # fmt: skip

    def _step_count(self, part: str, limit: float) -> int:
        """Return the number of steps of at most `limit` [s] that a part makes in an internal step."""
        steps = max(self.step_size / limit * (1.0 - 1e-9), 1.0)
        if not steps <= MOST_STEPS:
            raise ParameterError(
                f"got {steps:.4g} steps of {limit:g} s in an internal step of {self.step_size:g} s",
                expected=f"at most {MOST_STEPS}",
                hint="the stable steps of gas and shell differ too much; use cells and nodes of similar size",
                at=f"{part}_steps",
            )
        return math.ceil(steps)

    def _find_interface(self) -> Interface:
        surface, (along, ring, _) = self.shell.tables().solid.surface, self.shell.lattice.axes
        stations, bounds = along.count, along.bounds + self.parameters.position
        overlaps = find_overlaps(bounds, self.gas.cell_size, self.gas.parameters.cells)
        shares = np.tile(ring.widths / ring.widths.sum(), stations)
        rest = np.sqrt(surface.reference[:, 1] ** 2 + surface.reference[:, 2] ** 2)
        return Interface(overlaps, np.diff(bounds), surface.nodes, shares, surface.reference, rest, self.gas.areas.copy())

    @property
    def mass(self) -> float:
        """Present mass of gas and shell [kg]."""
        return self.gas.mass + float(self.shell.mass.sum())

    # -- description ------------------------------------------------------------------------------------------------

    def _declare_variables(self) -> Iterable[Variable]:
        stations = len(self.interface.width)
        yield from map(self._declare_output, part_variables({"gas": self.gas, "shell": self.shell}, ("gauge", "cell")))
        if self.parameters.vent is not None:
            yield Variable(
                "vent_area", "input", "m^2", (), "area of the opening at `vent` through which gas leaves", start=0.0,
                minimum=0.0, nominal=float(self.interface.area.mean()),
            )  # fmt: skip
        axes = ("station",)
        yield Variable(
            "peak_pressure", "output", "Pa", (stations,), "largest pressure on the inner surface since the reset",
            minimum=0.0, axes=axes, nominal=1e6,
        )  # fmt: skip
        yield Variable(
            "radial_displacement", "output", "m", (stations,), "mean radial displacement of the inner surface",
            axes=axes, nominal=1e-4,
        )  # fmt: skip
        yield Variable("gas_kinetic_energy", "output", "J", (), "kinetic energy of the gas", minimum=0.0)
        yield Variable("shell_kinetic_energy", "output", "J", (), "kinetic energy of the shell", minimum=0.0)
        yield Variable("work_on_room", "output", "J", (), "work of the shell on the room around it since the reset")
        yield Variable(
            "exchange_difference", "output", "J", (), "work received by shell and room minus work done by the gas, since the "
            "reset: 0 to rounding with two-way coupling; with one-way coupling, the work that the gas does not lose",
        )  # fmt: skip

    def _declare_output(self, variable: Variable) -> Variable:
        """Return the variable of a part; an input that the other part sets is returned as an output."""
        if variable.name not in ("gas_area", "shell_pressure"):
            return variable
        text = (
            "gas: cross-section of the cells" if variable.name == "gas_area" else "shell: pressure of the gas at the stations"
        )
        return dataclasses.replace(variable, causality="output", initial="calculated", description=text, start=None)

    def _output_readers(self) -> dict[str, Callable[[], Any]]:
        found: dict[str, Callable[[], Any]] = {
            "gas_area": lambda: self.gas.tables().state.area,
            "shell_pressure": self._shell_pressure,
            "radial_displacement": self._radial_displacement,
            "gas_kinetic_energy": lambda: self.gas.balances()[0].stored["kinetic_energy"],
            "shell_kinetic_energy": lambda: self.shell.balances()[0].stored["kinetic_energy"],
            "work_on_room": lambda: float(self._block["tally"][exchange.ROOM_WORK]),
            "exchange_difference": self._exchange_difference,
        }
        for prefix, part in (("gas", self.gas), ("shell", self.shell)):
            found |= part_readers(prefix, part)
        return found

    def _shell_pressure(self) -> FloatArray:
        return exchange.station_pressures(self.interface, self.gas.tables().state.pressure)

    def _radial_displacement(self) -> FloatArray:
        return self.shell.peek("mean_inner_radius") - self._rest_radii

    def _exchange_difference(self) -> float:
        gas, shell = self.gas.balances()[0].supplied, self.shell.balances()[0].supplied
        return float(gas["wall_work"] + shell["pressure_work"] + self._block["tally"][exchange.ROOM_WORK])

    # -- stepping ---------------------------------------------------------------------------------------------------

    def _state_contradiction(self, state: Mapping[str, np.ndarray]) -> str:
        stations, indices = len(self.interface.width), state["events"][:, 2]
        wrong = indices[(indices < 0.0) | (indices >= stations)]
        return f"got an event at station {wrong[0]:g} of {stations}" if len(wrong) else ""

    def _write_start_state(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        self._start_part(self.shell, "shell", seed, values, {})
        state = self.shell.tables().state
        self._block["awake"][0] = any(bool(one.any()) for one in (state.displacement, state.velocity, state.stress))
        present = self._present_area()
        area = present if self.parameters.coupling.has_moving_wall else self.gas.areas
        starts = self._start_part(self.gas, "gas", seed, values, {"area": area})
        self._block["peak_pressure"][:] = self._shell_pressure()
        return {f"gas_{name}": value for name, value in starts.items() if name != "area"}

    def _start_part(
        self,
        part: Component,
        prefix: str,
        seed: int | None,
        values: Mapping[str, FloatArray],
        extra_values: Mapping[str, FloatArray],
    ) -> Mapping[str, Any]:
        """Write the start state of a part; report faults in its values as faults of this component."""
        try:
            return part._write_start_state(seed, {**part_values(prefix, values), **extra_values})
        except ParameterError as error:
            raise ParameterError(*(_fault_of_part(fault, prefix) for fault in error.faults)) from None

    def _present_area(self) -> FloatArray:
        """Return the present cross-section of the gas cells, as the shell leaves it, shape (cells,) [m^2]."""
        interface, widening, overlaps = self.interface, self._block["widening"], self.interface.overlaps
        exchange.write_widening(interface, self.shell.tables().state, widening)
        return interface.area * (1.0 + interface.to_cells(overlaps.length * widening[overlaps.station]) / self.gas.cell_size)

    def _advance_state(self, ticks: int) -> int:
        for tick in range(self._tick, self._tick + ticks):
            status = self._advance_tick(tick)
            if status:
                return status
        return 0

    def _advance_tick(self, tick: int) -> int:
        """Advance gas, then shell, by an internal step; then apply the motion of the wall to the gas."""
        before = self._shell_pressure()
        status = self._advance_gas(tick)
        if status:
            return status
        after, peaks = self._shell_pressure(), self._block["peak_pressure"]
        np.maximum(peaks, after, out=peaks)
        if not self._is_awake(after):
            return 0
        works = np.zeros(len(after))
        status = self._advance_shell(tick, before, after, works)
        if status:
            return status
        widening = self._block["widening"]
        exchange.write_widening(self.interface, self.shell.tables().state, widening)
        if not self.parameters.coupling.has_moving_wall:
            self._record_growth(tick)
            return 0
        self._failed_tick = tick
        self._failed_cell = exchange.move_wall(self.gas.tables(), self.interface, after, widening, works)
        return 0 if self._failed_cell < 0 else _WALL

    def _record_growth(self, tick: int) -> None:
        """Record, once, that the cross-section of the wall differs too much from that of the one-way-coupled gas."""
        station = int(self._block["widening"].argmax())
        growth = float(self._block["widening"][station])
        if growth > _LARGEST_GROWTH and not self._block.count("events"):
            self._add_event(tick + 1, _GROWN, station, growth, _LARGEST_GROWTH)

    def _advance_gas(self, tick: int) -> int:
        """Advance the gas with its present area, and let it leak through openings."""
        gas = self.gas.tables().state
        for step in range(self.gas_steps):
            own = {
                name.removeprefix("gas_"): input_mean(value, tick, step, self.gas_steps)
                for name, value in self._held.items()
                if name != "vent_area"
            }
            self._failed_tick = tick * self.gas_steps + step
            self.gas.set_progress(self._failed_tick, {})
            self.gas._hold_inputs({**own, "area": gas.area})
            status = self.gas._advance_state(1)
            if status:
                return _GAS + status
        self._leak_gas(tick)
        return 0

    def _leak_gas(self, tick: int) -> None:
        """Let gas leak from the vent and from open cracks."""
        p, interface, overlaps, openings = (
            self.parameters,
            self.interface,
            self.interface.overlaps,
            np.zeros(self.gas.parameters.cells),
        )
        if self._has_leaking_cracks and self.shell.event_count:
            areas = (self.shell.peek("crack_area") / interface.width)[overlaps.station]
            openings = interface.to_cells(areas * overlaps.length)
        if p.vent is not None:
            cell = min(int(p.vent / self.gas.cell_size), p.gas.cells - 1)
            openings[cell] += max(input_mean(self._held["vent_area"], tick), 0.0)
        if openings.any():
            medium, gas = self.gas.tables().medium, self.gas.tables().state
            exchange.leak_gas(medium, gas, openings, p.discharge, p.room_pressure, self.step_size, self._block["tally"])

    @property
    def _has_leaking_cracks(self) -> bool:
        """Return whether gas can leak through cracks."""
        return self.parameters.coupling.has_leakage and self.parameters.shell.fracture.name != "none"

    def wake(self) -> None:
        """Activate the shell, whose steps are otherwise skipped until it is loaded."""
        self._block["awake"][0] = True

    def _is_awake(self, pressures: FloatArray) -> bool:
        """Return whether the shell is active; its steps are skipped until it is loaded."""
        awake, room = self._block["awake"], self.parameters.room_pressure
        if not awake[0]:
            awake[0] = float(np.abs(pressures - room).max()) > _WAKING * room
        return bool(awake[0])

    def _advance_shell(self, tick: int, old_pressures: FloatArray, new_pressures: FloatArray, works: FloatArray) -> int:
        """Advance the shell under pressures linear in time over the tick, and add the work of the gas at each station."""
        room, tally, around = self.parameters.room_pressure, self._block["tally"], self.shell.lattice.shape[1]
        for step in range(self.shell_steps):
            acting = old_pressures + (step + 0.5) / self.shell_steps * (new_pressures - old_pressures)
            self._failed_tick = tick * self.shell_steps + step
            tables = self.shell.tables()
            area = tables.state.area.copy()
            self.shell.set_progress(self._failed_tick, {})
            self.shell._hold_inputs({"pressure": acting - room})
            status = self.shell._advance_state(1)
            if status:
                return _SHELL + status
            swept = exchange.swept_volumes(tables, area)
            work = (swept.reshape(-1, around) * acting[:, None]).T
            works[:] = ordered_sum_of_rows(np.vstack([works, work]))
            tally[exchange.ROOM_WORK] = ordered_sum(tally[exchange.ROOM_WORK], room * swept)
        return 0

    def _step_error(self, status: int) -> StepError:
        if _GAS < status < _SHELL:
            return self._part_error(self.gas, "gas", status - _GAS, self.gas_steps)
        if _SHELL < status < _WALL:
            return self._part_error(self.shell, "shell", status - _SHELL, self.shell_steps)
        return self._wall_error()

    def _part_error(self, part: Component, prefix: str, status: int, steps: int) -> StepError:
        """Return the error of a part as an error of the tube."""
        part.set_progress(self._failed_tick, {})
        error = part._step_error(status).with_part_prefix(prefix)
        if part is self.shell and error.index is not None:
            x = self.parameters.position + self.shell.assembly.coordinates(error.index)[0]
            error = error.with_hint(f"x is the coordinate of the shell; that of the gas is {x:.4g} m")
        if steps == 1:
            return error
        return error.with_hint(f"the {prefix} makes {steps} such steps in a tick of {self.step_size:g} s")

    def _wall_error(self) -> StepError:
        """Return the error for a cell that has no pressure left after a motion of the wall."""
        cell, time = self._failed_cell, (self._failed_tick + 1) * self.step_size
        value = float(self.gas.tables().state.pressure[cell])
        return StepError(
            f"fell to {value:g} Pa in cell {cell}, x = {self.gas.centres[cell]:.6g} m, at {time:.9g} s, expected "
            f"more than 0: the wall moved too far in a tick; take a smaller step_size (now {self.step_size:g} s)",
            time=time, at="gas_pressure", variable="gas_pressure", index=cell, value=value, limit=0.0,
        )  # fmt: skip

    # -- reading ----------------------------------------------------------------------------------------------------

    def balances(self) -> tuple[Balance, ...]:
        """Return the balances of energy, momentum and mass of gas and shell since the reset.

        `wall_work` and `wall_impulse` are done by the walls on the gas. `pressure_work` and `pressure_impulse` are done on the
        shell by the gas pressure minus the pressure outside.
        """
        mass, momentum, energy = (float(amount) for amount in self._block["tally"][: exchange.ROOM_WORK])
        gas, shell = self.gas.balances(), self.shell.balances()
        return (
            balances.join_energy(gas[0], shell[0], energy),
            balances.join_momentum(gas[1], shell[1], momentum),
            balances.join_mass(gas[2], shell[2], mass),
        )

    def report(self) -> dict[str, float]:
        """Return the reports of both parts, the change of the cross-section, and the work exchanged between them."""
        found = {f"gas: {name}": figure for name, figure in self.gas.report().items()}
        found |= {f"shell: {name}": figure for name, figure in self.shell.report().items()}
        work = float(self.shell.balances()[0].supplied["pressure_work"])
        return {
            **found,
            "steps of the gas per tick": float(self.gas_steps),
            "steps of the shell per tick": float(self.shell_steps),
            "largest pressure at the shell so far, Pa": float(self._block["peak_pressure"].max()),
            "largest change of the cross-section now": self._largest_area_change(),
            "exchange difference / work on the shell": self._exchange_difference() / work if work else 0.0,
            "energy residual / work on the shell": float(self.balances()[0].residual) / work if work else 0.0,
        }

    def _largest_area_change(self) -> float:
        """Return the largest present magnitude, over the stations, of the relative change of the cross-section."""
        return float(np.abs(self._block["widening"]).max())

    def conclusions(self) -> list[str]:
        """Return the conclusions of both parts, the load on the wall, and the time from which one-way coupling is not valid."""
        missing_detonation, found = self.gas.missing_detonation, [f"gas: {text}" for text in self.gas.conclusions()]
        found.append(
            f"wall: the largest pressure on it was {1e-6 * self._block['peak_pressure'].max():.4g} MPa, and the cross-section "
            f"has changed by at most {100.0 * self._largest_area_change():.3g} %"
        )
        for event in self.events(_GROWN):
            assert event.index is not None
            place = self.parameters.position + float(self.shell.lattice.axes[0].positions[event.index])
            found.append(
                f"not valid from {1e6 * event.tick * self.step_size:.4g} us on: the cross-section at {place:.4g} m had grown "
                f"by {event.value:.0%}, but with one-way coupling the gas flows as in a rigid tube; take coupling = 'two_way'"
            )
        outcome = f"; {missing_detonation}" if missing_detonation else ""
        return found + [f"shell: {text}{outcome if text.startswith('outcome: ') else ''}" for text in self.shell.conclusions()]

    def cautions(self) -> list[str]:
        """Return the cautions of the parts, and one if the motion of the wall should have affected the gas."""
        said = [f"gas: {text}" for text in self.gas.cautions()] + [f"shell: {text}" for text in self.shell.cautions()]
        change = self._largest_area_change()
        if change > _LARGE_CHANGE and not self.parameters.coupling.has_moving_wall:
            said.append(
                f"the wall has changed the cross-section by {change:.1%}, which one-way coupling ignores; take "
                "coupling = 'two_way'"
            )
        return said

    def drawables(self) -> tuple[Drawable, ...]:
        """Return the shell at its position along the tube, and a side view of the gas."""
        shift, shown = np.array([self.parameters.position, 0.0, 0.0]), []
        for prefix, part in (("shell", self.shell), ("gas", self.gas)):
            for drawable in part.drawables():
                moved = {}
                if prefix == "shell" and isinstance(drawable, Points):
                    moved = {"reference": drawable.reference + shift}
                if prefix == "shell" and isinstance(drawable, Cells):
                    moved = {"nodes": drawable.nodes + shift}
                shown.append(part_drawable(prefix, drawable, **moved))
        return tuple(shown)


def _fault_of_part(fault: Fault, prefix: str) -> Fault:
    """Return the fault of a part's start value, with the name of the value in this component."""
    first, *others = fault.location if fault.location and fault.location[0] == "start" else ("start", *fault.location)
    name = f"{prefix}_{others[0]}" if others else prefix
    return dataclasses.replace(fault, location=(first, name, *others[1:]))
