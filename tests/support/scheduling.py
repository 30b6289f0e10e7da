"""Which worker runs which file of tests, and in which order: files that compile the same kernels in one, the longest first.

A kernel that nobody has compiled yet is compiled by every worker that wants it before the first is done. So one worker begins
with files that need the kernels of the chain, the next one with those that need bodies in the plane, shells and gas; files
that need some of both come when both are compiled. And the longest files come first: otherwise one worker ends with a long
file while the other has nothing left to do.
"""

from __future__ import annotations

import re
from typing import Any

from xdist.scheduler import LoadFileScheduling

CHAIN = re.compile(r"test_(chain_|control_|envs|measurement|examples|benchmarks)")
BODIES = re.compile(r"test_(automata_|coupled|grid|shell|tube|detonation|thermo|papers)")
# In the order of their CPU time with no kernel kept, the longest first; all others take less.
LONG = [
    "test_docs.py",
    "test_chain_adjoint.py",
    "test_papers.py",
    "test_conformance.py",
    "test_sweep.py",
    "test_chain_law_functions.py",
    "test_kernel_cache.py",
    "test_run.py",
    "test_discs.py",
    "test_benchmarks.py",
    "test_resumption.py",
    "test_recording_files.py",
    "test_cli.py",
    "test_control_studies.py",
    "test_automata_contacts.py",
    "test_chain_bits.py",
    "test_automata_materials.py",
    "test_viewing_processes.py",
    "test_docs_site.py",
    "test_architecture.py",
    "test_conformance_refusals.py",
    "test_progress.py",
    "test_recording_hostile.py",
    "test_envs_registration.py",
    "test_coupled_side_contacts.py",
    "test_coupled.py",
    "test_recording_planar.py",
    "test_recording_faults.py",
    "test_chain_default_step.py",
    "test_viewing_figures.py",
    "test_envs_vector.py",
    "test_writing.py",
    "test_automata_cracking.py",
    "test_chain_random.py",
    "test_control_tasks.py",
    "test_envs_kernels.py",
    "test_coupled_cracking.py",
    "test_viewing_planes.py",
    "test_tube_experiments.py",
    "test_viewing_report.py",
    "test_shell.py",
]


class ByKernels(LoadFileScheduling):
    """Gives each worker the longest file of its own kind, and others when none is left."""

    def _assign_work_unit(self, node: Any) -> None:
        kinds = (CHAIN, BODIES) if self.nodes.index(node) % 2 == 0 else (BODIES, CHAIN)
        first = min(self.workqueue, key=lambda scope: rank(scope, *kinds))
        self.workqueue.move_to_end(first, last=False)
        super()._assign_work_unit(node)


def rank(scope: str, own: re.Pattern[str], other: re.Pattern[str]) -> tuple[int, int]:
    """Return how soon a worker takes a file: its own kind, then files of no kind, then the other kind; the longest first."""
    name = scope.rpartition("/")[2]
    kind = 0 if own.match(name) else 2 if other.match(name) else 1
    return kind, LONG.index(name) if name in LONG else len(LONG)
