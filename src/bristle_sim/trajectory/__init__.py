"""Trajectories, the results of runs: motion, events and contacts.

A trajectory can be saved, tabulated, interpolated and drawn.
"""

from bristle_sim.trajectory.interpolation import Interpolation
from bristle_sim.trajectory.records import (
    ContactHistory,
    ContactRecord,
    Cost,
    Event,
    Motion,
    WireMotion,
)
from bristle_sim.trajectory.trajectory import Trajectory

__all__ = [
    "ContactHistory", "ContactRecord", "Cost", "Event", "Interpolation", "Motion", "Trajectory", "WireMotion",
]  # fmt: skip
