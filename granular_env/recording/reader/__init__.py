"""The content of a log as it was written: by record, and by variable and time."""
