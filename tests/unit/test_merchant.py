"""Merchant's circle and the specific cutting energy: expected values from the formulas' definition."""

import math
import re
from collections.abc import Callable

import numpy as np
import pytest

from bristle_sim.theory.merchant import (
    ShearAngleError,
    oblique_angles,
    specific_cutting_energy,
)


class TestShearAngle:
    def test_the_shear_angle_of_least_work(self) -> None:
        """eta = (pi/2 - (beta - alpha))/2 (4.25): beta - alpha is arccot mu - gamma."""
        assert oblique_angles(2.0, 0.2).shear == pytest.approx(0.5 * (0.5 * math.pi - math.atan(0.5) + 0.2), rel=1e-14)

    @pytest.mark.parametrize("gamma", [0.5, 1.0])
    @pytest.mark.parametrize("lengthen", [float, lambda value: np.array([[0.01, value]])])
    def test_least_friction_of_an_oblique_cut(self, gamma: float, lengthen: Callable) -> None:
        """eta >= gamma is mu >= tan(gamma) (4.42)."""
        said = f"friction = 0.2: must be friction >= tan(impact_angle) = {math.tan(gamma):g}, "
        with pytest.raises(ShearAngleError, match=re.escape(said)):
            oblique_angles(0.2, lengthen(gamma))


REFUSALS = {
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
