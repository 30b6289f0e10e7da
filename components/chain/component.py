"""Nesterenko's granular chain as a component."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Self

import numpy as np

from ..balances import Balance
from ..component import Component
from ..drawables import Points
from ..errors import ParameterError, StepError, issue_warning
from ..inputs import Held
from ..profiles import CompiledProfile
from ..state_block import LARGEST, Block
from ..support.float_arrays import FloatArray
from ..variables import Variable
from . import layout
from .geometry import Geometry, geometry, minimum_evaluations, step_times_frequency, suggested_step_size
from .integrators import SCHEMES, UNSOUND, EntryPoints, make_entry_points
from .laws import Dissipative, Law
from .parameters import WALLS, ChainParameters
from .state import ChainState, python_chain_state
from .validity import validity_cautions, validity_figures

# Smallest number of force evaluations during a contact; a step with fewer is refused.
_LEAST_FORCES = 16.0
# Largest fraction of its approach velocity that a contact may lose in one step without loss of the second order.
_STOPPED_IN_A_STEP = 0.3

_NO_PIECES = np.zeros((0, 2))
# Beyond these limits a unit is probably wrong [m, kg/m^3, kg/m^3, m/s]; the third allows for strikers of large mass.
_LARGE_RADIUS, _LIGHT_DENSITY, _HEAVY_DENSITY, _SLOW_SOUND = 0.1, 100.0, 1e6, 20.0
_NUMBERING = "entry i is left of grain i, the last entry right of the last grain; 0 without a contact"
_OF_A_WALL = "wall on the chain, positive to the right; 0 without a wall"
# Kind of end -> name, unit and description of its input.
_INPUTS = {
    "piston": ("velocity", "m/s", "velocity of the {} piston, positive to the right"),
    "free": ("force", "N", "force on the {} end grain, positive to the right"),
}
# Outputs of every chain: name, unit, what the index counts (None for a single number), description.
_OUTPUTS = (
    ("position", "m", "grain", "positions of the grain centres; the first grain starts at 0"),
    ("displacement", "m", "grain", "displacement of each grain from its reference position, positive to the right"),
    ("velocity", "m/s", "grain", "velocity of each grain, positive to the right"),
    ("overlap", "m", "contact", f"overlap of the surfaces in each contact, negative for a gap; {_NUMBERING}"),
    ("contact_force", "N", "contact", f"compressive force in each contact, never negative; {_NUMBERING}"),
    ("potential_energy", "J", None, "elastic energy and, with gravity, potential energy of the weights"),
    ("left_wall_force", "N", None, f"force of the left {_OF_A_WALL}"),
    ("right_wall_force", "N", None, f"force of the right {_OF_A_WALL}"),
)
# Number of arrays of length n that exist during the build, in addition to the table and its copy.
_GEOMETRY_ROWS = 18


class Chain(Component):
    """A row of grains between two ends: Nesterenko (1983), equations (1.1) and (1.2), with a choice of contact laws.

    m_i u_i'' = F_i - F_(i+1) + m_i g, F = k d^1.5 for elastic spheres, d the overlap of neighbours, no tension. See
    `ChainParameters` and `laws`.
    """

    name = "chain"
    version = 4
    Parameters = ChainParameters
    parameters: ChainParameters

    def __repr__(self) -> str:
        p = self.parameters
        return f"<chain of {p.grains} grains, law {p.law.name}, ends {p.left} and {p.right}, at {self.time:.9g} s>"

    # -- building ---------------------------------------------------------------------------------------------------

    @classmethod
    def memory_needed(cls, parameters: ChainParameters) -> int:
        """Return the memory for the table of the kernels, a copy of its state, and the arrays of the geometry."""
        scheme = SCHEMES[parameters.integrator]
        first = _first_state_row(parameters.law)
        state_rows = layout.FREE_ROW - first + scheme.history_rows
        rows = first + 2 * state_rows + scheme.scratch_rows + _GEOMETRY_ROWS
        return 8 * rows * layout.row_width(parameters.grains)

    @property
    def cost_per_tick(self) -> int:
        """Number of state words that a tick advances, divided by eight: words of a chain take less than a nanosecond."""
        return super().cost_per_tick // 8

    def _build_system(self) -> None:
        p = self.parameters
        self.geometry: Geometry = geometry(p)
        self._scheme = SCHEMES[p.integrator]
        self._minimum_evaluations = minimum_evaluations(p.law.exponent, self._scheme)
        self.step_size = suggested_step_size(p, self.geometry, self._scheme) if p.step_size is None else p.step_size
        self.scheme = self._scheme.damped if isinstance(p.law, Dissipative) else self._scheme.numbers
        self.entries: EntryPoints = make_entry_points(p.law.contacts, self.scheme)
        self._advance_held = self.entries.advance_held
        self._grains = slice(1, p.grains + 1)
        width = layout.row_width(p.grains)
        last = layout.FREE_ROW + self._scheme.history_rows
        self.state_rows = slice(_first_state_row(p.law), last)
        self._bind_memory(self._claim_memory((last + self._scheme.scratch_rows, width)))
        self._fill_constants()
        # The weight of a prescribed grain is carried by its piston.
        self._weight = p.gravity * self._table[layout.MASS, self._grains]
        self._whole_weight = float(self._weight.sum())
        wanted, self._refused_overlap = self._overlap_limits()
        self._table[layout.LIMIT, : p.grains + 1] = np.minimum(wanted, self._refused_overlap)
        self.left_input = "left_velocity" if p.left == "piston" else "left_force"
        self.right_input = "right_velocity" if p.right == "piston" else "right_force"
        self._left_moves, self._right_moves = p.left not in WALLS, p.right not in WALLS
        self._drive, self._left_pieces, self._left, self._right = _NO_PIECES, 0, 0.0, 0.0

    def _bind_memory(self, memory: FloatArray) -> None:
        self._table = memory
        state = memory[self.state_rows]
        high = np.full((len(state), 1), LARGEST)
        if self.parameters.law.has_history:  # the deepest overlap is infinite at places without a contact
            high[layout.LOST - 1 - self.state_rows.start] = np.inf
        self._block = Block(state.reshape(-1), rows=("f8", state.shape, -LARGEST, high))

    def clone(self, memory: FloatArray | None = None) -> Self:
        """Return a chain with the same parameters, at its start; much cheaper than a new one.

        Args:
            memory: array for the table, with the shape of this chain's `memory`; None for new memory.
        """
        other: Self = object.__new__(type(self))
        vars(other).update(vars(self))
        other._given_memory = memory
        memory = other._claim_memory(self._table.shape)
        memory[:] = self._table
        other._bind_memory(memory)
        other._bind_block()
        other.reset()
        return other

    def _fill_constants(self) -> None:
        p, chain, rows = self.parameters, self.geometry, self._table
        places = slice(0, p.grains + 1)
        rows[layout.STIFFNESS, places] = chain.stiffness
        rows[layout.REST_OVERLAP, places] = chain.rest_overlap
        rows[layout.LAW_CONSTANTS : layout.LEFT_DRIVE, places] = chain.law_constants.T
        rows[layout.INVERSE_MASS, self._grains] = 1.0 / chain.mass
        rows[layout.MASS, self._grains] = chain.mass
        for end, column in ((p.left, 1), (p.right, p.grains)):
            if end == "piston":
                rows[layout.INVERSE_MASS, column] = rows[layout.MASS, column] = 0.0
        numbers = rows[layout.SCALARS]
        numbers[layout.STEP], numbers[layout.GRAVITY], numbers[layout.GRAINS] = self.step_size, p.gravity, p.grains
        numbers[layout.SPEED_LIMIT] = chain.sound_speed.min()
        for first, end, place in ((layout.LEFT_FREE, p.left, 0), (layout.RIGHT_FREE, p.right, -1)):
            numbers[first : first + 4] = end == "free", end == "piston", chain.mass[place], chain.static_force[place]

    def _overlap_limits(self) -> tuple[FloatArray, FloatArray]:
        """Return the overlaps above which the chain warns, and above which it refuses a step; infinite without a contact."""
        chain, places, law = self.geometry, self.geometry.contact_slice, self.parameters.law

        def largest_overlap(evaluations: float) -> FloatArray:
            p = law.exponent
            frequency = step_times_frequency(p, self._scheme, evaluations) / self.step_size
            tangent = frequency * frequency * chain.reduced_mass[places] / (p * chain.largest_stiffness[places])
            # The overlap at which the contact has this tangent stiffness; linear contacts have the same one at every overlap.
            return tangent ** (1.0 / (p - 1.0)) if p > 1.0 else np.where(tangent < 1.0, 0.0, np.inf)

        wanted, refused = np.full((2, self.parameters.grains + 1), np.inf)
        wanted[places] = largest_overlap(self._minimum_evaluations)
        refused[places] = np.minimum(
            self.parameters.overlap_limit * chain.smaller_radius[places], largest_overlap(_LEAST_FORCES)
        )
        if isinstance(law, Dissipative):
            constants, whole = chain.law_constants[places], chain.reduced_mass[places] / self.step_size
            wanted[places] = np.minimum(wanted[places], law.overlap_from_coefficient(constants, _STOPPED_IN_A_STEP * whole))
            if self._scheme.is_explicit:
                refused[places] = np.minimum(refused[places], law.overlap_from_coefficient(constants, whole))
        return wanted, refused

    # -- the contract -----------------------------------------------------------------------------------------------

    def _declare_variables(self) -> Iterable[Variable]:
        p = self.parameters
        for side, end in (("left", p.left), ("right", p.right)):
            if end in _INPUTS:
                name, unit, about = _INPUTS[end]
                yield Variable(f"{side}_{name}", "input", unit, (), about.format(side), start=0.0)
        shapes: dict[str | None, tuple[int, ...]] = {None: (), "grain": (p.grains,), "contact": (p.contact_places,)}
        for name, unit, axis, about in _OUTPUTS:
            state, axes = name in ("displacement", "velocity"), (axis,) if axis else ()
            yield Variable(name, "output", unit, shapes[axis], about, state=state, axes=axes)

    def _output_readers(self) -> dict[str, Callable[[], Any]]:
        return {
            "position": lambda: self.geometry.position + self._table[layout.U, self._grains],
            "displacement": lambda: self._table[layout.U, self._grains],
            "velocity": lambda: self._table[layout.V, self._grains],
            "overlap": self._overlaps,
            "contact_force": self._contact_force,
            "left_wall_force": lambda: self._contact_force()[0],
            "right_wall_force": lambda: 0.0 - self._contact_force()[-1],
            "input_work": self._input_work,
        }

    def _write_start_state(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, float]:
        velocity, displacement = values.get("velocity"), values.get("displacement")
        if velocity is not None:
            self._table[layout.V, self._grains] = velocity
        if displacement is not None:
            self._table[layout.U, self._grains] = displacement
        self._refuse_failing_start()
        if self.parameters.law.has_history:
            self.entries.initialise_histories(self._table)
            # Contacts that are beyond yield at the start have yielded before it; the energy lost then is not counted.
            self.entries.update_histories(self._table)
            self._table[layout.LOST] = 0.0
        kinetic, potential, momentum = self._energies_and_momentum()
        tally = self._table[layout.TALLY]
        tally[layout.START_ENERGY], tally[layout.START_MOMENTUM] = kinetic + potential, momentum
        ends = {self.left_input: self._table[layout.V, 1], self.right_input: self._table[layout.V, self.parameters.grains]}
        return {name: float(speed) for name, speed in ends.items() if name.endswith("velocity")}

    def _refuse_failing_start(self) -> None:
        """Raise the error of the first step at once if the start would make it fail."""
        if np.any(self._overlaps() > self._refused_overlap) or np.any(
            np.abs(self._table[layout.V, self._grains]) > self._table[layout.SCALARS, layout.SPEED_LIMIT]
        ):
            raise ParameterError(*self._step_error(0).with_outer_location("start").faults)

    def _prepare_inputs(self, held: Mapping[str, Held]) -> None:
        """Store the pieces of the input profiles of both ends in one array; a profile is 0 before its first piece."""
        left, right = held.get(self.left_input, 0.0), held.get(self.right_input, 0.0)
        pieces = [_input_pieces(left), _input_pieces(right)]
        columns = max(piece.shape[1] for piece in pieces)
        self._drive = np.vstack([np.pad(piece, ((0, 0), (0, columns - piece.shape[1]))) for piece in pieces])
        self._left, self._right = (0.0 if isinstance(side, CompiledProfile) else side for side in (left, right))
        self._left_pieces = len(pieces[0])

    def _advance_state(self, ticks: int) -> int:
        # Hot path: the cost of a step called from Python depends on these lines.
        if self._profiled:
            done = self.entries.advance(self._table, self._drive, self._left_pieces, self._left, self._right, self._tick, ticks)
        else:
            held = self._held
            left = held[self.left_input] if self._left_moves else 0.0
            right = held[self.right_input] if self._right_moves else 0.0
            done = self._advance_held(self._table, left, right, self._tick, ticks)
        return 0 if done == ticks else self._limit_status(-done, ticks)

    def input_advice(self, name: str) -> str:
        """Return a hint with the kind of end that an unknown input requires."""
        side, _, quantity = name.partition("_")
        if side in ("left", "right") and quantity in ("force", "velocity"):
            wanted = "piston" if quantity == "velocity" else "free"
            return f"{side} is {getattr(self.parameters, side)!r}, and {name} needs {side} = {wanted!r}"
        return super().input_advice(name)

    def _limit_status(self, done_ticks: int, ticks: int) -> int:
        """Handle a limit passed in the last of `done_ticks` ticks: return the status 1 (refuse), or warn once and continue.

        Only the state determines a refusal. LIMIT only determines when the kernel returns: after the warning it need not return
        for poorly resolved contacts.
        """
        unsound = done_ticks >= UNSOUND
        done_ticks -= UNSOUND if unsound else 0
        self._failed_tick = self._tick + done_ticks
        if unsound or self._most_exceeded_limit(self._peak_overlaps)[2] > 1.0:
            return 1
        self._table[layout.LIMIT, : self.parameters.grains + 1] = self._refused_overlap
        issue_warning(self._resolution_caution())
        if done_ticks == ticks:
            return 0
        begin, self._tick = self._tick, self._tick + done_ticks
        try:
            return self._advance_state(ticks - done_ticks)
        finally:
            self._tick = begin

    def _most_exceeded_limit(self, overlap: FloatArray) -> tuple[str, int, float]:
        """Return the variable, the index and the ratio value / limit of the value with the largest ratio (infinite for NaN)."""
        with np.errstate(all="ignore"):
            ratios = {
                "overlap": overlap / self._refused_overlap,
                "velocity": np.abs(self._table[layout.V, self._grains]) / self._table[layout.SCALARS, layout.SPEED_LIMIT],
                "displacement": np.where(np.isfinite(self._table[layout.U, self._grains]), 0.0, np.inf),
            }
        ratios = {name: np.where(np.isnan(ratio), np.inf, ratio) for name, ratio in ratios.items()}
        name = max(ratios, key=lambda one: ratios[one].max())
        return name, int(np.argmax(ratios[name])), float(ratios[name].max())

    def _step_error(self, status: int) -> StepError:
        time = (self._failed_tick if status else self._tick) * self.step_size
        # Before the first tick there are no peaks; afterwards the kernel compares the peaks with the limits.
        overlap = self._peak_overlaps if status else self._overlaps()
        name, index, _ = self._most_exceeded_limit(overlap)
        if name == "overlap":
            value, limit = float(overlap[index]), float(self._refused_overlap[index])
            radius = float(self.geometry.smaller_radius[index])
            if self._dissipation_per_step() > 1.0:
                advice = self._dissipation_caution()
            elif limit >= 0.999 * self.parameters.overlap_limit * radius:
                advice = (
                    f"that is {value / radius:.2g} radii, but contact laws hold for small overlaps: reduce the load, "
                    "or raise overlap_limit"
                )
            else:
                advice = (
                    f"the contact would get fewer than {_LEAST_FORCES:.0f} force evaluations: take a smaller step_size "
                    f"(now {self.step_size:g} s) or set velocity_scale to the largest relative speed"
                )
        else:
            value, limit = float(self.get(name)[index]), float(self._table[layout.SCALARS, layout.SPEED_LIMIT])
            advice = "that is above the material's sound speed: reduce the load, or take a smaller step_size"
        unit, advice = self.variables[name].unit, "; ".join([*self._unit_cautions(), advice])
        return StepError(
            f"reached {value:.6g} {unit} at {time:.9g} s, the limit is {limit:.6g} {unit}; {advice}",
            time=time, at=(name, index), variable=name, index=index, value=value, limit=limit,
        )  # fmt: skip

    # -- reading ----------------------------------------------------------------------------------------------------

    @property
    def table(self) -> FloatArray:
        """Table of the chain's numbers for jitted code: its memory, not a copy; do not write to it."""
        return self._table

    @property
    def state(self) -> ChainState:
        """The chain as an argument of jitted functions, such as those of `differentiable_quantities`; do not write to it."""
        return python_chain_state(self.parameters.law.contacts, self._table)

    def detached_table(self) -> FloatArray:
        """Return a copy of the table for separate runs, which refuse large overlaps without warning."""
        table = self._table.copy()
        table[layout.LIMIT, : self.parameters.grains + 1] = self._refused_overlap
        return table

    def balances(self) -> tuple[Balance, ...]:
        """Return the balances of energy and momentum; a precompressing force on a free end does input work."""
        kinetic, potential, momentum = self._energies_and_momentum()
        tally = self._table[layout.TALLY]
        n = self.parameters.grains
        carried = self._table[layout.V, n + 2 : n + layout.BESIDE_GRAINS]
        # In conservative chains the row LOST is not part of the state, and the lost energy is zero.
        heat = 0.0 if self.parameters.law.conservative else self._table[layout.LOST].sum()
        work, lost = self._input_work(), float(heat + carried[4])
        impulse = float(tally[layout.IMPULSE_LEFT] + tally[layout.IMPULSE_RIGHT] + carried[2] + carried[3])
        impulse += self._whole_weight * self.time
        return (
            Balance(
                "energy", "J",
                stored={"kinetic_energy": kinetic, "potential_energy": potential},
                lost={"dissipated_energy": lost},
                supplied={"input_work": work},
                initial=float(tally[layout.START_ENERGY]),
            ),
            Balance(
                "momentum", "kg m/s",
                stored={"momentum": momentum}, supplied={"impulse": impulse}, initial=float(tally[layout.START_MOMENTUM]),
            ),
        )  # fmt: skip

    def _input_work(self) -> float:
        rows, behind = self._table, self.parameters.grains + 2
        tallied = rows[layout.TALLY, layout.WORK_LEFT] + rows[layout.TALLY, layout.WORK_RIGHT]
        return float(tallied + rows[layout.V, behind] + rows[layout.V, behind + 1])

    def _energies_and_momentum(self) -> tuple[float, float, float]:
        """Return kinetic energy, potential energy (elastic and gravitational) and momentum."""
        kinetic, elastic, momentum = self.entries.energies(self._table, self.geometry.mass)
        if self.parameters.gravity != 0.0:
            elastic -= float((self._weight * self._table[layout.U, self._grains]).sum())
        return kinetic, elastic, momentum

    def _overlaps(self) -> FloatArray:
        """Return the overlaps, shape (n + 1,); 0 at places without a contact."""
        u = self._table[layout.U]
        last = self.parameters.grains + 1
        overlap = u[:last] - u[1 : last + 1] + self.geometry.rest_overlap
        overlap[: self.geometry.contact_slice.start] = overlap[self.geometry.contact_slice.stop :] = 0.0
        return overlap

    @property
    def _peak_overlaps(self) -> FloatArray:
        """Largest overlap since the reset, recorded by the kernel once per tick, shape (n + 1,)."""
        return self._table[layout.PEAK, : self.parameters.grains + 1]

    def _contact_force(self) -> FloatArray:
        forces = np.empty(self.parameters.grains + 1)
        self.entries.contact_forces(self._table, forces)
        return forces

    def drawables(self) -> tuple[Points, ...]:
        """Return the grains, along x."""
        reference = self.geometry.position[:, np.newaxis].copy()
        return (Points("grains", reference, self.geometry.radius.copy(), "displacement", "velocity"),)

    def report(self) -> dict[str, float]:
        """Return numbers that show whether the assumptions of Nesterenko's section 1 hold, and how well contacts are resolved.

        With dissipation, also return the fraction of the approach speed that is dissipated per step.
        """
        figures = self._validity_figures()
        if isinstance(self.parameters.law, Dissipative):
            figures["dissipation in a step (c h / m*)"] = self._dissipation_per_step()
        return figures

    def _validity_figures(self) -> dict[str, float]:
        rate = self._scheme.evaluations / self.step_size
        return validity_figures(self.geometry, self.parameters.law, self._peak_overlaps[self.geometry.contact_slice], rate)

    def cautions(self) -> list[str]:
        """Return a sentence for each assumption that the run has violated."""
        said = validity_cautions(self._validity_figures(), self.parameters.law, self._minimum_evaluations)
        said = self._unit_cautions() + said
        if self._dissipation_per_step() > _STOPPED_IN_A_STEP:
            said.append(self._dissipation_caution())
        return said

    def _unit_cautions(self) -> list[str]:
        """Return cautions on probable unit errors: millimetres as metres, g/cm^3 as kg/m^3, grams as kg, MPa as Pa."""
        radius, sound = self.geometry.radius, self.geometry.sound_speed
        density = self.geometry.mass / (4.0 / 3.0 * np.pi * radius**3)
        said = []
        for excess, values, sentence in (
            (radius / _LARGE_RADIUS, radius, "grain {} has a radius of {:.4g} m: radius is in metres, 2.38e-3 not 2.38"),
            (
                _LIGHT_DENSITY / density, density,
                "grain {} has density {:.4g} kg/m^3, less than any solid grain: density is in kg/m^3, 7800 not 7.8",
            ),
            (
                density / _HEAVY_DENSITY, density,
                "grain {} has density {:.4g} kg/m^3, more than any solid: mass is in kg, 8.8e-4 not 0.88, density in kg/m^3",
            ),
            (
                _SLOW_SOUND / sound, sound,
                "the sound speed of grain {} is {:.4g} m/s, less than in any solid: young is in Pa, 2e11 not 200e3",
            ),
        ):  # fmt: skip
            worst = int(np.argmax(excess))
            if excess[worst] > 1.0:
                said.append(sentence.format(worst, values[worst]))
        return said

    def _dissipation_caution(self) -> str:
        return (
            f"dissipation would remove {self._dissipation_per_step():.2g} times the approach speed of a contact in a step; "
            f"less than {_STOPPED_IN_A_STEP:g} is required: take a smaller step_size (now {self.step_size:g} s)"
        )

    def _dissipation_per_step(self) -> float:
        """Return the largest c h / m* of the contacts, c the dissipative force per speed, h the step; 0 without dissipation."""
        law, places = self.parameters.law, self.geometry.contact_slice
        if not isinstance(law, Dissipative):
            return 0.0
        peak = np.maximum(self._overlaps(), self._peak_overlaps)[places]
        coefficients = np.where(peak > 0.0, law.damping_coefficients(self.geometry.law_constants[places], peak), 0.0)
        return float(np.max(coefficients / self.geometry.reduced_mass[places], initial=0.0)) * self.step_size

    def _resolution_caution(self) -> str:
        if self._dissipation_per_step() > _STOPPED_IN_A_STEP:
            return self._dissipation_caution()
        # The warning is issued at the first occurrence; the smallest number of evaluations is known only at the end.
        return (
            f"contacts get fewer than the {self._minimum_evaluations:.0f} force evaluations that {self.parameters.integrator} "
            f"requires (report() returns the number at the end): take a smaller step_size (now {self.step_size:g} s) or set "
            "velocity_scale to the largest relative speed"
        )


def _first_state_row(law: Law) -> int:
    """Return the first row of the state, which includes history rows only for laws with a history."""
    if law.has_history:
        return layout.LOST - law.history_rows
    return layout.TALLY if law.conservative else layout.LOST


def _input_pieces(held_input: Held) -> FloatArray:
    """Return the pieces of a profile as rows (first tick, coefficients); no rows for a constant input."""
    if not isinstance(held_input, CompiledProfile):
        return _NO_PIECES
    return np.column_stack([held_input.ticks.astype(np.float64), held_input.coefficients])
