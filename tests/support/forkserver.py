"""The fork server for tests, with the large packages imported and nothing compiled.

It saves each process the import time of about a second.
"""

from __future__ import annotations

import multiprocessing

LOADED = (
    "granular_env.cli", "granular_env.envs.environment", "granular_env.run_loop", "granular_env.recording",
    "granular_env.components.chain", "gymnasium", "matplotlib.pyplot", "scipy.optimize", "support.page_runner",
    "support.endless_recording",
)  # fmt: skip
forkserver = multiprocessing.get_context("forkserver")
forkserver.set_forkserver_preload(list(LOADED))
