"""Draws the picture of force chains and principal stresses in viewing.md: ``python docs/forces.py``."""

import tempfile
from pathlib import Path

import appearance

import granular_env as ge
from granular_env.viewing.figures import drawing
from granular_env.viewing.figures.keys import draw_keys, keys_height
from granular_env.viewing.figures.plane import draw_instant, load_plane
from granular_env.viewing.scene_builder import load_scene

IMAGE = Path(__file__).parent / "images" / "forces.png"
EXPERIMENT = "psakhie-2003/brazilian-disc"
# Output, instant [s] and title of each half: the crack opens after 112 us.
HALVES = (("stress", 1.1e-4, "Principal stresses"), ("link_force", 1.2e-4, "Forces of the links"))
SIDE = 3.7


@drawing.use_style
def draw_halves(path: str) -> None:
    """Draw a log at two instants, with stresses and with force chains."""
    with ge.open_log(path) as log:
        scene_data = load_scene(log)
        planes = [load_plane(log, scene_data, [instant], show=[name]) for name, instant, _ in HALVES]
    figure = drawing.new_figure(2.0 * SIDE, SIDE + 0.7)
    for part, plane, (_, instant, title) in zip(figure.subfigures(1, 2), planes, HALVES, strict=True):
        assert plane is not None
        above, keys = part.subfigures(2, 1, height_ratios=[SIDE, keys_height(plane, bars=False)])
        axes = above.subplots()
        draw_instant(axes, plane, 0)
        axes.set_title(f"{title}, {1e6 * instant:.4g} \u00b5s", fontsize=11)
        draw_keys(keys, axes, plane)
    appearance.save_figure(figure, IMAGE, 130, 128)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        result = ge.run(
            EXPERIMENT,
            log=Path(folder) / "disc.mcap",
            overrides={"record.variables": ["displacement", "linked", "stress", "link_force"]},
        )
        draw_halves(str(result.log))
