from .foxglove import save_foxglove_layout
from .live import LiveViewer
from .report_page import report
from .series_plot import plot
from .viewer import save_rrd, screenshot, view

__all__ = [
    "LiveViewer",
    "plot",
    "report",
    "save_foxglove_layout",
    "save_rrd",
    "screenshot",
    "view",
]
