"""Numbers mean the same whatever NumPy is set to print: colour-science sets it when imported."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from shaderlab.analysis.interpreter import Bands
from shaderlab.analysis.interpreter.arithmetic import Numbers
from shaderlab.bands import Band
from shaderlab.bands.rounding import shortest
from shaderlab.functions.properties import format_number, weight


def bounds(band: Band) -> tuple[float, float]:
    return float(band.lo.item()), float(band.hi.item())


@pytest.mark.parametrize("value", [1.0 / 2.2, 0.1, 16777215.0, 1.17e-38, -1234567.9])
@pytest.mark.parametrize(
    "figure",
    [
        shortest,
        format_number,
        weight,
        lambda value: bounds(Bands().literal(value)),
        lambda value: bounds(Band.literal(value)),
        lambda value: Numbers(np.float64).literal(value).item(),
    ],
)
def test_a_number_is_the_same(figure: Any, value: float) -> None:
    expected = figure(np.float32(value))
    with np.printoptions(legacy="1.13"):
        assert str(np.float32(1.0 / 2.2)) == "0.454545"  # what the setting does
        assert figure(np.float32(value)) == expected
