"""The MCAP container of a log: its chunks and messages are written and read here, its small records by the `mcap` package.

The package's own writer takes each message as one piece and copies it several times while it holds the interpreter's lock: a
recorded run of 100,000 particles would spend 30 % more processor time than an unrecorded one, and spends 24 %. Its reader
believes the sizes that a file claims, and takes 1.4 to 1.7 times as long for small messages. Figures: docs/benchmarks.md.
"""

# What the header of an MCAP file says of whose it is.
PROFILE = "granular-env"
