"""Merchant's circle and the specific cutting energy: expected values from the formulas' definition."""

import math
import re
from collections.abc import Callable

import numpy as np
import pytest

from bristle_sim.theory.merchant import (
    ShearAngleError,
    oblique_angles,
    shear_angle,
    specific_cutting_energy,
)


class TestShearAngle:
    def test_the_constant_of_the_shear_angle_reaches_the_circle(self) -> None:
        """eta = (C - (beta - alpha))/2 (4.45) with C = 0.9: beta - alpha is arccot mu - gamma."""
        assert shear_angle(0.1, 0.9) == pytest.approx(0.4, rel=1e-15)
        oblique = oblique_angles(2.0, 0.2, constant=0.9)
        assert oblique.shear == pytest.approx(0.5 * (0.9 - math.atan(0.5) + 0.2), rel=1e-14)

    @pytest.mark.parametrize(("gamma", "least"), [(0.5, 1.0 / math.tan(0.4)), (0.9, math.inf), (1.0, math.inf)])
    @pytest.mark.parametrize("lengthen", [float, lambda value: np.array([[0.01, value]])])
    def test_least_friction_of_an_oblique_cut(self, gamma: float, least: float, lengthen: Callable) -> None:
        """eta >= gamma with C = 0.9 is arccot mu <= C - gamma: mu >= cot(C - gamma), never for gamma >= C."""
        with pytest.raises(
            ShearAngleError, match=re.escape(f"friction = 2: must be friction >= cot(C - impact_angle) = {least:g}, ")
        ):
            oblique_angles(2.0, lengthen(gamma), constant=0.9)


REFUSALS = {
    "constant = 0": (lambda: shear_angle(-0.1, 0.0), "0 < constant <= 1.5708", "(in rad)"),
    "resultant_angle = 0.5": (lambda: shear_angle(0.5, 0.5), "beta - alpha < C", "(in rad)"),
    "friction = 0": (lambda: oblique_angles(0.0, 0.1), "above 0", "(dimensionless)"),
    "impact_angle = 1.5708": (
        lambda: oblique_angles(0.5, 0.5 * math.pi),
        "below pi/2",
        "(in rad)",
    ),
    "shear_yield_stress = -1": (
        lambda: specific_cutting_energy(0.5, 0.4, -1.0),
        "1e-30 <= shear_yield_stress",
        "(in Pa)",
    ),
}


@pytest.mark.parametrize("start", REFUSALS)
def test_refusals_name_key_value_range_and_unit(start: str) -> None:
    """Values are compared as numbers: a message may write them with more or fewer digits."""
    call, allowed, unit = REFUSALS[start]
    name, _, value = start.partition(" = ")
    with pytest.raises(ValueError, match=rf"^{name} = \S+: ") as refusal:
        call()
    shown = re.match(rf"{name} = (\S+): ", str(refusal.value))[1]
    assert float(shown) == pytest.approx(float(value), rel=1e-5, nan_ok=True)
    assert allowed in str(refusal.value)
    assert str(refusal.value).endswith(unit)
