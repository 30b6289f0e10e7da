"""Inputs: numbers, arrays and profiles of time that are held over a step."""

from __future__ import annotations

from .profiles import CompiledProfile

Held = float | CompiledProfile
