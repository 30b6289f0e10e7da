"""The picture of docs/theory.md, errors of velocities against the step, for integrators and laws: `python docs/accuracy.py`."""

import warnings
from pathlib import Path

import appearance
import numpy as np

import granular_env as ge
from granular_env.viewing.figures import drawing

IMAGE = Path(__file__).parent / "images" / "accuracy.png"
STEPS = (1e-6, 5e-7, 2e-7, 1e-7, 5e-8, 2e-8)
SPEED, DURATION, GRAINS = 5.0, 2e-4, 30
LAWS = {
    "hertz": {},
    "power, p = 1": {"law": {"name": "power", "exponent": 1.0}, "contact_stiffness": 1e7},
    "viscous": {"law": {"name": "viscous", "dissipation": 5.0}},
    "kuwabara_kono": {"law": {"name": "kuwabara_kono", "dissipation": 2e3}},
    "elastic_plastic": {"law": "elastic_plastic"},
}


def struck_velocities(step_size=None, **parameters):
    """Return the velocities after two grains of 5 m/s have struck a chain of thirty grains, and the step of the run."""
    chain = ge.make("chain", grains=GRAINS, velocity_scale=SPEED, step_size=step_size, **parameters)
    chain.reset(velocity={0: SPEED, 1: SPEED})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ge.GranularWarning)
        chain.step(round(DURATION / chain.step_size) * chain.step_size)
    return chain.get("velocity"), chain.step_size


def velocity_errors(steps, **parameters):
    """Return the largest error of a velocity over 5 m/s at each step, and the default step with its error."""
    exact = struck_velocities(2e-9, **parameters)[0]
    usual, default = struck_velocities(**parameters)
    found = []
    for step in steps:
        try:
            found.append(np.abs(struck_velocities(step, **parameters)[0] - exact).max() / SPEED)
        except ge.StepError:
            found.append(np.nan)
    return np.array(found), default, np.abs(usual - exact).max() / SPEED


@drawing.use_style
def draw_accuracy():
    """Draw integrators on the left, laws with the default integrator on the right; rings mark the defaults."""
    figure = drawing.new_figure(9.0, 4.0)
    left, right = figure.subplots(1, 2, sharey=True)
    schemes = {name: {"integrator": name} for name in ("pefrl", "leapfrog", "rk4", "hamming")}
    for axes, cases in ((left, schemes), (right, LAWS)):
        for place, (name, parameters) in enumerate(cases.items()):
            error, default, at_default = velocity_errors(STEPS, **parameters)
            line = drawing.line_style(place)
            axes.loglog(STEPS, error, **line, marker=".", label=name)
            axes.plot(default, at_default, "o", markersize=11, markerfacecolor="none", markeredgecolor=line["color"])
            print(f"{name}: default {default:g} s, error {at_default:.1e}; " + ", ".join(f"{e:.1e}" for e in error))
        axes.set(xlabel="step [s]")
        axes.legend()
    left.set(ylabel="largest velocity error / 5 m/s", title="Integrators, Hertz's law")
    right.set(title="Contact laws, pefrl")
    appearance.save_figure(figure, IMAGE, 100)


if __name__ == "__main__":
    draw_accuracy()
