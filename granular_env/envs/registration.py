"""Registration of the environments with Gymnasium, without importing it.

Gymnasium reads no entry points, so ``import granular_env`` has to register. Importing Gymnasium for that would take some
150 ms, where this package takes 5: so where it is not imported yet, a finder waits until ``gymnasium.envs.registration`` has
been executed, registers, and goes away.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType
from typing import Any

_REGISTRY_MODULE = "gymnasium.envs.registration"


def register_all(registration: Any = None) -> None:
    """Register every environment of this package; those that are known already are left alone.

    Args:
        registration: the module ``gymnasium.envs.registration``; imported where it is not given.
    """
    if registration is None:
        from gymnasium.envs import registration
    from ..domains import environments

    for name, one in environments().items():
        if name not in registration.registry:
            # No time limit: the environment ends its episodes itself at its deadline, and its own `spec` tells when.
            registration.register(
                name,
                entry_point=one.entry_point,
                vector_entry_point=f"granular_env.envs.vector_entry_points:{one.entry_point.partition(':')[2]}",
                reward_threshold=one.reward_threshold,
            )


def register_when_imported() -> None:
    """Register now if Gymnasium is imported, otherwise as soon as somebody imports it."""
    if _REGISTRY_MODULE in sys.modules:
        register_all(sys.modules[_REGISTRY_MODULE])
    elif not any(isinstance(finder, _Waiting) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Waiting())  # type: ignore[arg-type]


class _Waiting:
    """Finds only Gymnasium's registry, in the ordinary way, once; and lets registration follow its execution.

    It has no base class, because importlib.abc takes as long to import as all the rest.
    """

    def find_spec(self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        if fullname != _REGISTRY_MODULE:
            return None
        sys.meta_path.remove(self)
        spec = PathFinder.find_spec(fullname, path)
        if spec is not None and spec.loader is not None:
            loader = spec.loader
            execute = loader.exec_module

            def execute_and_register(module: ModuleType) -> None:
                del loader.exec_module  # the class's own method is back
                execute(module)
                register_all(module)

            loader.exec_module = execute_and_register  # type: ignore[method-assign]
        return spec
