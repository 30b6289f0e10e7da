"""Force-v0: `Protection-v0` under its older name."""

from __future__ import annotations

from typing import Any, Unpack

from ..chain_environment import ChainOptions
from .protection import ProtectionEnv, ProtectionTask

ForceTask = ProtectionTask


class ForceEnv(ProtectionEnv):  # noqa: D101
    __doc__ = f"""`Protection-v0` under its older name: pushed by a force, whose scale is called `force_scale` (500 N) here.

    {ProtectionEnv.__doc__}"""

    def __init__(
        self,
        grains: int = 64,
        radius: float = 3e-3,
        material: Any = "steel",
        *,
        step_size: float = 5e-7,
        impulse: float = 0.05,
        peak_scale: float = 1000.0,
        force_scale: float = 500.0,
        velocity_scale: float = 10.0,
        chain: dict[str, Any] | None = None,
        **options: Unpack[ChainOptions],
    ) -> None:
        super().__init__(
            grains, radius, material, action="force", action_scale=force_scale, step_size=step_size, impulse=impulse,
            peak_scale=peak_scale, velocity_scale=velocity_scale, chain=chain, **options,
        )  # fmt: skip
