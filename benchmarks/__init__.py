"""Speed, as ratios of two measurements in one process: `make bench`, `make bench-peers`."""
