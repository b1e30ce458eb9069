"""Ranges of the theory's arguments: one table by the argument's name, and the decorator that looks them up.

A bound comes from physics (a length is positive, a coefficient of restitution is at most 1, a retraction is at most a turn) or
from rounding: between the bounds no product of powers in a formula overflows or loses its digits, so that no result is infinite
or NaN. A function whose formula needs less refuses more, after these checks.
"""

from __future__ import annotations

import math

from bristle_sim.quantity import Range
from bristle_sim.theory.checks import ranges

RIGHT, TURN = 0.5 * math.pi, 2.0 * math.pi

_ROWS = (
    # The tool and the wire.
    ("mass", "kg", 1e-30, 1e6, "rounding: m v^2 and v/m of the extremes are floats"),
    ("length", "m", 1e-9, 1e3, "rounding: m L^2 of the extremes is a float"),
    ("hub_radius", "m", 0.0, 1e3, "physics; rounding: r_h/L keeps L's digits up to 1e12"),
    ("hub_speed", "rad/s", 0.0, 1e6, "physics: the hub turns forward; rounding: r_h omega^2"),
    ("speed_ratio", "1", -1e9, 1e9, "rounding: R + r_h/L keeps either's digits"),
    ("inertia", "kg m^2", 1e-60, 1e100, "physics: positive; rounding: k/I"),
    ("stiffness", "N m/rad", 0.0, 1e100, "physics: no negative spring; rounding: k/I"),
    ("centrifugal", "N m/rad", 0.0, 1e100, "physics: m r_h omega^2 L/2 is not negative; rounding as a stiffness"),
    ("natural_rate", "rad/s", 1e-150, 1e150, "physics: positive; rounding: its square is a float"),
    ("damping_ratio", "1", 0.0, 1e9, "physics: no damper drives; rounding: sqrt(zeta^2 - 1)"),
    ("diameter", "m", 1e-30, 1e2, "physics: positive; rounding: d^4"),
    ("modulus", "Pa", 1e-30, 1e15, "physics: positive, at most a thousand times diamond's"),
    ("root_stiffness", "N m/rad", 0.0, 1e9, "physics: no negative spring; rounding: beyond it a clamp"),
    # Where the bar stands.
    ("retraction", "rad", -TURN, TURN, "physics: a turn either way"),
    ("penetration", "m", -2e3, 2e3, "physics: within the reach of hub and bristle"),
    ("bar_reach", "m", 0.0, 1e4, "physics: a radius; rounding: S keeps the bristle's digits"),
    ("bar_horizontal", "m", -1e4, 1e4, "rounding: S keeps the bristle's digits"),
    ("bar_vertical", "m", -1e4, 1e4, "rounding: S keeps the bristle's digits"),
    ("tip_radius", "m", 0.0, 1e4, "physics: a radius; rounding: S keeps the bristle's digits"),
    ("distance", "m", 0.0, 1e5, "physics: a distance; rounding: the sum of the two above"),
    ("direction", "rad", -1e6, 1e6, "rounding: a larger angle has lost its digits"),
    ("speed_share", "1", 0.0, 1.0, "physics: damping slows"),
    # Impacts.
    ("impact_angle", "rad", 0.0, RIGHT, "physics: from along the surface to straight down"),
    ("friction", "1", 0.0, 1e9, "physics: Coulomb's; rounding: 1 + mu^2"),
    ("restitution_friction", "1", 0.0, 1e9, "physics: Coulomb's; rounding: 1 + mu^2"),
    ("restitution", "1", 0.0, 1.0, "physics: no energy is gained"),
    ("tip_speed", "m/s", -1e12, 1e12, "rounding: m v^2"),
    ("impulse", "N s", -1e30, 1e30, "rounding: p^2/m"),
    ("initial_rate", "rad/s", -1e15, 1e15, "rounding: its square is a float"),
    ("rod_mass", "kg", 1e-30, 1e6, "rounding as a bristle's mass"),
    ("rod_length", "m", 1e-9, 1e3, "rounding as a bristle's length"),
    ("mass_ratio", "1", 1e-30, 1e12, "physics: positive; rounding: n + 3 keeps either's digits"),
    ("angle_1", "rad", -RIGHT, RIGHT, "physics: the rods reach the surface from above"),
    ("angle_2", "rad", -RIGHT, RIGHT, "physics: the rods reach the surface from above"),
    ("rate", "rad/s", -1e9, 1e9, "rounding: L^2 rate^2 keeps its digits"),
    ("rate_1", "rad/s", -1e9, 1e9, "rounding: L^2 rate^2 keeps its digits"),
    ("rate_2", "rad/s", -1e9, 1e9, "rounding: L^2 rate^2 keeps its digits"),
    # Force histories.
    ("time", "s", -1e30, 1e30, "rounding: any clock; its square is a float"),
    ("compression_time", "s", 1e-30, 1e3, "physics: positive; rounding: F^(n) t^n"),
    ("duration", "s", 1e-30, 1e30, "physics: positive; rounding: its square is a float"),
    ("peak_force", "N", 1e-30, 1e30, "physics: positive; rounding: squares of residuals"),
    ("noise", "N", 1e-30, 1e30, "physics: positive; rounding: squares of residuals"),
    ("start", "s", -1e30, 1e30, "rounding: any clock; its square is a float"),
    # Cutting.
    ("decay", "1/s", 0.0, 1e15, "physics: the motion slows; rounding: decay times compression_time"),
    ("resultant_angle", "rad", -math.pi, math.pi, "physics: half a turn either way"),
    ("rake_offset", "rad", -math.pi, math.pi, "physics: half a turn either way"),
    ("depth", "m", 0.0, 1e6, "physics: not above the surface; rounding: a force over a width"),
    ("shear_yield_stress", "Pa", 1e-30, 1e30, "physics: positive; rounding: a force over a stress and a width"),
    ("force", "N", -1e30, 1e30, "rounding: a force over a stress and a width"),
    ("cutting_force", "N", 0.0, 1e30, "physics: the chip resists; rounding: a force over a stress and a width"),
    ("path", "m", 0.0, 1e30, "physics: the tip dives; rounding: its square is a float"),
    ("energy", "J", 0.0, 1e30, "physics: the work takes energy; rounding: a volume"),
    ("specific_energy", "J/m^3", 1e-60, 1e60, "physics: positive; rounding: a volume"),
    ("speed", "m/s", 1e-60, 1e15, "physics: the tip moves; rounding: m v^2"),
    ("effective_mass", "kg", 1e-60, 1e30, "physics: positive; rounding: m v^2"),
    ("normal_force", "N", -1e30, 1e30, "rounding: a work"),
    ("tangential_force", "N", -1e30, 1e30, "rounding: a work"),
    ("normal_velocity", "m/s", -1e30, 1e30, "rounding: a work"),
    ("tangential_velocity", "m/s", -1e30, 1e30, "rounding: a work"),
)

_CONSTANT = Range("constant", "rad", 0.0, RIGHT, False, "physics: 0 < C <= pi/2, which is least work")

RANGES: dict[str, Range] = {
    "constant": _CONSTANT,
    **{key: Range(key, unit, lowest, highest, True, reason) for key, unit, lowest, highest, reason in _ROWS},
}
"""By the argument's name; the source of each is the reason of its bounds."""

checked_arguments = ranges(*RANGES.values())
"""Decorate a function to check the arguments whose names are in the table, and to get them as floats or arrays of floats."""


def checked_numbers(**values: float) -> list[float]:
    """Return single numbers as plain floats, each in the range of its name, or raise ValueError."""
    return [RANGES[name].check(value) for name, value in values.items()]
