"""Section 2.3: the nodes of the interface, and the sub-steps of smaller automata

A node of the interface is also an automaton. Either each part moves it by its own forces and the momenta are added, or the
forces of both parts are added first. Automata may be n times smaller than cells; they then make several sub-steps per step of
the grid. In the paper they receive the velocities of the previous step and return the mean of their forces.
"""

from typing import Any

import numpy as np

import granular_env as ge
from granular_env.experiments import load_experiment
from half_space import MATERIAL, P_SPEED
from pages import Page, record, show

# A small block, half grid and half automata, with noisy initial motion: cell size [m], numbers of cells along and across.
SIZE, ALONG, ACROSS = 2.5e-3, 16, 8
ENERGIES = ("kinetic_energy", "rotational_energy", "elastic_energy", "hourglass_energy")


def noisy_block(scheme: str, step: float, ticks: int, smaller: int = 1, micro_steps: int = 1) -> dict[str, Any]:
    """Return the experiment of figure 6 for a small undriven block with a standing wave and 5 % noise.

    Args:
        scheme: scheme for the nodes of the interface.
        step: step of the grid [s].
        ticks: number of steps.
        smaller: n, the ratio of cell size to automata size.
        micro_steps: steps of the automata per grid step.
    """
    found = load_experiment("psakhie-2003/plane-wave-coupled").to_dict()
    component = found["component"]
    component["grid"]["mesh"] |= {"columns": ALONG, "rows": ACROSS, "cell_size": SIZE}
    component["grid"]["receivers"] = []
    component["automata"]["shape"] |= {"width": ALONG * SIZE, "height": ACROSS * SIZE}
    component["automata"]["diameter"] = SIZE / smaller
    component |= {"origin": [ALONG * SIZE, 0.0], "scheme": scheme, "micro_steps": micro_steps, "step_size": step}
    x = np.tile(np.arange(ALONG + 1), ACROSS + 1)
    velocity = 5e-3 * np.random.default_rng(3).standard_normal((len(x), 2))
    velocity[:, 0] += 0.1 * np.sin(np.pi * x / ALONG)
    return found | {
        "input": {},
        "start": {"grid_velocity": velocity.tolist()},
        "duration": ticks * step,
        "record": {"every": 10.0 * step, "variables": ["grid_velocity", "automata_velocity"]},
    }


def contour(first: float, second: float, third: float, fourth: float) -> float:
    """Return the vertical sum of (11) and (15) for σ_yy in the cells I to IV around a node, for unit cells."""
    # x of the lower, right, upper and left neighbours; cell I lies between the second and the third, and so on.
    x1, x2, x3, x4 = 0.0, 1.0, 0.0, -1.0
    return first * (x2 - x3) + second * (x3 - x4) + third * (x4 - x1) + fourth * (x1 - x2)


def interface_force(strain: float = 1e-10) -> float:
    """Return the largest force on inner interface nodes in a homogeneous strain, divided by stress and cell size."""
    document = noisy_block("force", 1e-7, 1)
    nodes = np.stack(np.meshgrid(np.arange(ALONG + 1) * SIZE, np.arange(ACROSS + 1) * SIZE), axis=-1).reshape(-1, 2)
    block: Any = ge.make("coupled", **{key: value for key, value in document["component"].items() if key != "type"})
    block.reset(**{f"{part}_displacement": strain * x[:, None] * [1.0, 0.0] for part, x in
                   (("grid", nodes[:, 0]), ("automata", nodes[:, 0] + ALONG * SIZE))})  # fmt: skip
    block.step(1e-7)
    forces = block.forces_on_nodes()[block.interface.nodes[2:-2]]
    return float(np.abs(forces).max() / (MATERIAL.density * P_SPEED**2 * strain * SIZE))


def main(page: Page) -> None:
    """Run both schemes from a noisy start, insert a homogeneous stress into (18), and run smaller automata with sub-steps."""
    logs = [record(noisy_block(scheme, 1e-7, 400)) for scheme in ("force", "momentum")]
    ends = [np.concatenate([log.series(f"{part}_velocity")[1][-1] for part in ("grid", "automata")]) for log in logs]
    page.add_heading('"Two approaches are possible": momenta of node and automaton are added, or the forces of both')
    gap = float(np.abs(ends[0] - ends[1]).max() / np.abs(ends[0]).max())
    page.compare("difference of the velocities after 400 steps", "both ensure continuity", gap, near=0.0, within=1e-10)
    page.text("Both are equal: m V = m_a V_a + m_c V_c after a kick of each part is one kick by the sum of the forces.")

    page.add_heading("(15) to (18): force on an interface node under homogeneous stress σ, cells of side Δ")
    page.compare("mass accelerated by these sums, over φ", "2", contour(0.5, 0.5, -0.5, -0.5), near=2.0, within=1e-12)
    below = contour(0.0, 0.0, 1.0, 1.0)
    page.compare("force with F'", "none", abs(below + 1.0), "σΔ", near=0.0, within=1e-12, found="1.0")
    page.add_value("force with 2 F'", abs(below + 2.0), "σΔ", "0.0")
    page.add_value("force in our interface", interface_force(), "σΔ", "0.0000000000")
    page.text("""The sums of (15) to (18) lack the factor 1/2 of (11), so the mass on their left side is 2φ, twice that of the
        node. The force F' of the automata would therefore have to be doubled: with F' as printed, a body under homogeneous
        stress does not stay at rest. The paper's figures show no such motion, so the text is wrong, but not its program.""")
    page.add_heading("Sub-steps of n times smaller automata: no loss or generation of energy, complete transfer of momentum")
    curves = {}
    for n, energy_known, momentum_known in ((2, "3.8e2", "11"), (3, "1.1e5", "105")):
        # Impulses use half the grid step, because a longer step is refused for automata of a third of a cell.
        for scheme, words, part in (("literal", "as written", 1), ("force", "impulses", 2)):
            log = record(noisy_block(scheme, 2e-7 / part, 2000 * part, n, 2 * n // part))
            energy = np.sum([log.series(name)[1] for name in ENERGIES], axis=0)
            curves[f"n = {n}, {words}"] = log.times("kinetic_energy"), energy / energy[0]
            missing, momentum = (float(np.abs(log.series(name)[1]).max()) for name in ("momentum_residual", "momentum"))
            if scheme == "literal":
                held = {"near": 1.0, "within": 0.05, "reading": "within 5 %"}
                grown = float(energy[-1] / energy[0])
                page.compare(f"n = {n}, as written: energy at the end over the start", "1", grown, **held, found=energy_known)
                page.compare(f"n = {n}, as written: momentum missing", "complete", 100.0 * missing / momentum, "%", near=0.0,
                             within=1e-8, found=momentum_known)  # fmt: skip
            else:
                change = 100.0 * float(np.abs(energy / energy[0] - 1.0).max())
                page.add_value(f"n = {n}, impulses: largest change of energy", change, "%", "0.07")
                page.add_value(f"n = {n}, impulses: momentum missing", 100.0 * missing / momentum, "%", "0.00000000")
    page.text("""A small undriven block in noisy motion, 2000 steps of the grid; n automata are as long as a cell. In steps 2
        to 4 of the algorithm the automata use the velocities of the previous step, and the grid uses the mean of their
        forces. These outdated values do work, so the noise grows without bound. The paper's own runs use automata of the size
        of cells (section 3), without sub-steps. Impulses are stable: the nodes of the interface move with the automata in
        each sub-step, and the cells kick them once per step (r-RESPA). The option scheme = "force" or "literal" selects the
        scheme of an experiment.""")
    with page.plot("Energy of an undriven block, with the paper's sub-steps and with impulses.", "time, µs",
                   "energy over initial energy") as axes:  # fmt: skip
        for number, (label, (times, energy)) in enumerate(curves.items()):
            axes.semilogy(1e6 * times, energy, ("-", "--")[number % 2], color=f"C{number // 2}", label=label)


if __name__ == "__main__":
    show(main)
