"""Parameters of the tool, its parts and the experiments, in SI units and radians.

Every default states its source. The defaults of the tool are the operating point of "Zhang 2020":
J. Zhang, *Analysis of Bristle-Tip Impact Crater for Wire Impact Tool*, PhD dissertation, Marquette
University, 2020.

The hub's centre is the origin. The axis x runs along the workpart in the direction in which the tip
travels; y is the workpart's outward normal. Angles of hub and bristle are measured from the
direction of the workpart (-y) and are positive in the hub's sense of rotation. A bristle at the
angle phi points from its root along (sin phi, -cos phi).
"""

from bristle_sim.parameters.blasting import Blasting
from bristle_sim.parameters.experiments import (
    Assembly,
    Comparison,
    ContactStiffness,
    DoublePendulum,
    MapGrid,
    Neighbours,
    Release,
    Sampling,
    SinglePendulum,
    Spreads,
    Strike,
)
from bristle_sim.parameters.force import Crater, FilmGrid, ForceHistory, Measured, Measurement
from bristle_sim.parameters.parts import (
    CONTACT_KEYS,
    PRINTED_BELT_STIFFNESS,
    RETRACTION_AT_RELEASE,
    SHAPE_KEYS,
    SURFACE_KEYS,
    WIRE_KEYS,
    Bar,
    Belt,
    Bristle,
    Contact,
    Hub,
    Surface,
    Workpart,
)
from bristle_sim.parameters.tool import FIELDS, KEYS, PARTS, START, Tool

__all__ = [
    "CONTACT_KEYS", "FIELDS", "KEYS", "PARTS", "PRINTED_BELT_STIFFNESS", "RETRACTION_AT_RELEASE", "SHAPE_KEYS", "START", "SURFACE_KEYS", "WIRE_KEYS", "Assembly", "Bar", "Belt", "Blasting",
    "Bristle", "Comparison", "Contact", "ContactStiffness", "Crater", "DoublePendulum", "FilmGrid", "ForceHistory", "Hub", "MapGrid",
    "Measured", "Measurement", "Neighbours", "Release", "Sampling", "SinglePendulum", "Spreads", "Strike", "Surface", "Tool", "Workpart",
]  # fmt: skip
