"""Integration of a thin wall

The paper's solid is meshfree, with moving least squares in a Galerkin form: it needs points at which stresses are computed. A
free body has six motions without energy, the rigid ones; a rule with more lets the wall bend, shear or fold at no cost.
"""

from granular_env.components.shell.zero_modes import zero_mode_count
from pages import Page, show

# Layers of nodes, rule in the surface, Gauss points through the wall, our number of zero-energy modes.
RULES = ((3, "column", 2, "6"), (4, "column", 3, "6"), (3, "column", 1, "147"), (4, "column", 2, "28"), (3, "cell", 1, "114"))


def main(page: Page) -> None:
    """Count the zero-energy modes of a free patch."""
    for layers, rule, through, known in RULES:
        points = "one point a column" if rule == "column" else "2 x 2 points a cell"
        count = int(zero_mode_count(layers, rule, through, "linear", 1.7))
        page.add_value(f"{layers} layers, {points}, {through} through the wall: modes without energy", count, found=known)
    page.text("""The paper does not print its rule; nodal integration, which it cites, has one point at each node and needs a
        stabilisation of its own. The component refuses every rule that has more than six.""")


if __name__ == "__main__":
    show(main)
