"""The program that a log is: opened, run again, branched off, continued, recovered."""
