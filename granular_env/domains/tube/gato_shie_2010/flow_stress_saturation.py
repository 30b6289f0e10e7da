"""Saturation of the flow law that the paper prints: its highest flow stress over the yield stress."""

from __future__ import annotations

from granular_env.components.materials.thermoviscoplastic import Thermoviscoplastic


def saturation() -> float:
    """Return the flow stress at the reference rate and temperature over the yield stress, at a plastic strain of 1."""
    law = Thermoviscoplastic()
    return (1.0 + 1.0 / law.reference_strain) ** law.hardening_exponent
