"""The MCAP container of a log: chunks and messages are written and read here, all small records by the `mcap` package."""

# What the header of an MCAP file says of whose it is.
PROFILE = "granular-env"
