"""What every test shares: repeatable hypothesis examples, no clock in any verdict, no display."""

import os

from hypothesis import HealthCheck, settings

os.environ.setdefault("MPLBACKEND", "Agg")
# Tests look at stderr; what is compiled in them says nothing there.
os.environ.setdefault("GRANULAR_ENV_QUIET", "1")

# Tests hold no timings, so neither does hypothesis. "repeatable" draws the same examples in every run;
# HYPOTHESIS_PROFILE=explore draws new ones.
settings.register_profile("repeatable", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("explore", deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))
