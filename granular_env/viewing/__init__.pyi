from .foxglove import save_foxglove_layout
from .live import LiveViewer
from .plot import plot
from .reporting import report
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
