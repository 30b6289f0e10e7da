"""Benchmarks: ratios of two measurements in one process, run by `make bench` and `make bench-peers`."""
