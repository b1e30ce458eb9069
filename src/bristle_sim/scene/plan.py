"""When a run ends, and what it leaves behind."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from bristle_sim.scene.mechanism import State
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import ContactRecord, Event


@dataclass(frozen=True, slots=True)
class Plan:
    """When a run ends and how finely it is recorded; engine units.

    Attributes:
        end: time at which the run stops.
        accuracy: relative requested accuracy; sets how finely events are located.
        stop_after: name of an event that ends the run.
        longest_interval: upper bound of the distance between samples.
        maximum_steps: work after which the run gives up, in engine steps of few iterations.
        retraction_limit: largest angle of a wire's first link relative to the hub, rad.
        time_scale: of the fastest motion, 1 for rigid links on their belt, less where hinges vibrate.
        single_contact: whether one contact is all that is of interest, without the extremes of the motion.
    """

    end: float
    accuracy: float
    stop_after: str | None = None
    longest_interval: float = math.inf
    maximum_steps: int = 1_000_000
    retraction_limit: float = math.inf
    time_scale: float = 1.0
    single_contact: bool = False


Numbers = tuple[int, ...]
"""Numbers of the wires whose event it is, or of the links in contact."""


@dataclass(slots=True)
class Recording:
    """What a run leaves behind, in engine units; ``cost`` are wall clock and processor time, s, and engine steps.

    ``forces`` are the sums of normal contact forces at ``states``, of each wire. ``inner`` are states between ``states`` that
    a sustained contact's geometry gives. Two of ``states`` at one time are the ends of two smooth motions.
    """

    states: list[State] = field(default_factory=list)
    forces: list[list[float]] = field(default_factory=list)
    inner: list[State] = field(default_factory=list)
    events: list[tuple[Event, Numbers]] = field(default_factory=list)
    contacts: list[tuple[ContactRecord, Numbers]] = field(default_factory=list)
    error: float = 0.0
    stop_reason: StopReason | None = None
    stop_detail: str = ""
    cost: tuple[float, float, int] = (0.0, 0.0, 0)
