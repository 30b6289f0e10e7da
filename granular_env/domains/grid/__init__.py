"""What belongs to the grid alone: environments and their tasks."""
