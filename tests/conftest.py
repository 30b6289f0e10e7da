"""Common setup of all tests: repeatable hypothesis examples, no timing in verdicts, no display."""

import gc
import os
import signal
from collections.abc import Iterator
from typing import Any

import numba  # noqa: F401  (`new` and `describe` interpret kernels in a process that has not imported numba)
import pytest
from hypothesis import HealthCheck, settings

os.environ.setdefault("MPLBACKEND", "Agg")
# Tests check stderr, so compilation must print nothing there.
os.environ.setdefault("GRANULAR_ENV_QUIET", "1")

# Tests started in the background may ignore SIGINT and SIGHUP; the processes that they start must not inherit this.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)

# Tests contain no timings, so hypothesis has no deadline. "repeatable" draws the same examples in every run;
# HYPOTHESIS_PROFILE=explore draws new examples.
settings.register_profile("repeatable", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("explore", deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Disable garbage collection while collecting tests: the thousands of tests persist, and it costs 4 s per process."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Return the scheduler that assigns whole files to workers."""
    if config.getoption("dist") != "loadfile":
        return None
    from support.scheduling import KernelScheduler

    return KernelScheduler(config, log)
