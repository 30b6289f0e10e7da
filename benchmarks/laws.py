"""Speed of each contact law's default kernel, relative to Hertz's law in the same process."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from . import chains
from .figures import Figure
from .timing import median_ratio, repeats_for, time_interleaved

# With Hertz's exponent and stiffness the motion is the same, and only the computation of the power differs.
GENERAL = {"law": {"name": "power", "exponent": 1.5}, "contact_stiffness": chains.STIFFNESS}
LAWS: dict[str, dict[str, Any]] = {
    "viscous": {"law": {"name": "viscous", "dissipation": 1.0}},
    "kuwabara_kono": {"law": {"name": "kuwabara_kono", "dissipation": 100.0}},
    "elastic_plastic": {"law": "elastic_plastic"},
    "power": GENERAL,
    "walton_braun": {"law": {"name": "walton_braun", "unloading_stiffness": 2e7}, "contact_stiffness": 1e7},
    "linear": {"law": {"name": "linear", "dissipation": 1.0}, "contact_stiffness": 1e7},
}
WANTED = {"viscous": 0.5, "kuwabara_kono": 0.5}
_SAMPLE_SECONDS = 4e-3
_UNTIL_YIELDED = 2000


def measure(grains: int = 1000, rounds: int = 41) -> Iterator[Figure]:
    """Measure chains with all contacts closed and moving, and the default integrator; plastic contacts have yielded before."""
    built = {"hertz": chains.precompressed_chain(grains)} | {
        name: chains.precompressed_chain(grains, **law) for name, law in LAWS.items()
    }
    built["elastic_plastic"]._advance_state(_UNTIL_YIELDED)
    ticks = repeats_for(lambda: built["hertz"]._advance_state(1), _SAMPLE_SECONDS)
    times = time_interleaved({name: lambda chain=chain: chain._advance_state(ticks) for name, chain in built.items()}, rounds)
    for name in LAWS:
        rate = median_ratio(times["hertz"], times[name])
        note = f"{1.0 / rate:.1f} times the time"
        yield Figure(f"rate of {name} / hertz, N = {grains}", rate, at_least=WANTED.get(name), note=note)
