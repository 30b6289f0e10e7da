"""V. F. Nesterenko, Propagation of nonlinear compression pulses in granular media (1983): its sections and figures."""

from granular_env.atlas.model import Constant, Paper

from . import (
    figure_3,
    section_1_contact_law,
    section_2_equations,
    section_2_stationary_waves,
    section_3_accuracy,
    section_31_first_grains,
    section_31_pressed,
    section_32_head_on,
    section_32_overtaking,
    section_32_striker_and_wall,
    section_33_triangular_push,
    section_34_energy,
    section_34_losses,
    section_34_piston,
    section_34_speeds,
    section_35_free,
    section_35_piston,
    section_35_profile,
)
from .cases import A, N
from .random_chains import SEEDS
from .wave_count import RULE

PAPER = Paper(
    name="nesterenko-1983",
    title="Nesterenko 1983, recomputed",
    citation="V. F. Nesterenko, Propagation of nonlinear compression pulses in granular media (in Russian), "
    "Prikl. Mekh. Tekh. Fiz. (1983) No. 5; J. Appl. Mech. Tech. Phys. 24, 733–743.",
    summary=(
        "In 1983 V. F. Nesterenko computed what happens when a row of touching steel spheres is struck: the blow breaks into "
        "solitary waves of a new kind, five grains long, whatever their height. This page computes every figure and number of "
        "the paper anew and sets ours beside what was printed.",
        "Nothing here is written by hand but the paper’s own numbers and the tolerances. A number is reproduced where ours "
        "rounds to what is printed, or lies within an error that the paper states. Where it has only a word, such as "
        "“satisfactory”, we read it as the number that stands beside it, and what keeps to that holds in part. A bound "
        "that any correct program keeps is called kept, not reproduced. Where a number does not come out, the page says so, "
        "with both numbers and the reason.",
        f"{RULE} So it is with grains that move or oscillate. "
        "Ours are printed with the digits that stay at half the step and half the time between two samples.",
    ),
    constants={
        "A": Constant(A, "N/(m^1.5 kg)", "stiffness of a contact over the mass of a grain", 1e12, 5e13),
        "N": Constant(
            N, "", "grains in the paper’s usual chain; other lengths keep their proportion to it", 40, 300, whole=True
        ),
        "seeds": Constant(SEEDS, "", "draws of each random chain; the paper has one", 4, 1000, whole=True, of_page=True),
    },
    entries=(
        section_1_contact_law.ENTRY,
        section_2_equations.ENTRY,
        section_2_stationary_waves.ENTRY,
        section_3_accuracy.ENTRY,
        section_31_first_grains.ENTRY,
        section_31_pressed.ENTRY,
        figure_3.ENTRY,
        section_32_head_on.ENTRY,
        section_32_striker_and_wall.ENTRY,
        section_32_overtaking.ENTRY,
        section_33_triangular_push.ENTRY,
        section_34_piston.ENTRY,
        section_34_speeds.ENTRY,
        section_34_losses.ENTRY,
        section_34_energy.ENTRY,
        section_35_profile.ENTRY,
        section_35_piston.ENTRY,
        section_35_free.ENTRY,
    ),
)
