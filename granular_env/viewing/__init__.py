"""Looking at runs: rerun scenes of logs and of live components, figures, and a report page.

`save_rrd`, `view` and `screenshot` need rerun, `report`, `plot` and `figures` need matplotlib; both are imported only when
used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .foxglove import save_foxglove_layout
    from .live import LiveViewer
    from .plot import plot
    from .reporting import report
    from .viewer import save_rrd, screenshot, view

__all__ = ["LiveViewer", "plot", "report", "save_foxglove_layout", "save_rrd", "screenshot", "view"]

_HOMES = {
    "LiveViewer": ".live",
    "plot": ".plot",
    "report": ".reporting",
    "save_foxglove_layout": ".foxglove",
    "save_rrd": ".viewer",
    "screenshot": ".viewer",
    "view": ".viewer",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = globals()[name] = getattr(import_module(_HOMES[name], __name__), name)
    return found


def __dir__() -> list[str]:
    return sorted(__all__)
