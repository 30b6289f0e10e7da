from .figures.plot import plot
from .figures.video import video
from .foxglove import save_foxglove_layout
from .reports.comparison_page import compare
from .reports.page import report
from .rerun.live import LiveViewer
from .rerun.viewer import save_rrd, screenshot, view

__all__ = [
    "LiveViewer",
    "compare",
    "plot",
    "report",
    "save_foxglove_layout",
    "save_rrd",
    "screenshot",
    "video",
    "view",
]
