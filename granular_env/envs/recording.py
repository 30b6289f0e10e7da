"""An environment that writes a log of what its component does."""

from __future__ import annotations

from contextlib import AbstractContextManager
from os import PathLike
from typing import Any

import gymnasium

from ..components.errors import ParameterError, shortened
from .environment import ComponentEnv


class RecordEnv(gymnasium.Wrapper, gymnasium.utils.RecordConstructorArgs):
    """Record every episode of a `ComponentEnv` in one log, from the next reset to `close`.

    Each reset and each `restore` begins a new segment of the log. The log holds every input exactly, so it replays bit for bit,
    can be branched and looked at, like the log of a script. The observations and rewards are unchanged.

    Args:
        env: a `ComponentEnv`, however deeply wrapped.
        path: file to write.
        **options: as for `granular_env.record`, e.g. ``every=1e-5``, ``variables=["velocity"]``.

    Raises:
        ParameterError: there is no component inside `env`, or an option is not valid.
        LogError: the file cannot be written.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], path: str | PathLike[str], **options: Any) -> None:
        if not isinstance(env.unwrapped, ComponentEnv):
            raise ParameterError(f"env: got {shortened(env)}, expected a ComponentEnv; only a component can be recorded")
        gymnasium.utils.RecordConstructorArgs.__init__(self, path=path, **options)
        gymnasium.Wrapper.__init__(self, env)
        from ..recording import record

        self._recording: AbstractContextManager[Any] | None = record(env.unwrapped.component, path, **options)
        self.recorder = self._recording.__enter__()

    def close(self) -> None:
        """Complete the log, then close the environment; a second call does nothing more."""
        recording, self._recording = self._recording, None
        try:
            if recording is not None:
                recording.__exit__(None, None, None)
        finally:
            super().close()
