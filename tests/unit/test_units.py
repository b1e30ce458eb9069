"""Engine units: dimensions of what is derived from length, mass and time, and a tool's own units."""

import math
from dataclasses import replace

import pytest

from bristle_sim.parameters import Belt, Bristle, Hub, Tool
from bristle_sim.scene.tool import Units, tool_units

DIMENSIONS = {
    "velocity": (1, 0, -1),
    "impulse": (1, 1, -1),
    "force": (1, 1, -2),
    "energy": (2, 1, -2),
    "angular_damping": (2, 1, -1),
}
"""Powers of metre, kilogram and second; N m s is kg m^2/s."""


@pytest.mark.parametrize("name", DIMENSIONS)
def test_dimensions(name: str) -> None:
    """Powers of 2, 4 and 8 are exact in floating point."""
    length, mass, time = DIMENSIONS[name]
    assert getattr(Units(2.0, 4.0, 8.0), name) == 2.0**length * 4.0**mass * 8.0**time


def test_a_tools_units_are_its_bristle_and_its_fastest_motion() -> None:
    """Small oscillations of a rod on its belt and the rotating root: 3 k/(m L^2) + (3/2) (r_h/L) w^2."""
    units = tool_units(Tool())
    assert (units.length, units.mass) == (0.027, 8.387e-5)
    squared = 3.0 * math.degrees(0.00041) / (8.387e-5 * 0.027**2) + 1.5 * 0.0275 / 0.027 * 261.8**2
    # Rounding.
    assert 1.0 / units.time == pytest.approx(math.sqrt(squared), rel=1e-14)


@pytest.mark.parametrize("size", [1e-4, 10.0])
def test_similar_tools_have_similar_units(size: float) -> None:
    """All lengths times s, masses times s^3, belt torque times s^5 at the same hub speed: the same motion, s times as large."""
    tool = Tool(bar=None, workpart=None)
    scaled = replace(
        tool,
        hub=Hub(radius=tool.hub.radius * size),
        belt=Belt(stiffness=tool.belt.stiffness * size**5),
        bristle=Bristle(length=0.027 * size, mass=8.387e-5 * size**3),
    )
    # Rounding.
    assert tool_units(scaled).time == pytest.approx(tool_units(tool).time, rel=1e-14)
    assert tool_units(scaled).force == pytest.approx(tool_units(tool).force * size**4, rel=1e-14)
