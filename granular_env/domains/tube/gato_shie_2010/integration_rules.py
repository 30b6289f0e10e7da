"""Integration rules of the thin wall: which of them leave deformations without energy."""

from __future__ import annotations

from granular_env.atlas.context import Context
from granular_env.atlas.model import Entry, Findings, Item
from granular_env.atlas.verdicts import Value
from granular_env.components.shell.zero_modes import RIGID_MOTIONS, zero_mode_count

_RADIUS = 1.7
# Layers of nodes, rule in the surface, Gauss points through the wall.
_RULES = ((3, "column", 2), (4, "column", 3), (3, "column", 1), (4, "column", 2), (3, "cell", 1))


def compute(context: Context) -> Findings:
    """Count the modes without energy of a free patch."""
    values: list[Value] = []
    for layers, rule, through in _RULES:
        count = zero_mode_count(layers, rule, through, "linear", _RADIUS)
        name = f"{layers} layers, one point a {rule}" if rule == "column" else f"{layers} layers, 2 x 2 points a cell"
        values.append(Value(f"{name}, {through} through the wall: modes without energy", None, float(count), digits=3))
    return Findings([
        Item(
            "Where stresses are computed", "not in the paper", values,
            remark=f"A free body has {RIGID_MOTIONS} motions without energy, the rigid ones; a rule with more lets the wall "
            "bend, "
            "shear or fold at no cost. The paper does not print its rule; nodal integration, which it cites, has one point at "
            "each node and needs a stabilisation of its own. The component refuses every rule that has more than six.",
        )
    ])  # fmt: skip


ENTRY = Entry(
    "integration",
    "Method",
    "Integration of a thin wall",
    "The paper’s solid is meshfree, with moving least squares in a Galerkin form: it needs points at which stresses are "
    "computed.",
    compute,
    weight=2.0,
    runs=0,
)
