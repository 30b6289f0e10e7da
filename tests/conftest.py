"""What every test shares: repeatable hypothesis examples, no clock in any verdict, no display."""

import gc
import os
import signal
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

os.environ.setdefault("MPLBACKEND", "Agg")
# Tests look at stderr; what is compiled in them says nothing there.
os.environ.setdefault("GRANULAR_ENV_QUIET", "1")

# Whoever started the tests in the background may have them ignore Ctrl-C and a closed terminal; what they start must not.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)

# Tests hold no timings, so neither does hypothesis. "repeatable" draws the same examples in every run;
# HYPOTHESIS_PROFILE=explore draws new ones.
settings.register_profile("repeatable", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("explore", deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Search no garbage among the thousands of tests that are collected: they stay, and searching takes 4 s of each process."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Choose who runs which file, where files are not cut."""
    if config.getoption("dist") != "loadfile":
        return None
    from support.scheduling import ByKernels

    return ByKernels(config, log)
