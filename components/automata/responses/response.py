"""The base of responses: where one leaves the elastic line, and how it goes on."""

from __future__ import annotations

from typing import ClassVar

from ...support.tagged_union import Named


class Response(Named):
    """A law by which the forces of a pair follow its strains."""

    elastic: ClassVar[bool] = False
    """True where it has no history."""

    def constants(self) -> tuple[float, float, float]:
        """Return the onset [Pa], the slope over the inelastic strain [Pa], and the part that degrades."""
        return 0.0, 0.0, 0.0
