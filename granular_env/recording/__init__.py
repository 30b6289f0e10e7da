"""Logs: record what a component does, open it, re-run it, branch off it, repair it."""

from .recorder.record import record
from .recorder.recorder import Recorder
from .replay.branch import Branch
from .replay.log import Log, open_log
from .replay.recovery import recover
from .verification.verification import Verification, verify

__all__ = ["Branch", "Log", "Recorder", "Verification", "open_log", "record", "recover", "verify"]
