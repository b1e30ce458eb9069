"""The closed-form strike at the dissertation's operating point (Zhang 2020, chapter 2)."""

from __future__ import annotations

import math
from typing import Any

from bristle_sim.parameters import Bristle, Hub, Strike, Surface
from bristle_sim.theory.monofilament import MonofilamentImpact, monofilament_impact

OPERATING_POINT: dict[str, Any] = {
    "mass": Bristle().mass,
    "length": Bristle().length,
    "hub_radius": Hub().radius,
    "hub_speed": Hub().speed,
    "speed_ratio": Strike().speed_ratio,
    "impact_angle": math.radians(Strike().impact_angle_deg),
    "friction": Surface().friction,
    "restitution": Surface().restitution,
    "restitution_friction": None,
}
"""Arguments of ``monofilament_impact`` at the operating point, in SI units and rad."""


def operating_strike(**changes: Any) -> MonofilamentImpact:
    """Return the closed-form impact at the operating point.

    ``changes`` replace arguments of ``monofilament_impact``.
    """
    return monofilament_impact(**OPERATING_POINT | changes)
