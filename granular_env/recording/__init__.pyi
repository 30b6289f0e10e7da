from .branch import Branch
from .log import Log, open_log
from .recorder import Recorder, record
from .recovery import recover
from .verification import Verification, verify

__all__ = ["Branch", "Log", "Recorder", "Verification", "open_log", "record", "recover", "verify"]
