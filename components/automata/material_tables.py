"""The material of each automaton by number, and tables of the laws of links within and between materials."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..errors import ParameterError
from ..materials.elastic import Material, material
from ..support.float_arrays import FloatArray
from .packing import Packing
from .parameters import AutomataParameters

IntArray = npt.NDArray[np.int64]


def chosen_materials(parameters: AutomataParameters) -> list[Material]:
    """Return the materials by their number."""
    return [material(one) for one in parameters.materials]


def material_numbers(parameters: AutomataParameters, packing: Packing) -> IntArray:
    """Return the number of the material of each automaton, shape (n,)."""
    count, given = len(packing.reference), parameters.automaton_material
    if given is not None:
        if len(given) != count:
            raise ParameterError(
                f"got {len(given)} numbers", expected=f"{count}, one for each automaton", at="automaton_material"
            )
        return np.array(given, dtype=np.int64)
    numbers = np.zeros(count, dtype=np.int64)
    for place, region in enumerate(parameters.regions):
        inside = region.area.contains(packing.reference)
        if not inside.any():
            raise ParameterError(
                "contains no centre of an automaton", hint="make it larger, or leave it out", at=("regions", place)
            )
        numbers[inside] = region.material
    return numbers


def lame_constants(solid: Material) -> tuple[float, float]:
    """Return G and lambda of a material [Pa]."""
    shear = solid.young / (2.0 * (1.0 + solid.poisson))
    return shear, 2.0 * shear * solid.poisson / (1.0 - 2.0 * solid.poisson)


def law_tables(parameters: AutomataParameters) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return the constants of responses and of strengths, and the two laws of links between any two materials.

    Shapes (laws, 3), (laws, 3), (materials, materials, 2). Laws are those of the materials, then those of the interfaces.
    """
    p = parameters
    count, leading = len(p.materials), p.leading_criterion
    elastic = (np.inf, 0.0, 0.0)
    responses = [elastic if one.elastic else one.constants() for one in p.responses] + [elastic] * len(p.interfaces)
    criteria = p.criteria + [one.criterion for one in p.interfaces]
    strengths = [one.constants() if one.causes else leading.unbreakable_constants() for one in criteria]
    one, other = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    rows = np.stack([one, other], axis=-1)
    for place, interface in enumerate(p.interfaces):
        first, second = interface.materials
        rows[first, second] = rows[second, first] = count + place
    return np.array(responses), np.array(strengths), rows.astype(np.int64)


def law_rows(rows: IntArray, numbers: IntArray, packing: Packing) -> IntArray:
    """Return the two laws of each link, shape (n, slots / 2, 2); arguments as `law_tables` and `material_numbers` give them."""
    half = packing.lattice.slots // 2
    return np.ascontiguousarray(rows[numbers[:, np.newaxis], numbers[packing.neighbours[:, :half]]])
