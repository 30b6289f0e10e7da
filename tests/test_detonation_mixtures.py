"""New mixtures from chemical equilibrium: the shipped table is what Cantera gives, where it is installed."""

from __future__ import annotations

import sys

import pytest

from granular_env.components.detonation.chemical_equilibrium import equilibrium_gas
from granular_env.components.detonation.gases import MIXTURES, fit_gas
from granular_env.components.errors import MissingExtraError, ParameterError


def test_without_cantera_it_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cantera", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'granular-env\[mixtures\]'"):
        equilibrium_gas("C2H4:1, O2:3", 1e5, 295.0)


MEASURED = {"speed": 2374.0, "cj_pressure": 3.378e6, "pressure": 1e5, "density": 1.2644, "temperature": 295.0}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"density": 0.0}, r"^density: got 0, expected greater than 0"),
        ({"temperature": float("nan")}, r"^temperature: got nan"),
        (
            {"cj_pressure": 1e7},
            r"^cj_pressure: got 1e\+07 Pa, expected 1.80\d*e\+06 to 3.59\d*e\+06 Pa with",
        ),
        ({"speed": 300.0, "cj_pressure": 8e4}, r"^speed: got 300 m/s, expected more than the 363.\d* m/s of sound"),
    ],
)
def test_a_detonation_that_no_gas_has_is_refused_by_name(changes: dict[str, float], said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        fit_gas(**{**MEASURED, **changes})


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


@pytest.mark.extra
@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (
            ("C2H4:1, XY:3", 1e5, 295.0),
            r"^composition: got 'C2H4:1, XY:3': Species 'XY' not found; give moles",
        ),
        (("", 1e5, 295.0), r"^composition: got ''"),
        (
            ("N2:1", 1e5, 295.0),
            r"^composition: got 'N2:1', which would stay colder than 2000 K, expected a mixture",
        ),
        (("H2:2, O2:1", -1e5, 295.0), r"^pressure: got -100000, expected greater than 0"),
        (("H2:2, O2:1", 1e5, 295.0, "no.yaml"), r"^mechanism: got 'no.yaml'"),
    ],
)
def test_an_impossible_mixture_is_refused_by_name(arguments: tuple, said: str) -> None:
    pytest.importorskip("cantera")
    with pytest.raises(ParameterError, match=said):
        equilibrium_gas(*arguments)
