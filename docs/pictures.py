"""Draws the pictures of README.md and of these pages: ``python docs/pictures.py``."""

import tempfile
from pathlib import Path

import granular_env as ge
from granular_env.viewing import figures, footage

IMAGES = Path(__file__).parent / "images"


def piston() -> None:
    """The x-t diagram of the shipped piston experiment, with the profile at its end (the paper's figure 6)."""
    with tempfile.TemporaryDirectory() as folder:
        result = ge.run("nesterenko-1983/3.4-piston", log=Path(folder) / "piston.mcap")
        motion = footage.from_log(ge.open_log(result.log)).motion
        picture = figures.headline(motion, "A piston at 5 m/s drives a shock front into 200 steel grains")
        (IMAGES / "piston.png").write_bytes(figures.png(picture))


if __name__ == "__main__":
    piston()
