"""S. G. Psakhie et al., Simulation of the behavior of complex media by a combined discrete-continuous approach (2003)."""

from granular_env.atlas.model import Constant, Paper

from . import exact_solution, figure_6, figure_7, figure_8, interface_schemes, rayleigh, sub_steps, waves
from .cases import CELLS

PAPER = Paper(
    name="psakhie-2003",
    title="Psakhie 2003, recomputed",
    citation="S. G. Psakhie, A. Yu. Smolin, Yu. P. Stefanov, P. V. Makarov, E. V. Shilko, M. A. Chertov, E. P. Evtushenko, "
    "Simulation of the "
    "behavior of complex media based on the combined discrete-continuous approach (in Russian), Fizicheskaya Mezomekhanika 6 "
    "(2003).",
    summary=(
        "In 2003 S. G. Psakhie and colleagues in Tomsk joined two ways to compute a solid: a continuum on a grid, which is "
        "cheap, and movable cellular automata, which can crack and mix. A wave should not notice where one ends and the other "
        "begins. This page computes the paper’s figures 6, 7 and 8 anew, and sets what it says in words beside what we "
        "measure.",
        "The paper prints figures and words, and hardly a number: neither sizes, nor materials, nor loads, nor errors. The "
        "set-ups here are ours (granite, a load of 20 µs on a half-space); the quotations are our translation, with the "
        "section. A statement about order, direction or conservation is reproduced or not. Of words such as “not noticeable” "
        "we say with which number we read them, and then they hold in part, never more. Where something does not come out, the "
        "page says so, with the reason.",
        "The page covers the coupling of section 2.3, equations (11) and (15) to (18), and the waves of figures 6, 7 and 8. "
        "It leaves out the two methods by themselves: equations (1) to (10) and figure 1 of the grid, the Wiener-Rosenblueth "
        "equation, (12) to (14) and figures 2 and 3 of the automata, and the schemes of figures 4 and 5. The program has them, "
        "with tests and pages of their own, except for the Wiener-Rosenblueth equation and (12) and (13): in their place "
        "displacements and rotations of the automata are integrated by (14), and the strains of a pair follow from them. The "
        "paper’s switch from unlinked to linked by distance is replaced by a criterion of pressure and sliding speed.",
        "All differences to what is exact fall with the square of the size of cells; the numbers are those of the size below. "
        "--set cells=136 makes the page with cells twice as large.",
    ),
    constants={
        "cells": Constant(
            CELLS, "", "cells along the 0.4 m of the half-space’s depth; automata and the other runs in proportion", 80, 400,
            whole=True, of_page=True,
        ),
    },
    entries=(
        interface_schemes.ENTRY,
        sub_steps.ENTRY,
        figure_6.ENTRY,
        figure_7.ENTRY,
        figure_8.ENTRY,
        waves.ENTRY,
        rayleigh.ENTRY,
        exact_solution.ENTRY,
    ),
)  # fmt: skip
