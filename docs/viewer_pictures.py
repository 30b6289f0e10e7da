"""Takes the pictures of viewing.md: ``python docs/viewer_pictures.py``; needs the packages of ``make system-packages``."""

import io
import sys
import tempfile
import time
from datetime import UTC, datetime
from pathlib import Path

from PIL import Image
from rerun.experimental import ViewerClient

import granular_env as ge
from granular_env import viewing
from granular_env.recording.log import Log
from granular_env.viewing.rerun.process import RerunProcess

DOCS = Path(__file__).parent
IMAGES = DOCS / "images"
EXPERIMENT = "nesterenko-1983/3.4-piston"
# A sample that cracks, and an instant at which it does [s].
CRACKING, CRACKED_AT = "psakhie-2003/uniaxial-compression", 2.85e-4
# A tube with a notch, and an instant after the detonation has torn it open [s].
TORN, TORN_AT = "gato-shie-2010/notch-1-inch", 8.6e-4
# The logs in stock rerun: name of the picture, experiment, second of playback.
STOCK = (("disc", "psakhie-2003/brazilian-disc", 8.0), ("coupled", "psakhie-2003/lamb-symmetric", 4.0))
# Time in which rerun loads and draws a log [s]; it reports neither.
LOADING = 8.0

sys.path.insert(0, str(DOCS.parent / "tests"))


def shrink_picture(picture: bytes, width: int) -> Image.Image:
    """Return a PNG at this width, in 256 colours."""
    drawn = Image.open(io.BytesIO(picture)).convert("RGB")
    drawn = drawn.resize((width, round(drawn.height * width / drawn.width)), Image.Resampling.LANCZOS)
    return drawn.quantize(256, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)


def take_viewer(log: Log, folder: Path) -> None:
    """Take the desktop viewer, two thirds into the run."""
    picture = viewing.screenshot(log, folder / "viewer.png", size=(1500, 900))
    shrink_picture(picture.read_bytes(), 1200).save(IMAGES / "viewer.png", optimize=True)


def take_cracks(folder: Path) -> None:
    """Take the desktop viewer of a sample that cracks."""
    result = ge.run(CRACKING, log=folder / "cracks.mcap")
    assert result.log is not None
    with ge.open_log(result.log) as log:
        picture = viewing.screenshot(log, folder / "cracks.png", at=CRACKED_AT, size=(1300, 780))
    shrink_picture(picture.read_bytes(), 1200).save(IMAGES / "viewer-cracks.png", optimize=True)


def take_tube(folder: Path) -> None:
    """Take the desktop viewer of a tube that a detonation has torn open."""
    result = ge.run(TORN, log=folder / "tube.mcap", overrides={"record.every": 1e-5})
    assert result.log is not None
    with ge.open_log(result.log) as log:
        picture = viewing.screenshot(log, folder / "tube.png", at=TORN_AT, size=(1400, 900), exaggerate=1.0)
    shrink_picture(picture.read_bytes(), 1200).save(IMAGES / "viewer-tube.png", optimize=True)


def take_report(log: Log, folder: Path) -> None:
    """Take the top of a report, light and dark, side by side."""
    from support.browser import Browser

    page = viewing.report(log, folder / "report", variables=["velocity", "contact_force"])
    halves = []
    with Browser() as browser:
        for dark in (False, True):
            browser.open_page(page, width=760, height=1060, dark=dark)
            browser.take_screenshot(folder / "half.png", whole=False)
            halves.append(Image.open(io.BytesIO((folder / "half.png").read_bytes())).convert("RGB"))
    both = Image.new("RGB", (sum(half.width for half in halves), halves[0].height))
    for place, half in enumerate(halves):
        both.paste(half, (place * half.width, 0))
    buffer = io.BytesIO()
    both.save(buffer, "png")
    shrink_picture(buffer.getvalue(), 1200).save(IMAGES / "report.png", optimize=True)


def take_stock(name: str, experiment: str, second: float, folder: Path) -> None:
    """Take stock rerun, which opens the log without our layout."""
    result = ge.run(experiment, log=folder / f"{name}.mcap")
    with RerunProcess("--headless", "--window-size", "1400x840", str(result.log)) as viewer:
        viewer.wait_for_ports()
        client = ViewerClient.connect(viewer.url)
        time.sleep(LOADING)
        client.set_time("message_log_time", timestamp=datetime.fromtimestamp(second, UTC), play_state="paused")
        time.sleep(LOADING)
        picture = client.take_screenshot()
    shrink_picture(picture, 1200).save(IMAGES / f"stock-{name}.png", optimize=True)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        chosen = {"record.variables": ["displacement", "velocity", "contact_force"]}
        result = ge.run(EXPERIMENT, log=Path(name) / "piston.mcap", overrides=chosen)
        assert result.log is not None
        with ge.open_log(result.log) as opened:
            take_viewer(opened, Path(name))
            take_report(opened, Path(name))
        take_cracks(Path(name))
        take_tube(Path(name))
        for picture, experiment, second in STOCK:
            take_stock(picture, experiment, second, Path(name))
