"""The grid: its environments and their tasks."""
