"""The recorder of a log: what it takes from a component, when, and how that gets into a file."""
