"""A Gymnasium wrapper that writes every episode of a component into a log."""

from __future__ import annotations

from contextlib import ExitStack
from os import PathLike
from pathlib import Path
from typing import Any, NoReturn

import gymnasium

from ..components.errors import ParameterError
from .environment import ComponentEnv


class RecordEnv(gymnasium.Wrapper, gymnasium.utils.RecordConstructorArgs):
    """Record every episode of a `ComponentEnv` in one log, from the next reset to `close`.

    Each reset and each `restore` begins a new segment of the log. The log holds every input exactly, so it replays bit for bit,
    can be branched and looked at, like the log of a script. The observations and rewards are unchanged.

    A log holds the episodes of one component. If `randomise` draws a component for each episode, each has its own log:
    ``episode.mcap``, then ``episode-2.mcap`` and so on; `paths` names them.

    Args:
        env: a `ComponentEnv`, however deeply wrapped.
        path: file to write.
        **options: as for `granular_env.record`, e.g. ``every=1e-5``, ``variables=["velocity"]``.

    Attributes:
        paths: the logs written so far.

    Raises:
        ParameterError: an option is not valid.
        LogError: the file cannot be written.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], path: str | PathLike[str], **options: Any) -> None:
        gymnasium.utils.RecordConstructorArgs.__init__(self, path=path, **options)
        gymnasium.Wrapper.__init__(self, env)
        self._inner: ComponentEnv = env.unwrapped  # type: ignore[assignment]
        self._path, self._options, self._recording = Path(path), options, ExitStack()
        self.paths: list[Path] = []
        if not self._inner.draws_component:
            self._begin()

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start an episode; with a component of its own it begins a log of its own."""
        if not self._inner.draws_component:
            return super().reset(seed=seed, options=options)
        self._recording.close()
        begun = super().reset(seed=seed, options=options)
        self._begin()
        return begun

    def close(self) -> None:
        """Complete the log, then close the environment; a second call does nothing more."""
        try:
            self._recording.close()
        finally:
            super().close()

    def __reduce__(self) -> NoReturn:
        """Refuse copies: two recorders cannot write one log."""
        raise ParameterError(
            "it cannot be copied or pickled, its log is written once", hint="copy env.unwrapped instead", at="RecordEnv"
        )

    def _begin(self) -> None:
        from ..recording import record

        number = f"-{len(self.paths) + 1}" if self.paths else ""
        self.paths.append(self._path.with_name(f"{self._path.stem}{number}{self._path.suffix}"))
        self.recorder = self._recording.enter_context(record(self._inner.component, self.paths[-1], **self._options))
