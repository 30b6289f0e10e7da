"""Looking at runs: rerun scenes of logs and of live components, figures, and a report page.

`scene_builder.py` takes from a log, or from a component that is stepped, what all of them show. `rerun/` has scenes and viewers
(`save_rrd`, `view`, `screenshot`, `LiveViewer`) and needs rerun; `figures/` (`plot`) and `reports/` (`report`) need matplotlib.
Both are imported only when used. `foxglove.py` lays out the preview of a log in Foxglove.
"""

from __future__ import annotations

import lazy_loader

# The names of __init__.pyi: rerun and matplotlib take a while to import.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
