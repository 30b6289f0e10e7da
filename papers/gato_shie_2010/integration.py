"""Integration of a thin wall

The paper's solid is meshfree (moving least squares in Galerkin form) and needs integration points. A free body has six
zero-energy modes, its rigid-body motions; with a rule that leaves more, the wall can bend, shear or fold without energy.
"""

from granular_env.components.shell.zero_modes import zero_mode_count
from pages import Page, show

# Layers of nodes, rule in the surface, Gauss points through the wall, our number of zero-energy modes.
RULES = ((3, "column", 2, "6"), (4, "column", 3, "6"), (3, "column", 1, "147"), (4, "column", 2, "28"), (3, "cell", 1, "114"))


def main(page: Page) -> None:
    """Count the zero-energy modes of a free patch."""
    for layers, rule, through, known in RULES:
        points = "one point per column" if rule == "column" else "2 x 2 points per cell"
        count = int(zero_mode_count(layers, rule, through, "linear", 1.7))
        page.add_value(f"{layers} layers, {points}, {through} through the wall: zero-energy modes", count, found=known)
    page.text("""The paper does not state its rule. Nodal integration, which it cites, has one point at each node and needs
        additional stabilisation. The component rejects every rule with more than six zero-energy modes.""")


if __name__ == "__main__":
    show(main)
