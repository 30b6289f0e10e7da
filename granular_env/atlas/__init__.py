"""Atlases: every figure and number of a paper, computed anew, beside what the paper printed, with a verdict.

A paper is a folder of entries, one section or figure a file; `papers.py` names the papers. `model.py` says what an entry is,
`verdicts.py` how numbers are compared, `context.py` what an entry computes with, `computation.py` computes the entries,
`run.py` computes and writes all of it, `folder.py` keeps their folder, `result_files.py` and `page.py` write what they found.

    done = ge.run_atlas("nesterenko-1983", "out", overrides={"A": 6.391e12})
"""

from .computation import Atlas, Done, chosen, compute
from .papers import names, paper
from .result_files import write
from .run import run_atlas

__all__ = ["Atlas", "Done", "chosen", "compute", "names", "paper", "run_atlas", "write"]
