"""The cost of this page in time and disk, by nodes and entries: from runs at 5000 and at 140,000 nodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .cases import COARSER, tube_seconds

# Tubes of each entry on the page's mesh and on the coarser one, by name: entries share them.
_TUBES = {
    "figure-2": (("1", "1 printed"), ()),
    "figure-3": (("2", "2 printed"), ()),
    "figures-4-and-5": (("3", "3 printed"), ()),
    "outcomes": (("1", "2", "3", "1 printed", "2 printed", "3 printed"), ()),
    "criterion": (("1", "1 printed", "1 factor", "1 less stabilised", "1 more stabilised"), ("1 at 180 kPa",)),
    "pressures": ((), tuple(f"{inches} at {pressure} kPa" for inches in (1, 2, 3) for pressure in (80, 130, 180))),
    "coupling": (("1", "1 two-way"), ()),
}
# Bytes of a log whatever the mesh, which are the gas's, and for each node of the whole tube.
_GAS_BYTES, _BYTES = 8.5e6, 700.0
# From so many nodes of the whole tube on a run uses two cores by itself.
_TWO_CORES = 60000.0


def cost_words(constants: Mapping[str, float], entries: Sequence[str]) -> str:
    """Return what these entries of the page take in time and on the disk."""
    nodes = constants["nodes"]
    fine, coarse = ({name for entry in entries for name in _TUBES.get(entry, ((), ()))[kind]} for kind in (0, 1))
    seconds = len(fine) * tube_seconds(nodes) + len(coarse) * tube_seconds(COARSER * nodes)
    tubes = len(fine) + len(coarse)
    size = _GAS_BYTES * tubes + _BYTES * nodes * (len(fine) + COARSER * len(coarse))
    if not tubes:
        return "no tube is broken here: seconds, and some megabytes of logs"
    cores = "; such a run uses two cores by itself: add --processes 1" if nodes >= _TWO_CORES else ""
    return (
        f"{tubes} tubes of up to {nodes:.0f} nodes, half of each computed: about {_short(seconds / 60.0)} minutes of one core "
        f"in all, and some {1e-9 * size:.2g} GB of logs (estimated from runs of 5000 and 140000 nodes; cracks cost more the "
        f"more there are){cores}. Ended, the same command goes on with the runs that are left"
    )


def _short(number: float) -> str:
    """Return two digits of a number, without an exponent."""
    return f"{float(f'{number:.2g}'):g}"
