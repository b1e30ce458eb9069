"""Unit, meaning and range of the scenarios' keys, where a declaration does not give its own."""

from __future__ import annotations

import math
from typing import NamedTuple


class Key(NamedTuple):
    """What a key stands for: its unit, its meaning in a few words, and the range it must be in.

    The range includes its upper end, and its lower one where ``lowest_allowed``.
    """

    unit: str = ""
    meaning: str = ""
    highest: float = math.inf
    lowest: float = 0.0
    lowest_allowed: bool = True


KEYS: dict[str, Key] = {
    "hub_speed": Key("rad/s", "speed of the hub's rotation", 1e6),
    "hub_radius": Key("m", "distance of the bristle's root from the hub's centre", 1e3),
    "belt_stiffness": Key("N m/rad", "torsional stiffness of the belt at the bristle's root", 1e9),
    "belt_damping_ratio": Key("1", "damping ratio of the bristle on its belt; 1 is critical", 1e3),
    "bristle_length": Key("m", "length of the wire from root to tip, along its centre line", 1e3, 1e-9),
    "bristle_mass": Key("kg", "mass of one bristle", 1e6, 1e-30),
    "wire_diameter": Key("m", "thickness of the wire, half of which touches the bar", 1e2),
    "knee_position": Key("1", "distance of the knee from the root, as a fraction of the length", 0.99, 0.01),
    "knee_angle_deg": Key("deg", "bend at the knee; positive bends the tip forward, in the hub's sense", 90.0, -90.0),
    "wire_links": Key("1", "number of equal rigid links of the wire; 1 is a rigid bristle", 64, 1),
    "wire_modulus": Key(
        "Pa", "Young's modulus of the wire, which stiffens the hinges between its links", 1e15, 0.0, False
    ),
    "wire_damping_ratio": Key("1", "damping ratio of the wire's first bending mode", 1e3),
    "gravity": Key("m/s^2", "acceleration of gravity, towards the workpart", 1e6),
    "bar_radius": Key("m", "radius of the accelerator bar", 1e3, 0.0, False),
    "bar_horizontal": Key(
        "m", "distance of the bar's centre from the hub's, along the workpart, on the incoming side", 1e3
    ),
    "bar_vertical": Key("m", "distance of the bar's centre below the hub's", 1e3, -1e3),
    "bar_friction": Key("1", "coefficient of friction between wire and bar", 1e6),
    "bar_restitution": Key("1", "energetic coefficient of restitution between wire and bar", 1.0),
    "penetration": Key("m", "depth by which the workpart cuts into the circle of undeflected tips, Delta", 1e3, -1e3),
    "friction": Key("1", "coefficient of friction between tip and workpart during compression, mu_1", 1e9),
    "restitution_friction": Key("1", "coefficient of friction during restitution, mu_2; none: equal to friction", 1e9),
    "restitution": Key("1", "energetic coefficient of restitution between tip and workpart, e*", 1.0),
    "contact": Key("word", "law of impact: by energy, resolved in time on a spring, or the engine's own"),
    "contact_duration": Key(
        "s",
        "half periods of a frictionless spring on K at the touch; none: short enough for the rigid-body limit",
        1.0,
        1e-18,
    ),
    "speed_ratio": Key("1", "bristle's rate over the hub's speed when it strikes, R", 1e6),
    "impact_angle_deg": Key("deg", "angle between the radial bristle and the workpart's normal, gamma", 90.0, 1e-30),
    "retraction_deg": Key("deg", "angle by which the released bristle lags the radial direction", 89.9, 1e-6),
    "rod_mass": Key("kg", "mass of the rod", 1e6, 1e-30),
    "rod_length": Key("m", "length of the rod", 1e3, 1e-9),
    "rate": Key("rad/s", "rate of the rod before the impact; negative approaches", 1e9, -1e9),
    "mass_ratio": Key("1", "mass of the first rod over the second's, n", 1e12, 1e-9),
    "angle_1_deg": Key("deg", "angle of the first rod to the surface's normal", 90.0, -90.0),
    "angle_2_deg": Key("deg", "angle of the second rod to the surface's normal", 90.0, -90.0),
    "rate_1": Key("rad/s", "rate of the first rod before the impact; negative approaches", 1e9, -1e9),
    "rate_2": Key("rad/s", "rate of the second rod before the impact; negative approaches", 1e9, -1e9),
    "bristles": Key("1", "number of bristles in the row; the quantities at a pitch are those of the last one", 12, 2),
    "pitch_deg": Key("deg", "angle about the hub from one bristle to the next", 180.0, 0.0, False),
    "neighbour_friction": Key("1", "coefficient of friction between two wires", 1e6),
    "neighbour_restitution": Key("1", "energetic coefficient of restitution between two wires", 1.0),
    "search": Key("word", "whether the least pitches are also searched on simulated rows"),
    "reference": Key("word", "whether the independent solution is computed too and judges the result"),
    "force_csv": Key("file", "measured force history: columns of time and force as an oscilloscope exports them"),
    "time_column": Key("column", "column of the time in the file"),
    "force_column": Key("column", "column of the force in the file"),
    "force_per_volt": Key("N/V", "calibration of a force that was recorded as a voltage", 1e12, -1e12),
    "compression_time": Key("s", "time from first touch to deepest penetration, t_c", 1.0, 1e-9),
    "shear_yield_stress": Key("Pa", "shear yield stress of the workpart's steel", 1e15, 1.0),
    "plies": Key("1", "number of layers into which the cut is divided", 100_000, 1),
    "accuracy": Key("1", "relative accuracy requested of the simulation", 0.1, 1e-11),
    "step": Key("s", "fixed engine step; none: chosen for the accuracy", 1.0, 1e-12),
    "hub_turn": Key("rad", "turn of the hub after which the pass ends", 1e6, 1e-12),
    "theme": Key("word", "kind of hard case that is tried"),
    "effort": Key("word", "how much is tried: quick leaves out what takes long"),
}
