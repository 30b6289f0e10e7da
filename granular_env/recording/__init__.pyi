from .branch import Branch
from .comparison import LogComparison, compare_logs
from .log import Log, open_log
from .recorder import Recorder, record
from .recovery import recover
from .verification import Verification, verify

__all__ = [
    "Branch",
    "Log",
    "LogComparison",
    "Recorder",
    "Verification",
    "compare_logs",
    "open_log",
    "record",
    "recover",
    "verify",
]
