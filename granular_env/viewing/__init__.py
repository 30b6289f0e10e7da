"""Looking at runs: rerun scenes of logs and of live components, figures, and a report page.

`save_rrd`, `view` and `screenshot` need rerun, `report`, `plot` and `figures` need matplotlib; both are imported only when
used.
"""

from __future__ import annotations

import lazy_loader

# The names of __init__.pyi: rerun and matplotlib take a while to import.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
