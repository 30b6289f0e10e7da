from .figures.plot import plot
from .figures.video import video
from .foxglove import save_foxglove_layout
from .reports.page import report
from .rerun.live import LiveViewer
from .rerun.viewer import save_rrd, screenshot, view

__all__ = [
    "LiveViewer",
    "plot",
    "report",
    "save_foxglove_layout",
    "save_rrd",
    "screenshot",
    "video",
    "view",
]
