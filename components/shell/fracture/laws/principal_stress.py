"""A point cracks if its largest principal Cauchy stress passes a multiple of the yield stress, or a given strength.

Source: Gato & Shie (2010), with the factor 3. Their material flows at up to 1.6 yield stresses; whether constraint in a notch
raises the stress to 3 depends on the mesh.
"""

from __future__ import annotations

from typing import ClassVar, Literal, NamedTuple

from pydantic import model_validator

from ....errors import ParameterError
from ....materials.tensors import equivalent_square, trace
from ....materials.thermoviscoplastic import FlowConstants
from ....support.parameter_fields import Magnitude, field
from .fracture_law import FractureLaw, decisive_value, may_exceed

_FACTOR = 3.0
# A Kirchhoff stress below this part of the limit cannot give a Cauchy stress above it: bodies in tension do not shrink more.
_SAFE = 0.8


class PrincipalStressConstants(NamedTuple):
    """The law has no constants except its limit."""


class PrincipalStress(FractureLaw):
    """The largest principal stress is tested."""

    unit: ClassVar[str] = "Pa"
    quantity: ClassVar[str] = "the largest principal stress"
    name: Literal["principal_stress"] = field("principal_stress", "limit of the largest principal stress", "1")
    factor: Magnitude = field(_FACTOR, "largest principal stress, in yield stresses, at which a point parts", "1")
    stress: Magnitude | None = field(None, "stress at which a point parts, instead of the factor", "Pa", absent="none")

    @model_validator(mode="after")
    def _validate_one_limit(self) -> PrincipalStress:
        # Laws are stored with all their fields, so the default factor next to a given strength is not a second limit.
        if self.stress is not None and self.factor != _FACTOR:
            raise ParameterError(
                f"got {self.factor:g} in addition to stress = {self.stress:g} Pa", expected="one of the two",
                hint="`stress` replaces `factor`: leave one out", at="factor",
            )  # fmt: skip
        return self

    @property
    def needs_flow(self) -> bool:
        """True if the limit is a multiple of the yield stress."""
        return self.stress is None

    def limit(self, law: FlowConstants) -> float:
        """Return the stress at which a point cracks [Pa]."""
        return self.factor * law.yield_stress if self.stress is None else self.stress

    def constants(self, law: FlowConstants) -> PrincipalStressConstants:
        """Return an empty tuple, whose class selects this law in kernels."""
        return PrincipalStressConstants()


@decisive_value.register(PrincipalStressConstants)
def _cauchy_stress(law, point):
    return point.principal / point.volume


@may_exceed.register(PrincipalStressConstants)
def _may_exceed(law, value, stress, plastic_strain):
    # The largest principal stress is at most the mean stress plus two thirds of the equivalent stress.
    left = 1.5 * (_SAFE * value - trace(stress) / 3.0)
    return not (left > 0.0 and equivalent_square(stress) < left * left)
