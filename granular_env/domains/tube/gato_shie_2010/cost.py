"""The cost of the page, by the number of nodes: from runs at its coarse size and the speed of the solid."""

from __future__ import annotations

from collections.abc import Mapping

# Runs of broken tubes, some of them on coarser meshes; the gas, and all that does not grow with the nodes [s, of one core].
_RUNS, _FIXED_SECONDS = 19, 12.0
# Ticks of the shell after the front has come, nodes and ticks a second of one that breaks, and bytes of a log for each node.
_TICKS, _SPEED, _BYTES = 7500.0, 2.4e6, 2600.0


def cost_words(constants: Mapping[str, float]) -> str:
    """Return what the page takes in time and on the disk."""
    nodes = constants["nodes"]
    minutes = _RUNS * (_FIXED_SECONDS + 0.5 * nodes * _TICKS / _SPEED) / 60.0
    return (
        f"{_RUNS} tubes of {nodes:.0f} nodes, half of each computed: about {minutes:.2g} minutes of one core in all, and "
        f"{1e-9 * _RUNS * _BYTES * nodes:.2g} GB of logs (estimated from runs of 3000 to 5000 nodes; cracks cost more the more "
        "there are)"
    )
