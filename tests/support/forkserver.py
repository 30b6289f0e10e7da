"""The server that forks processes for tests, with the large packages loaded and nothing compiled.

Importing these takes a second, which each process would spend anew.
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
