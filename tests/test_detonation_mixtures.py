"""New mixtures from chemical equilibrium: the shipped table is what Cantera gives, where it is installed."""

from __future__ import annotations

import pytest

from granular_env.components.detonation.chemical_equilibrium import equilibrium_gas
from granular_env.components.detonation.gases import MIXTURES


@pytest.mark.extra
@pytest.mark.parametrize("row", MIXTURES["ethylene_oxygen"].rows[1::4], ids=lambda row: f"{row[0] / 1e3:g} kPa")
def test_the_table_of_ethylene_is_that_of_equilibrium(row: tuple[float, float, float]) -> None:
    """Speeds are flat at their minimum, so that the pressure there is known to five digits only."""
    pytest.importorskip("cantera")
    mixture = MIXTURES["ethylene_oxygen"]
    gas = equilibrium_gas("C2H4:1, O2:3", row[0], mixture.temperature)
    assert gas.gas_constant == pytest.approx(mixture.gas_constant, rel=1e-6)
    assert gas.gamma == pytest.approx(row[1], rel=1e-4)
    assert gas.heat_release == pytest.approx(row[2], rel=5e-4)
