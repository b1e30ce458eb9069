"""What a run returns: its motion in time, events and contacts; saved, tabulated, interpolated, summarized and drawn."""

from bristle_sim.trajectory.records import ContactAtEnd, ContactHistory, ContactRecord, Cost, Event
from bristle_sim.trajectory.trajectory import Trajectory

__all__ = ["ContactAtEnd", "ContactHistory", "ContactRecord", "Cost", "Event", "Trajectory"]
