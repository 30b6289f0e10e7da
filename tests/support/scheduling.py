"""Assignment of test files to workers: files that compile the same kernels share a worker; the longest files run first.

Every worker that needs a kernel before it is cached compiles it. Therefore one worker starts with the chain, the next with
plane bodies, shells and gas. A long file at the end would leave the other worker idle.
"""

from __future__ import annotations

from typing import Any

from xdist.scheduler import LoadFileScheduling

# Files that need kernels of both kinds are in neither list and run later.
CHAIN = ("test_chain_", "test_control_", "test_envs", "test_measurement", "test_examples", "test_benchmarks")
BODIES = (
    "test_automata_",
    "test_coupled",
    "test_grid",
    "test_shell",
    "test_tube",
    "test_detonation",
    "test_thermo",
)
# Files with the most CPU time without cached kernels, in descending order; other files are sorted by number of tests.
LONG = (
    "test_chain_law_functions.py",
    "test_chain_adjoint.py",
    "test_sweep.py",
    "test_docs.py",
    "test_golden.py",
    "test_conformance.py",
    "test_papers.py",
)


class KernelScheduler(LoadFileScheduling):
    """A scheduler: each worker gets the longest files of its list, then files of neither list, then those of the other list."""

    def _assign_work_unit(self, node: Any) -> None:
        own, other = (CHAIN, BODIES) if self.nodes.index(node) % 2 == 0 else (BODIES, CHAIN)

        def rank(scope: str) -> tuple[int, int, int]:
            name = scope.rpartition("/")[2]
            kind = 0 if name.startswith(own) else 2 if name.startswith(other) else 1
            return kind, LONG.index(name) if name in LONG else len(LONG), -len(self.workqueue[scope])

        self.workqueue.move_to_end(min(self.workqueue, key=rank), last=False)
        super()._assign_work_unit(node)
