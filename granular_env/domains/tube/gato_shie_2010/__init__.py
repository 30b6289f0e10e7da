"""C. Gato, Y. Shie, Fracture of thin shell structures stimulated by gas detonation: a numerical study (2010)."""

from granular_env.atlas.model import Constant, Paper

from . import (
    constant_volume_burn,
    figure_1,
    figure_2,
    figure_3,
    figures_4_and_5,
    initial_pressures,
    integration_rules,
    notch_lengths,
    sensitivity,
    two_way_coupling,
)
from .cases import FACTOR, LATE, NODES, PAPER_FACTOR
from .flow_stress_saturation import saturation
from .page_cost import cost_words

PAPER = Paper(
    name="gato-shie-2010",
    title="Gato and Shie 2010, recomputed",
    citation="C. Gato, Y. Shie, Fracture of thin shell structures stimulated by gas detonation: a numerical study (in "
    "Russian), Fizika Goreniya i Vzryva 46 (2010).",
    summary=(
        "A detonation runs through a thin aluminium tube that has a notch on its outside. Does the tube crack, how far, and "
        "which way? In 2010 C. Gato and Y. Shie computed experiments of T. W. Chao: first the gas in a rigid tube, then the "
        "wall "
        "under the pressures of that gas. This page computes the paper’s figures anew, and sets what it says in words beside "
        "what we find.",
        f"The paper’s bonds break where the largest principal stress is {PAPER_FACTOR:g} times the yield stress. The flow law "
        f"that it prints gives {saturation():.2f} times at a plastic strain of 1. So the pictures of cracks here are made with "
        f"a smaller factor, {FACTOR:g}, which is a constant of this page (--set factor=2). Tables say what the paper’s factor "
        "gives, and how the outcome depends on the factor, on the mesh, on the stabilisation, and on how long one looks.",
        "What differs from the paper: its gas was meshfree, ours is on a grid in one dimension, because one dimension is all "
        "that "
        "a rigid tube needs; its notch lies in a tube of 457 to 896 mm, ours in a piece of 160 mm whose ends are free to "
        "widen; "
        "by symmetry half of the tube is computed; the paper does not say at which initial pressure each figure was made, "
        "here it is 180 kPa. Where a word of the paper has no number we say how we read it, and then it holds in part, "
        f"never more. Runs go on for {1e3 * LATE:g} ms after the front has passed the notch, the time of the paper’s last "
        "picture.",
        f"By default the page is coarse: {NODES} nodes for the whole tube. --set nodes=140000 and --set nodes=280000 make it "
        "with as many nodes as the paper’s, and --only figure-2 one of its entries; the command says beforehand what that "
        "takes, and goes on where it was ended.",
    ),
    constants={
        "nodes": Constant(
            NODES, "", "nodes of the whole tube, of which half is computed; the paper: 140 000 to 280 000", 3000, 280000,
            whole=True, of_page=True,
        ),
        "factor": Constant(
            FACTOR, "", "largest principal stress over the yield stress at which bonds break in the pictures; the paper: 3",
            0.8, 4.0, of_page=True,
        ),
    },
    cost=cost_words,
    entries=(
        figure_1.ENTRY, constant_volume_burn.ENTRY, figure_2.ENTRY, figure_3.ENTRY, figures_4_and_5.ENTRY, notch_lengths.ENTRY,
        sensitivity.ENTRY, initial_pressures.ENTRY, two_way_coupling.ENTRY, integration_rules.ENTRY,
    ),
)  # fmt: skip
