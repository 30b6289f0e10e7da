"""The preview of a log, which stock viewers show: messages made of the frames of a run."""
