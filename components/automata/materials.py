"""The material of each automaton by number, and the laws of links within and between materials."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import ParameterError
from ..materials.elastic import Material, to_material
from .lattice import Layout
from .laws.criterion import WeakerLaw
from .laws.responses import ElasticResponses, LinkResponses, ResponseConstants
from .packing import Packing
from .parameters import AutomataParameters

IntArray = npt.NDArray[np.int64]


def chosen_materials(parameters: AutomataParameters) -> list[Material]:
    """Return the materials of the specimen, in the order of their numbers."""
    return [to_material(one) for one in parameters.materials]


def material_numbers(parameters: AutomataParameters, packing: Packing) -> IntArray:
    """Return the material number of each automaton, shape (n,)."""
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


def make_response(parameters: AutomataParameters, law_numbers: IntArray) -> LinkResponses | ElasticResponses:
    """Return the responses of links for kernels; `law_numbers` as in `link_law_numbers`. Links of two materials are elastic."""
    p, count = parameters, len(parameters.materials)
    if not p.can_yield:
        return ElasticResponses()
    rows = [one.constants() for one in p.responses] + [ResponseConstants(np.inf, 0.0, 0.0)]
    return LinkResponses(
        np.array(rows), np.where(law_numbers[:, 0] == law_numbers[:, 1], np.minimum(law_numbers[:, 0], count), count)
    )


def make_criterion(parameters: AutomataParameters, law_numbers: IntArray) -> Any:
    """Return the breaking criterion of links for kernels; `law_numbers` are the result of `link_law_numbers`."""
    p, leading = parameters, parameters.leading_criterion
    if not p.has_several_materials or not p.breakable:
        return leading.constants()
    criteria = p.criteria + [one.criterion for one in p.interfaces]
    return WeakerLaw(tuple(one.constants() if one.causes else leading.unbreakable_constants() for one in criteria), law_numbers)


def link_law_numbers(parameters: AutomataParameters, material_numbers: IntArray, packing: Packing, layout: Layout) -> IntArray:
    """Return for each link the numbers of its two laws in a common list, shape (directions x m, 2).

    In this list the laws of the materials come first, then those of the interfaces.
    """
    count, half = len(parameters.materials), packing.lattice.slots // 2
    one, other = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    table = np.stack([one, other], axis=-1).astype(np.int64)
    for place, interface in enumerate(parameters.interfaces):
        first, second = interface.materials
        table[first, second] = table[second, first] = count + place
    rows = np.zeros((half, layout.size, 2), np.int64)
    for q in range(half):
        there = packing.neighbours[:, q]
        laws = table[material_numbers, material_numbers[there]]
        rows[q, layout.place], rows[q, layout.place[there] - layout.offset[q]] = laws, laws
    return rows.reshape(-1, 2)
