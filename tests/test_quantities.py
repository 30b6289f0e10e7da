"""Quantities as text: exact conversion to SI, and refusal of other units."""

import math

import pytest

from granular_env.components.errors import ParameterError
from granular_env.documents.quantities import parse_quantity


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("1e-4", "s", 1e-4), ("100us", "s", 1e-4), ("100 \u00b5s", "s", 1e-4), ("1 ms", "s", 1e-3), ("2 min", "s", 120.0),
        ("-3mm", "m", -3e-3), ("210 GPa", "Pa", 210e9), ("5 N/mm^2", "Pa", 5e6), ("5g", "kg", 5e-3),
        ("2 cm\u00b2", "m^2", 2e-4),
        ("7.8 g/cm^3", "kg/m^3", 7800.0), ("5 mm/us", "m/s", 5e3), ("1 J/(g K)", "J/(kg K)", 1e3), ("10 kHz", "1/s", 1e4),
        ("30 deg", "rad", math.radians(30.0)), ("3 kN s/m^1.5", "N s/m^1.5", 3e3), ("0.5", "N/m^p", 0.5), ("2", "1", 2.0),
    ],
)  # fmt: skip
def test_the_nearest_float_in_si(text, unit, value):
    assert parse_quantity(text, unit) == value


@pytest.mark.parametrize(
    "text", ["5 mm", "x", "", "nan", "1_0 s", "3kks", "5s5s", "1e999", "1e9999 s", "5 S", "1 s^999999999", "5 s s"]
)
def test_a_wrong_unit_is_refused(text):
    with pytest.raises(ParameterError) as caught:
        parse_quantity(text, "s", at="duration")
    assert str(caught.value) == f"duration: got {text!r}, expected a time such as 100us or 1e-4"
