"""Trajectories, the results of runs: motion, events, contacts; saved, tabulated, interpolated and drawn."""

from bristle_sim.trajectory.interpolation import Interpolation
from bristle_sim.trajectory.records import (
    ContactAtEnd,
    ContactHistory,
    ContactRecord,
    Cost,
    Event,
    InnerSamples,
    Motion,
)
from bristle_sim.trajectory.trajectory import Trajectory

__all__ = [
    "ContactAtEnd", "ContactHistory", "ContactRecord", "Cost", "Event", "InnerSamples", "Interpolation", "Motion", "Trajectory",
]  # fmt: skip
