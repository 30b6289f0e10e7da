"""The grid: environments and tasks."""
