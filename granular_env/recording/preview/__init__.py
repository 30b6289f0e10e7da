"""The preview of a log for stock viewers: messages made from the frames of a run."""
