"""Pictures of docs/laws.md from runs of the chain, collisions and solitary waves: `python docs/law_pictures.py`."""

from pathlib import Path

import appearance
import numpy as np

import granular_env as ge
from granular_env.components.chain import theory
from granular_env.domains.chain import measurement
from granular_env.viewing.figures import drawing

IMAGES = Path(__file__).parent / "images" / "laws"
_COLOURS = 64
VISCOUS = {"name": "viscous", "dissipation": 1.0}
KUWABARA_KONO = {"name": "kuwabara_kono", "dissipation": 500.0}
DISSIPATIVE = (
    ("viscous", VISCOUS, theory.viscous_loss_without_tension),
    ("kuwabara-kono", KUWABARA_KONO, theory.kuwabara_kono_loss),
)


def pair(speed, **parameters):
    """Return two steel grains, of which the left one approaches the right one, with a tenth of the suggested step."""
    usual = ge.make("chain", grains=2, velocity_scale=speed, **parameters)
    chain = ge.make("chain", grains=2, velocity_scale=speed, step_size=0.1 * usual.step_size, **parameters)
    chain.reset(velocity={0: speed})
    return chain


def collide(speed, **parameters):
    """Return overlaps, forces and times of a pair's contact until it opens, and the coefficient of restitution."""
    chain, seen = pair(speed, **parameters), []
    while chain.get("overlap")[1] >= 0.0:
        chain.step(chain.step_size)
        seen.append((chain.get("overlap")[1], chain.get("contact_force")[1], chain.time))
    before, after = chain.get("velocity")
    overlap, force, time = np.array(seen).T
    return np.maximum(overlap, 0.0), force, time, (after - before) / speed


def restitutions(speeds, **parameters):
    """Return the coefficient of restitution at each speed."""
    return np.array([collide(speed, **parameters)[3] for speed in speeds])


def scales(**parameters):
    """Return the reduced mass and the stiffness of the pair's contact."""
    chain = ge.make("chain", grains=2, **parameters).geometry
    return chain.reduced_mass[1], chain.stiffness[1]


def draw_force_loops(axes, cases):
    """Draw force against overlap, one curve per case (label, speed, parameters)."""
    for place, (label, speed, parameters) in enumerate(cases):
        overlap, force, _, _ = collide(speed, **parameters)
        axes.plot(overlap * 1e6, force, **drawing.line_style(place), label=label)
    axes.set(xlabel="overlap [µm]", ylabel="force [N]", title="One collision")
    axes.legend()


def plain_ticks(axes, values):
    """Label a logarithmic axis y with decimal numbers; values outside its limits are left out."""
    low, high = axes.get_ylim()
    shown = [value for value in values if low <= value <= high]
    axes.set_yticks(shown, [f"{value:g}" for value in shown])
    axes.tick_params(axis="y", which="minor", left=False, labelleft=False)


def save_picture(figure, name):
    """Write the PNGs of a figure, with few colours, to docs/images/laws."""
    appearance.save_figure(figure, IMAGES / f"{name}.png", 100, _COLOURS)


@drawing.use_style
def draw_hertz():
    """Draw forces and the duration of a collision."""
    figure = drawing.new_figure(9.0, 3.6)
    left, right = figure.subplots(1, 2)
    draw_force_loops(left, [(name, 1.0, {"material": name}) for name in ("steel", "glass", "aluminium")])
    speeds = np.geomspace(1e-3, 10.0, 9)
    mass, stiffness = scales()
    right.loglog(speeds, 1e6 * theory.collision_duration(mass, stiffness, speeds), **drawing.line_style(0), label="theory")
    right.loglog(
        speeds, [1e6 * collide(speed)[2][-1] for speed in speeds], "o", color=drawing.line_style(1)["color"], label="runs"
    )
    right.set(xlabel="relative speed [m/s]", ylabel="duration [µs]", title="Two steel grains: proportional to v^(-1/5)")
    plain_ticks(right, (10, 20, 30, 50, 70))
    right.legend()
    save_picture(figure, "hertz")


@drawing.use_style
def draw_power():
    """Draw the forces of several exponents, and their solitary waves."""
    figure = drawing.new_figure(9.0, 3.6)
    left, right = figure.subplots(1, 2)
    exponents = (1.2, 1.5, 2.0, 3.0)
    mass = ge.make("chain", grains=1).geometry.mass[0]
    for place, exponent in enumerate(exponents):
        # The stiffness at which the largest overlap is 10 um at 1 m/s.
        stiffness = 0.25 * mass * (exponent + 1.0) / 1e-5 ** (exponent + 1.0)
        law = {"law": {"name": "power", "exponent": exponent}, "contact_stiffness": stiffness}
        overlap, force, _, _ = collide(1.0, **law)
        left.plot(overlap * 1e6, force, **drawing.line_style(place), label=f"p = {exponent:g}")
        chain = ge.make("chain", grains=81, velocity_scale=1.0, **law)
        chain.reset(velocity={0: 1.0})
        motion = measurement.observe(chain, 3000 * chain.step_size, chain.step_size)
        wave = measurement.waves_at(motion, 60, above=0.1)[0]
        spacing = np.diff(motion.position)[0]
        right.plot(
            (motion.time - wave.time) * wave.speed / spacing,
            motion.velocity[:, 60] / wave.amplitude,
            **drawing.line_style(place),
        )
    left.set(xlabel="overlap [µm]", ylabel="force [N]", title="One collision at 1 m/s")
    left.legend()
    right.set(
        xlim=(-6, 6), xlabel="distance from the crest [diameters]", ylabel="velocity / its maximum", title="Solitary waves"
    )
    save_picture(figure, "power")


@drawing.use_style
def draw_dissipative(name, law, loss):
    """Draw the force loop and the energy loss of a collision."""
    figure = drawing.new_figure(9.0, 3.6)
    left, right = figure.subplots(1, 2)
    stronger = {**law, "dissipation": 5.0 * law["dissipation"]}
    unit = "N s/m" if law["name"] == "viscous" else "N s/m^1.5"
    draw_force_loops(
        left, [("hertz", 1.0, {}), *((f"{one['dissipation']:g} {unit}", 1.0, {"law": one}) for one in (law, stronger))]
    )
    speeds = np.geomspace(1e-2, 10.0, 13)
    mass, stiffness = scales()
    right.loglog(
        speeds, loss(mass, stiffness, law["dissipation"], speeds), **drawing.line_style(1), label="theory, small losses"
    )
    right.loglog(speeds, 1.0 - restitutions(speeds, law=law), "o", color=drawing.line_style(1)["color"], label="runs")
    right.set(xlabel="relative speed [m/s]", ylabel="1 - e", title=f"Loss at {law['dissipation']:g} {unit}")
    plain_ticks(right, (0.007, 0.01, 0.02, 0.03, 0.05))
    right.legend()
    save_picture(figure, name)


def thornton_modulus(ratio):
    """Return e of two elastic-plastic spheres (Thornton 1997, eq. 55) at `ratio` = yield speed / impact speed."""
    root = np.sqrt(1.2 - 0.2 * ratio * ratio)
    return np.sqrt(1.2 * np.sqrt(3.0) * (1.0 - ratio * ratio / 6.0)) * (ratio / (ratio + 2.0 * root)) ** 0.25


@drawing.use_style
def draw_elastic_plastic():
    """Draw two collisions of the same contact, and restitution against Thornton's formula."""
    figure = drawing.new_figure(9.0, 3.6)
    left, right = figure.subplots(1, 2)
    plastic = {"law": "elastic_plastic"}
    draw_force_loops(left, [("hertz, 2 m/s", 2.0, {}), ("yielding, 2 m/s", 2.0, plastic), ("yielding, 1 m/s", 1.0, plastic)])
    mass, stiffness = scales(**plastic)
    root = ge.make("chain", grains=2, **plastic).geometry.law_constants[1, 0]
    yielding = np.sqrt(0.8 * stiffness * root**5 / mass)
    speeds = np.geomspace(0.02, 10.0, 16)
    right.loglog(speeds, thornton_modulus(np.minimum(yielding / speeds, 1.0)), **drawing.line_style(1), label="Thornton")
    right.loglog(speeds, restitutions(speeds, **plastic), "o", color=drawing.line_style(1)["color"], label="runs")
    right.set(xlabel="relative speed [m/s]", ylabel="e", title="Restitution of two steel grains")
    plain_ticks(right, (0.5, 0.6, 0.7, 0.8, 0.9, 1.0))
    right.legend()
    save_picture(figure, "elastic-plastic")


@drawing.use_style
def draw_linear():
    """Draw force against overlap, and restitution against the damping ratio, with and without tension."""
    figure = drawing.new_figure(9.0, 3.6)
    left, right = figure.subplots(1, 2)
    spring = {"mass": 2e-3, "contact_stiffness": 1e7}
    critical = 2.0 * np.sqrt(np.prod(scales(law="linear", **spring)))

    def law(ratio):
        return {"law": {"name": "linear", "dissipation": ratio * critical}, **spring}

    draw_force_loops(left, [(f"zeta = {ratio:g}", 1.0, law(ratio)) for ratio in (0.0, 0.1, 0.4)])
    ratios = np.linspace(0.0, 0.9, 91)
    root = np.sqrt(1.0 - ratios**2)
    right.plot(ratios, np.exp(-np.pi * ratios / root), **drawing.line_style(0), label="theory, with tension")
    opening = np.pi - np.arctan2(2.0 * ratios * root, 1.0 - 2.0 * ratios**2)
    right.plot(ratios, np.exp(-ratios / root * opening), **drawing.line_style(1), label="theory, without tension")
    runs = np.linspace(0.0, 0.9, 10)
    right.plot(runs, [collide(1.0, **law(ratio))[3] for ratio in runs], "o", color=drawing.line_style(1)["color"], label="runs")
    right.set(xlabel="damping ratio", ylabel="e", title="Restitution at any speed")
    right.legend()
    save_picture(figure, "linear")


@drawing.use_style
def draw_walton_braun():
    """Draw three collisions, and restitution against the ratio of the stiffnesses."""
    figure = drawing.new_figure(9.0, 3.6)
    left, right = figure.subplots(1, 2)

    def law(ratio):
        unloading = {"name": "walton_braun", "unloading_stiffness": 1e7 / ratio}
        return {"law": unloading, "mass": 2e-3, "contact_stiffness": 1e7}

    draw_force_loops(
        left, [("k1/k2 = 0.5, 1 m/s", 1.0, law(0.5)), ("k1/k2 = 0.5, 0.6 m/s", 0.6, law(0.5)), ("k1/k2 = 0.2", 1.0, law(0.2))]
    )
    ratios, runs = np.linspace(0.02, 1.0, 99), np.linspace(0.1, 1.0, 10)
    right.plot(ratios, np.sqrt(ratios), **drawing.line_style(1), label="sqrt(k1/k2)")
    right.plot(runs, [collide(1.0, **law(ratio))[3] for ratio in runs], "o", color=drawing.line_style(1)["color"], label="runs")
    right.set(xlabel="k1 / k2", ylabel="e", title="Restitution at any speed")
    right.legend()
    save_picture(figure, "walton-braun")


def draw_laws():
    """Draw all of them."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    draw_hertz()
    draw_power()
    for name, law, loss in DISSIPATIVE:
        draw_dissipative(name, law, loss)
    draw_elastic_plastic()
    draw_linear()
    draw_walton_braun()


if __name__ == "__main__":
    draw_laws()
