"""Visualisation of runs: rerun scenes of logs and live components, figures, and a report page.

`scene_builder.py` extracts the displayed data from a log or a running component. `rerun/` provides scenes and viewers
(`save_rrd`, `view`, `screenshot`, `LiveViewer`) and needs rerun; `figures/` (`plot`) and `reports/` (`report`) need matplotlib.
Both are imported on first use. `foxglove.py` writes a Foxglove layout for the preview of a log.
"""

from __future__ import annotations

import lazy_loader

# Load the names of __init__.pyi lazily: rerun and matplotlib are slow to import.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
