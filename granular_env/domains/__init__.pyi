from . import chain

__all__ = ["chain"]
