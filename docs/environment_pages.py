"""Makes the pages of the environments and their moving pictures: ``python docs/environment_pages.py``.

``--pages`` writes the pages alone. Each page is the docstring of the environment, with tables of its spaces.
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
from granular_env.envs import ComponentEnv, rendering
from granular_env.envs.policies import OpenLoop

DOCS = Path(__file__).resolve().parent
PAGES, IMAGES = DOCS / "environments", DOCS / "images" / "environments"
FRAMES, COLOURS, SECONDS_A_FRAME = 60, 64, 0.1
SIZE = (720, 270)  # pixels
ENVIRONMENTS = load_environments()
PUSH = "a push of 2.4 m/s for 18 us"
# Seed and baseline of the animated episode, if not the last baseline with seed 0. A new environment needs no line. Piston-v1
# has no baseline and shows the drive `PUSH`.
PLAYS: dict[str, tuple[int, str | OpenLoop]] = {
    "Piston-v1": (0, OpenLoop([0.24] * 12)),
    "Absorption-v1": (1, "theory"),
    "SolitonTrain-v1": (2, "theory"),
    "Confinement-v3": (0, "nothing"),
}


def main() -> None:
    """Write all pages, and the pictures unless ``--pages`` is given."""
    PAGES.mkdir(exist_ok=True)
    for name in ENVIRONMENTS:
        short = name.rpartition("/")[2]
        (PAGES / f"{slug(short)}.md").write_text(make_page(name), encoding="utf-8")
        if "--pages" not in sys.argv:
            write_picture(name, IMAGES / f"{slug(short)}.gif")


def slug(short: str) -> str:
    """`PulseForming-v1` as a file name: `pulse-forming`."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "-", short.partition("-v")[0]).lower()


def make_page(name: str) -> str:
    """Return the page of an environment."""
    env, short = gymnasium.make(name).unwrapped, name.rpartition("/")[2]
    assert isinstance(env, ComponentEnv)
    spec, sections = gymnasium.spec(name), docstring_sections(import_object(ENVIRONMENTS[name].entry_point))
    lines = [f"# {short}", "", sections.pop(""), ""]
    lines += [f"![{caption(short)}](../images/environments/{slug(short)}.gif)", "", f"*{caption(short)}*", ""]
    lines += [f"| made by | `gymnasium.make({name!r})` |", "|---|---|", f"| action space | `{env.action_space}` |"]
    lines += [f"| observation space | `{box_text(env)}` |"]
    lines += [f"| control steps | {env.deadline:g} of {env.duration * 1e6:g} us; {env.internal_steps} internal steps each |"]
    lines += [f"| reward threshold | {spec.reward_threshold:g}, what {threshold_source(short)} returns, rounded down |"]
    for title, text in sections.items():
        lines += ["", f"## {title}", ""]
        if title == "Action space":
            lines += [*action_table(env), ""]
        if title == "Observation space":
            lines += [*observation_table(env), ""]
        lines += [text]
    return "\n".join([*lines, "", *shared_lines()]).rstrip() + "\n"


def shared_lines() -> list[str]:
    """Return what holds of every environment: the sections of `ComponentEnv`, a level lower."""
    sections = docstring_sections(ComponentEnv)
    sections.pop("")
    lines = ["## Options of every environment", ""]
    for title, text in sections.items():
        # The component and the task are given already.
        kept = re.sub(r"^\* `(component|task)`:.*?(?=^\* )", "", text, flags=re.MULTILINE | re.DOTALL)
        lines += [f"### {title}", "", kept, ""]
    return lines


def docstring_sections(kind: object) -> dict[str, str]:
    """Return the sections of a docstring, title -> text; the title of the text before the first section is ""."""
    first, _, rest = (kind.__doc__ or "").partition("\n")
    parts = re.split(r"^## (.*)$", f"{first}\n{textwrap.dedent(rest)}", flags=re.MULTILINE)
    named = zip(parts[1::2], parts[2::2], strict=True)
    return {"": parts[0].strip(), **{title.strip(): escape_stars(text.strip()) for title, text in named}}


def escape_stars(text: str) -> str:
    """Return a text whose stars mean stars, but for those of lists and code."""
    pieces = re.split(r"(`[^`]*`|^ *\* )", text, flags=re.MULTILINE)
    return "".join(piece if place % 2 else piece.replace("*", r"\*") for place, piece in enumerate(pieces))


def box_text(env: ComponentEnv) -> str:
    """Return the observation space in a line."""
    low, high = env.observation_space.low, env.observation_space.high
    same = np.ptp(low) == 0.0 and np.ptp(high) == 0.0
    return (
        f"Box({low[0]:g}, {high[0]:g}, {env.observation_space.shape}, float32)"
        if same
        else (f"Box({env.observation_space.shape}, float32), limits in the table")
    )


def action_table(env: ComponentEnv) -> list[str]:
    """Return the lines of the table of an action."""
    lines = ["| index | quantity | value at 1 | min | max |", "|---|---|---|---|---|"]
    place = 0
    for name, scale in env.task.actions.items():
        variable, space = env.component.variables[parse_element(name).name], env.action_space
        last = place + (1 if parse_element(name).index else int(np.prod(variable.shape))) - 1
        which = str(place) if place == last else f"{place} to {last}"
        lines.append(f"| {which} | `{name}` | {scale:g} {variable.unit} | {space.low[place]:g} | {space.high[place]:g} |")
        place = last + 1
    assert place == env.action_space.shape[0]
    return lines


def observation_table(env: ComponentEnv) -> list[str]:
    """Return the lines of the table of an observation."""
    lines = ["| index | quantity | value at 1 | min | max |", "|---|---|---|---|---|"]
    for first, last, quantity, unit in observation_rows(env):
        place = str(first) if first == last else f"{first} to {last}"
        low, high = env.observation_space.low[first], env.observation_space.high[first]
        lines.append(f"| {place} | {quantity} | {unit} | {low:g} | {high:g} |")
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
    return f"{short}: {who}"


def threshold_source(short: str) -> str:
    """Return what a reward threshold is the return of."""
    return "theory" if isinstance(shown_play(short)[1], str) else PUSH


def write_picture(name: str, path: Path) -> None:
    """Play an episode and write it as a GIF."""
    from PIL import Image

    env, (seed, policy) = gymnasium.make(name, render_mode="rgb_array"), shown_play(name.rpartition("/")[2])
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
