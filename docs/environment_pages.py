"""Makes the page of the environments and its moving pictures: ``python docs/environment_pages.py``.

``--pages`` writes the page alone. Its sections are the docstrings of the environments, with tables of their spaces.
"""

import re
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path

import gymnasium
import numpy as np

import granular_env.envs  # noqa: F401 - registers the environments
from granular_env.components.variables import parse_element
from granular_env.domains import import_object, load_environments
from granular_env.domains.chain.tasks.driven_end import DrivenOptions
from granular_env.envs import ComponentEnv, rendering
from granular_env.envs.factory import options_type
from granular_env.envs.policies import OpenLoop

DOCS = Path(__file__).resolve().parent
PAGE, IMAGES = DOCS / "environments.md", DOCS / "images" / "environments"
FRAMES, COLOURS, SECONDS_A_FRAME = 60, 64, 0.1
SIZE = (720, 270)  # pixels
WIDTH = 128  # characters in a line of the page
# Chains first, as they share a section.
ENVIRONMENTS = dict(sorted(load_environments().items(), key=lambda item: ".chain." not in item[1].entry_point))
PUSH = "a push of 2.4 m/s for 18 us"
# Seed and baseline of the animated episode, if not the last baseline with seed 0. A new environment needs no line. Piston-v1
# has no baseline and shows the drive `PUSH`.
PLAYS: dict[str, tuple[int, str | OpenLoop]] = {
    "Piston-v1": (0, OpenLoop([0.24] * 12)),
    "Absorption-v1": (1, "theory"),
    "SolitonTrain-v1": (2, "theory"),
    "Confinement-v3": (0, "nothing"),
}
# Meaning of the colours of the pictures that do not show speed or velocity.
COLOURED = {
    "Splitting-v1": "red links are in tension, blue ones in compression",
    "Confinement-v3": "red is axial compression, blue tension",
    "Relief-v1": "red is pressure in the gas, and stress in the wall (the piece above)",
}
# Returns of a zero input, of theory, and of the best known policy, with the default arguments.
RETURNS = {
    "Piston-v1": ("0", "-", "0.77"),
    "PulseForming-v1": ("-1", "-7.3e-4", "-1.5e-13"),
    "Protection-v1": ("0", "0.792", "0.846"),
    "Absorption-v1": ("0", "0.9914 to 0.9935", "-"),
    "EnergyDelivery-v1": ("0", "0.809965", "0.810000"),
    "SolitonTrain-v1": ("-1", "-7.8e-4 to -1.4e-4", "-"),
    "Splitting-v1": ("0", "0.587", "0.85"),
    "BuriedTarget-v1": ("0", "1.000", "1.000"),
    "Confinement-v3": ("-1", "-0.089", "-0.063"),
    "Relief-v1": ("0.34", "0.60", "0.68"),
}
INTRODUCTION = """\
# Environments

<!-- Made by docs/environment_pages.py from docstrings. -->

An environment is a component with a task: an agent sets inputs of the component and receives rewards. The package registers
{count} of them with Gymnasium. [Train and optimise](training.md) shows their use, and
[Shaping a pulse](control.md) is a tutorial. `granular-env describe PulseForming-v1` prints a section of this page.

{table}

The last three columns are returns with the default arguments. "Theory" and "best known" are policies in
`env.unwrapped.task.baselines()`, except the best for `Piston-v1` (by hand) and for `Splitting-v1` (from the study
`splitting`). Sampled episodes have a range or a median. To play the baselines:

```python
import granular_env
import gymnasium as gym
from granular_env.envs.policies import play

env = gym.make("granular_env/EnergyDelivery-v1")
policies = env.unwrapped.task.baselines()
totals = {{name: round(play(env, policy, seed=0)[0], 4) for name, policy in policies.items()}}
print(totals)  # {{'nothing': 0.0, 'theory': 0.81, 'best': 0.81}}
```

The version in a name increases when the same actions no longer give the same returns.
"""
DRIVEN = """\
The five environments from `PulseForming-v1` to `SolitonTrain-v1` drive one end of a chain of equal spheres. Their sections list
only the differences from this one."""


def main() -> None:
    """Write the page, and the pictures unless ``--pages`` is given."""
    PAGE.write_text(make_page(), encoding="utf-8")
    for name in ENVIRONMENTS if "--pages" not in sys.argv else ():
        write_picture(name, IMAGES / f"{slug(short_name(name))}.gif")


def short_name(name: str) -> str:
    """`granular_env/PulseForming-v1` without its namespace."""
    return name.rpartition("/")[2]


def slug(short: str) -> str:
    """`PulseForming-v1` as a file name: `pulse-forming`."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "-", short.partition("-v")[0]).lower()


def make_page() -> str:
    """Return the page of all environments."""
    common, driven = docstring_sections(ComponentEnv), docstring_sections(DrivenOptions)
    common.pop(""), driven.pop("")
    # The component and the task are fixed in a registered environment.
    common["Arguments"] = re.sub(r"^\* `(component|task)`:.*?(?=^\* )", "", common["Arguments"], flags=re.MULTILINE | re.DOTALL)
    lines = [INTRODUCTION.format(count=len(ENVIRONMENTS), table="\n".join(summary()))]
    lines += ["## Common part", "", *paragraphs(common), "## Driven chains", "", DRIVEN, "", *paragraphs(driven)]
    lines += [*observation_table(make_environment(next(filter(is_driven, ENVIRONMENTS)))), ""]
    for name in ENVIRONMENTS:
        lines += section(name)
    return "\n".join(lines).rstrip() + "\n"


def summary() -> list[str]:
    """Return the lines of the table of all environments."""
    lines = ["| name | component | input | goal | zero input | theory | best known |", "|---|---|---|---|---|---|---|"]
    for name in ENVIRONMENTS:
        env, short = make_environment(name), short_name(name)
        inputs = ", ".join(f"`{one}`" for one in dict.fromkeys(parse_element(one).name for one in env.task.actions))
        goal = docstring_sections(import_object(ENVIRONMENTS[name].entry_point))[""].partition("\n")[0]
        returns = " | ".join(RETURNS.get(short, ("-", "-", "-")))
        lines.append(f"| [`{short}`](#{short.lower()}) | {env.component.name} | {inputs} | {goal} | {returns} |")
    return lines


def make_environment(name: str) -> ComponentEnv:
    """Return an environment with its default arguments."""
    env = gymnasium.make(name).unwrapped
    assert isinstance(env, ComponentEnv)
    return env


def section(name: str) -> list[str]:
    """Return the lines of the section of an environment."""
    env, short = make_environment(name), short_name(name)
    sections = docstring_sections(import_object(ENVIRONMENTS[name].entry_point))
    lines = [f"## {short}", "", sections.pop(""), ""]
    picture = f"![{caption(short)}](images/environments/{slug(short)}.gif)"
    lines += [picture, "", f"*{caption(short)}*", "", facts(env, name), ""]
    lines += paragraph("Action space", f"{actions_text(env)} {sections.pop('Action space', '')}")
    lines += paragraph("Observation space", sections.pop("Observation space", ""))
    table = observation_table(env)
    if not is_driven(name) or table != observation_table(make_environment(next(filter(is_driven, ENVIRONMENTS)))):
        lines += [*table, ""]
    return [*lines, *paragraphs(sections)]


def is_driven(name: str) -> bool:
    """Return whether an environment drives an end of a chain, with `DrivenOptions`."""
    return options_type(import_object(ENVIRONMENTS[name].entry_point)) is DrivenOptions


def facts(env: ComponentEnv, name: str) -> str:
    """Return the episode length and threshold of an environment."""
    steps = f"{env.deadline:g} control steps of {env.duration * 1e6:g} us ({env.internal_steps} internal steps each)"
    common = " A [driven chain](#driven-chains)." if is_driven(name) else ""
    return f"{steps}. Solved at a return of {gymnasium.spec(name).reward_threshold:g}.{common}"


def paragraphs(sections: dict[str, str]) -> list[str]:
    """Return the sections of a docstring as lines."""
    return [line for title, text in sections.items() for line in paragraph(title, text)]


def paragraph(title: str, text: str) -> list[str]:
    """Return a section with its title in bold as lines."""
    if text.startswith("* "):
        return [f"**{title}**", "", text, ""]
    start, _, rest = f"**{title}.** {text.strip()}".partition("\n\n")
    return [wrapped(start), "", *([rest, ""] if rest else [])]


def wrapped(text: str) -> str:
    """Return a paragraph in lines of the page, which do not break code and formulas."""
    whole = re.sub(r"`[^`]*`|\$[^$]*\$", lambda found: re.sub(r"\s+", "\0", found[0]), text)
    return textwrap.fill(whole, WIDTH, break_long_words=False, break_on_hyphens=False).replace("\0", " ")


def docstring_sections(kind: object) -> dict[str, str]:
    """Return the sections of a docstring, title -> text; the title of the text before the first section is ""."""
    first, _, rest = (kind.__doc__ or "").partition("\n")
    parts = re.split(r"^## (.*)$", f"{first}\n{textwrap.dedent(rest)}", flags=re.MULTILINE)
    named = zip(parts[1::2], parts[2::2], strict=True)
    return {"": parts[0].strip(), **{title.strip(): escape_stars(text.strip()) for title, text in named}}


def escape_stars(text: str) -> str:
    """Return a text whose stars mean stars, except those of lists, code and formulas."""
    pieces = re.split(r"(`[^`]*`|\$\$[^$]*\$\$|\$[^$]*\$|^ *\* )", text, flags=re.MULTILINE)
    return "".join(piece if place % 2 else piece.replace("*", r"\*") for place, piece in enumerate(pieces))


def actions_text(env: ComponentEnv) -> str:
    """Return a sentence with the input of each entry of an action."""
    words = []
    for name, scale in env.task.actions.items():
        variable = env.component.variables[parse_element(name).name]
        count = 1 if parse_element(name).index else int(np.prod(variable.shape))
        words.append(f"`{name}`{f' ({count} entries)' if count > 1 else ''}, {scale:g} {variable.unit} at action 1")
    return "; ".join(words) + "."


def observation_table(env: ComponentEnv) -> list[str]:
    """Return the lines of the table of an observation; all readings of the clock are one line."""
    lines = ["| observation | quantity | value at 1 |", "|---|---|---|"]
    rows, size = list(observation_rows(env)), env.observation_space.shape[0]
    clock = (size - env.clock, size - 1, f"clock: cos(pi k t / T), k = 1 to {env.clock}", "1")
    for first, last, quantity, unit in [*rows[: len(rows) - env.clock], *([clock] if env.clock else [])]:
        lines.append(f"| {first if first == last else f'{first} to {last}'} | {quantity} | {unit} |")
    return lines


def observation_rows(env: ComponentEnv) -> Iterator[tuple[int, int, str, str]]:
    """Yield first and last index of each part of a full observation, its quantity, and the value of an entry of 1."""
    sensors, size = env.sensors, env.observation_space.shape[0]
    for name, index, place, scale in sensors.readings:
        variable = env.component.variables[name]
        where = f" of every {variable.axes[0]}" if variable.axes else ""
        if index:
            where = f" at {', '.join(map(str, np.ravel(np.arange(variable.shape[0])[index[0]] if len(index) == 1 else index)))}"
        if len(variable.shape) > 1 and not index:
            where += f", {' x '.join(map(str, variable.shape))} numbers"
        yield place.start, place.stop - 1, f"`{name}`{where}", f"{scale:.6g} {variable.unit}".removesuffix(" 1")
    for place, (name, scale) in enumerate(sensors.goal.items(), sensors.size):
        yield place, place, f"`{name}` of the goal", f"{scale:.6g}"
    for k, place in enumerate(range(size - env.clock, size), 1):
        yield place, place, f"clock: cos({'' if k == 1 else f'{k} '}pi t / T)", "1"


def shown_play(short: str) -> tuple[int, str | OpenLoop]:
    """Return the seed of the episode that is shown, and which baseline or drive plays."""
    if short in PLAYS:
        return PLAYS[short]
    return 0, list(gymnasium.make(f"granular_env/{short}").unwrapped.task.baselines())[-1]  # type: ignore[attr-defined]


def caption(short: str) -> str:
    """Return what a moving picture shows."""
    policy = shown_play(short)[1]
    words = {"best": "the best known drive", "theory": "the baseline of theory", "nothing": "without any action"}
    who = words.get(policy, f"the baseline {policy!r}") if isinstance(policy, str) else PUSH
    return f"{short}: {who}" + (f"; {COLOURED[short]}" if short in COLOURED else "")


def write_picture(name: str, path: Path) -> None:
    """Play an episode and write it as a GIF."""
    from PIL import Image

    env, (seed, policy) = gymnasium.make(name, render_mode="rgb_array"), shown_play(short_name(name))
    player = env.unwrapped.task.baselines()[policy] if isinstance(policy, str) else policy
    player.reset()
    observation, info = env.reset(seed=seed)
    frames, over = [env.render()], False
    while not over:
        observation, _, terminated, truncated, info = env.step(player(observation, info))
        over = terminated or truncated
        frames.append(env.render())
    chosen = [frames[k] for k in np.unique(np.linspace(0, len(frames) - 1, FRAMES).round().astype(int))]
    path.parent.mkdir(parents=True, exist_ok=True)
    images = [Image.fromarray(one).resize(SIZE, Image.Resampling.LANCZOS) for one in chosen]
    palette = Image.fromarray(palette_strip()).quantize(COLOURS, dither=Image.Dither.NONE)
    small = [one.quantize(palette=palette, dither=Image.Dither.NONE) for one in images]
    durations = [SECONDS_A_FRAME * 1000.0] * (len(small) - 1) + [1500.0]
    small[0].save(path, save_all=True, append_images=small[1:], duration=durations, loop=0, optimize=True)
    print(path.name, path.stat().st_size // 1000, "kB")


def palette_strip() -> np.ndarray:
    """Return a picture that holds the colours of all others in equal parts: paper, ink, and blue to red; shape (8, n, 3)."""
    velocities = np.array(rendering.value_colours(np.linspace(-1.0, 1.0, 25) ** 3), dtype=np.uint8)
    greys = np.linspace(0, 255, 12).astype(np.uint8)[:, None].repeat(3, axis=1)
    colours = np.concatenate([velocities, velocities // 2, greys])
    return np.broadcast_to(colours, (8, *colours.shape)).copy()


if __name__ == "__main__":
    main()
