"""Atlases: every figure and number of a paper, computed anew, beside what the paper printed, with a verdict.

A paper is a folder of entries (`nesterenko_1983`), one section or figure a file; `papers.py` names the papers. `model.py`
says what an entry is, `verdicts.py` how numbers are compared, `context.py` what an entry computes with, `building.py`
computes the entries, `folder.py` keeps their folder, `writing.py` and `page.py` write what they found.

    from granular_env import atlas

    done = atlas.compute(atlas.paper("nesterenko-1983"), "out", {"A": 6.391e12})
    atlas.write(done, "out")
"""

from .building import Atlas, Done, chosen, compute
from .papers import names, paper
from .writing import write

__all__ = ["Atlas", "Done", "chosen", "compute", "names", "paper", "write"]
