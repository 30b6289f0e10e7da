"""The report of a run: a self-contained page with tables and figures."""
