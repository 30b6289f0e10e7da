"""Tasks, one a file: what is rewarded, and the environment that is registered for it."""
