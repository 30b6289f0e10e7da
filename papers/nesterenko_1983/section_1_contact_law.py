"""Section 1: the contact law and its limits

Neighbouring grains repel each other with F = k δ^(3/2), where δ is the approach of their centres, and never attract (Hertz's
static law). The paper names three conditions under which the static law describes a collision.
"""

import numpy as np

import granular_env as ge
from chains import DENSITY, MASS, POISSON, RADIUS, SPEED, STEEL, YOUNG, A, run_struck_chain
from granular_env.components.chain import theory
from pages import Page, show


def main(page: Page) -> None:
    """Compute A from the constants of steel, the time of a collision, and the limits of the static law."""
    page.add_heading("A of steel grains of 3 mm, (2.1)")
    ours = theory.contact_constant(YOUNG, POISSON, DENSITY, RADIUS)
    page.compare("A", "5.6e12", ours, "N/(m^1.5 kg)", found="6.3913e12")
    page.text(f"""E = 2e11 Pa, ν = 0.29 and ρ = 7800 kg/m³, which the paper gives in section 3.5, yield {ours:.4g}; the
        printed A requires E = {YOUNG * A / ours:.3g} Pa. Sections 3.1 to 3.4 use the printed A, section 3.5 the printed
        constants. Only the unit of time depends on A.""")

    page.add_heading("Time of a collision, T1 = C (5/8A)^(2/5) / v0^(1/5), section 3")
    pair = run_struck_chain((1,), 6e-5, 5e-8, grains=2, step_size=2.5e-8)
    overlap = pair.overlap[:, 1]
    last = int(np.argmax(overlap[1:] < 0.0))
    touched = pair.time[last] + (pair.time[1] - pair.time[0]) * overlap[last] / (overlap[last] - overlap[last + 1])
    unit = (5.0 / (8.0 * A)) ** 0.4 * SPEED**-0.2
    page.compare("C", "2.94", touched / unit, found="2.9433")
    page.add_value("T1 at 5 m/s", 1e6 * touched, "µs", found="14.064")
    page.text(f"Exactly, C = 2 √π Γ(7/5)/Γ(9/10) = {theory.COLLISION_COEFFICIENT:.5f}.")

    page.add_heading("Limits of the static law at the paper's 5 m/s, two moving grains of section 3.1")
    chain = ge.Chain(grains=100, **STEEL)
    chain.reset(velocity={0: SPEED, 1: SPEED})
    chain.step(2e-4)
    report = chain.report()
    pressure = report["peak pressure / pressure at first yield"]
    page.compare("pressure / yield pressure", "below 1", pressure, most=1.0, found="2.487")
    much = {"most": 0.1, "reading": "below 0.1"}
    page.compare("contact radius / grain radius", "much less than 1", report["contact radius / grain radius"],
                 **much, found="0.06535")  # fmt: skip
    slowness = 1.0 / report["collision time / grain's oscillation time (tau/T)"]
    page.compare("grain's oscillation time / collision time", "much less than 1", slowness, **much, found="0.09362")
    page.text(f"""The contact pressure is {pressure:.2g} times the pressure at first yield, which is reached at
        {SPEED * pressure**-2.5:.2g} m/s. Real steel grains would deform plastically. We integrate the same elastic equations
        as the paper.""")

    with page.plot(
        "Two grains meet at 5 m/s: the force while they touch. Dotted: the printed T1.", "time, µs", "force, N"
    ) as axes:
        axes.plot(1e6 * pair.time, A * MASS * np.maximum(overlap, 0.0) ** 1.5)
        axes.axvline(1e6 * 2.94 * unit, color="0.4", linestyle=":")


if __name__ == "__main__":
    show(main)
