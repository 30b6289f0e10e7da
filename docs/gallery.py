"""Makes the logs in logs/gallery and their pictures in docs/control.md: ``python docs/gallery.py``."""

import sys
from collections.abc import Callable
from pathlib import Path

import appearance
import numpy as np

import granular_env as ge
from granular_env.domains.chain.tasks.absorption import make_absorption
from granular_env.domains.chain.tasks.matched_end import Dashpot, SensorScales
from granular_env.domains.chain.tasks.pulse_forming import make_pulse_forming
from granular_env.envs import ComponentEnv
from granular_env.envs.policies import OpenLoop, Policy
from granular_env.recording import open_log
from granular_env.viewing import recorded_fields, scene_builder
from granular_env.viewing.figures import drawing

ROOT = Path(__file__).resolve().parent.parent
sys.path.append(str(ROOT / "examples"))

import pulse_shaping  # noqa: E402

LOGS, IMAGES = ROOT / "logs" / "gallery", ROOT / "docs" / "images"
EVERY = 3e-6  # s
SETTING = {"grains": 100, "place": 60, "deadline": 270, "action_scale": pulse_shaping.SCALE}
DISORDERED = {"radius": {"low": 2.85e-3, "high": 3.15e-3, "seed": 1}}
DISSIPATIVE = {"law": {"name": "viscous", "dissipation": 2.0}}
WAVE = {"velocity": {0: 5.0, 1: 5.0}}  # strikers opposite the absorbing end
BEST_DASHPOT = 63.0  # N s/m, found by examples/absorbing_end.py
_COLOURS = 128


def record_episode(name: str, env: ComponentEnv, policy: Policy, options: dict | None = None) -> dict[str, float]:
    """Record one episode as logs/gallery/NAME.mcap and return its counters."""
    titled = {"experiment": {"name": f"gallery/{name}"}, "variables": ["displacement", "velocity"]}
    with ge.record(env.component, LOGS / f"{name}.mcap", every=EVERY, overwrite=True, **titled):
        observation, info = env.reset(seed=0, options=options)
        policy.reset()
        over = False
        while not over:
            observation, _, terminated, truncated, info = env.step(policy(observation, info))
            over = terminated or truncated
    return {counter: float(info[counter]) for counter in env.task.counter_names}


def record_drive(name: str, env: make_pulse_forming, drive: np.ndarray) -> None:
    """Record a drive [N] and print the remaining motion."""
    print(name, record_episode(name, env, OpenLoop(drive / pulse_shaping.SCALE)))


def one_wave() -> None:
    """Record the paper's triangle, and a drive that makes a wave of the same height with a lower force."""
    brief = {"duration": 3.96e-4, "record.every": EVERY, "record.variables": ["displacement", "velocity"]}
    ge.run("nesterenko-1983/3.3-triangle-10us", log=LOGS / "triangle.mcap", overrides=brief, overwrite=True)
    env = make_pulse_forming(
        100,
        place=60,
        amplitude=pulse_shaping.triangle_height(),
        deadline=264,
        action_scale=pulse_shaping.SCALE,
        chain=pulse_shaping.PAPER,
    )
    record_drive("one-wave", env, pulse_shaping.shape_drive(env, pushed=45))


def other_chains() -> None:
    """Record the best drive found in each chain, and the drive of the uniform chain."""
    uniform = pulse_shaping.shape_drive(make_pulse_forming(**SETTING), pushed=50)
    for name, chain in (("disordered", DISORDERED), ("dissipative", DISSIPATIVE)):
        env = make_pulse_forming(**SETTING, chain=chain)
        record_drive(name, env, pulse_shaping.shape_drive(env))
        record_drive(f"{name}-uniform-drive", env, uniform)


def two_waves() -> None:
    """Record a drive that makes two waves."""
    env = pulse_shaping.two_waves_environment()
    record_drive("two-waves", env, pulse_shaping.shape_drive(env, pushed=120))


def absorbing_ends() -> None:
    """Record the same impact on a piston at rest, a dashpot and an active end."""
    piston = make_absorption()
    for name, policy in (("wall", "nothing"), ("absorbing-piston", "theory")):
        print(name, record_episode(name, piston, piston.task.baselines()[policy], WAVE))
    force = make_absorption(action="force", internal_steps=2, deadline=600)
    task = force.task
    sensors = SensorScales.from_task(task)
    dashpot = Dashpot(BEST_DASHPOT, 1.0, force.duration, task.actions["right_force"], sensors)
    print("dashpot", record_episode("dashpot", force, dashpot, WAVE))


@drawing.use_style
def draw_logs(name: str, titles: dict[str, str]) -> None:
    """Draw the input of each log above its x-t diagram, side by side."""
    figure = drawing.new_figure(5.0 * len(titles), 6.0)
    panels = figure.subplots(2, len(titles), squeeze=False, height_ratios=[2, 5])
    for place, (log, title) in enumerate(titles.items()):
        seen = scene_builder.load_scene(open_log(LOGS / f"{log}.mcap"))
        above, below = panels[:, place]
        curve = max(seen.inputs.values(), key=lambda curve: (np.abs(curve.values).max(), curve.name))
        above.plot(curve.times * 1e6, curve.values, **drawing.line_style(0))
        above.set(title=title, xlabel="time [us]", ylabel=f"{curve.name.replace('_', ' ')} [{curve.unit}]")
        drawing.draw_space_time(figure, below, recorded_fields.to_field(seen.motion), None)
    appearance.save_figure(figure, IMAGES / f"gallery-{name}.png", 90, _COLOURS)


def pictures() -> None:
    """Draw all pictures from the logs."""
    best, borrowed = "best drive found", "drive of the uniform chain"
    draw_logs("one-wave", {"triangle": "The paper's triangle, 1764 N", "one-wave": "Shaped drive, 1195 N"})
    draw_logs("two-waves", {"two-waves": "5 m/s, and 3 m/s 100 us behind"})
    draw_logs("disordered", {"disordered-uniform-drive": f"Radii +-5 %: {borrowed}", "disordered": best})
    draw_logs("dissipative", {"dissipative-uniform-drive": f"2 N s/m: {borrowed}", "dissipative": best})
    draw_logs("absorbing", {"wall": "A piston at rest", "dashpot": "Best linear dashpot", "absorbing-piston": "An active end"})


def main(parts: list[Callable[[], None]]) -> None:
    """Run some or all parts."""
    LOGS.mkdir(parents=True, exist_ok=True)
    for part in parts:
        part()


if __name__ == "__main__":
    main([one_wave, other_chains, two_waves, absorbing_ends, pictures])
