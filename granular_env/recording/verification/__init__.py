"""The verification of a log: it is run again, and all that it holds is compared, bit for bit."""
