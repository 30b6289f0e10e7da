"""The MCAP container of a log: its chunks and messages are written and read here, its small records by the `mcap` package.

The package's own writer takes each message as one piece and copies it several times while it holds the interpreter's lock. Its
reader believes the sizes that a file claims, and takes longer for small messages. The figures are in docs/benchmarks.md (MCAP).
"""

# What the header of an MCAP file says of whose it is.
PROFILE = "granular-env"
