"""The preview in a log: messages made from the frames of a run, which viewers of MCAP files such as Foxglove display."""
