"""The end conditions of a run, its present state and its record so far."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact.gaps import Gaps
from bristle_sim.scene.contact.obstacles import Obstacle
from bristle_sim.scene.contact.sustained import Sustained
from bristle_sim.scene.events.locate import LEAST_VALUE
from bristle_sim.scene.extrapolation import Stepper
from bristle_sim.scene.mechanism import State
from bristle_sim.settings import StopReason
from bristle_sim.trajectory import ContactRecord, Event

MOST_GROWTH = 16.0  # of an interval after a contact, so that a polynomial through the samples of both is accurate

MOST_CHANGED_APPROACH = 0.5  # by the error, as a fraction; the impact is beyond linear error propagation then
SLOW_FRACTION = 1e-8
"""Fraction of the fastest point's speed below which an impact gets no restitution: otherwise infinitely many ever smaller
bounces would follow each other in a finite time."""


@dataclass(slots=True)
class Plan:
    """A run's end conditions, accuracy and density of samples; engine units.

    Attributes:
        longest_interval, damped_interval: longest between samples, and in which damping is resolved.
        stop_after: name of an event that ends the run.
        maximum_steps: budget after which the run gives up, in engine steps of few iterations.
        retraction_limit: largest angle of a wire's first link relative to the hub, rad.
        time_scale: of the fastest motion, 1 for rigid links on their belt, less where hinges vibrate.
        single_contact: whether only one contact is of interest, without the extremes of the motion.
        instant: shortest time resolved, within which no force moves a link by more than the accuracy.
        shortest: interval below which a force that vanishes within it counts as vanished at its start.
        first_interval: longest one right after a contact begins, and the least length from which later ones grow.
    """

    end: float
    accuracy: float
    stop_after: str | None = None
    longest_interval: float = math.inf
    damped_interval: float = math.inf
    maximum_steps: int = 1_000_000
    retraction_limit: float = math.inf
    time_scale: float = 1.0
    single_contact: bool = False
    instant: float = field(init=False)
    shortest: float = field(init=False)
    first_interval: float = field(init=False)

    def __post_init__(self) -> None:
        """Compute the shortest times from the accuracy."""
        self.instant = min(1e-2, max(1e-5, math.sqrt(self.accuracy))) * self.time_scale
        self.shortest = max(1e-9, 0.1 * self.accuracy) * self.time_scale
        longest = max(self.instant, self.longest_interval / MOST_GROWTH)
        self.first_interval = min(MOST_GROWTH * self.instant, longest)


@dataclass(slots=True)
class Recording:
    """The record of a run, in engine units.

    ``forces`` are the sums of normal contact forces at ``states``, of each wire. ``inner`` are states between ``states`` that a
    sustained contact's geometry gives. Two of ``states`` at one time are the end of one smooth motion and the start of the
    next. ``events`` come with the numbers of their wires, ``contacts`` with those of their links. ``summed`` are the intervals'
    error estimates. ``error`` is that of the last state; it is unknown after an impact whose approach is no larger than the
    error.
    """

    states: list[State] = field(default_factory=list)
    forces: list[list[float]] = field(default_factory=list)
    inner: list[State] = field(default_factory=list)
    events: list[tuple[Event, tuple[int, ...]]] = field(default_factory=list)
    contacts: list[tuple[ContactRecord, tuple[int, ...]]] = field(default_factory=list)
    summed: float = 0.0
    error: float = 0.0
    lost: float | None = None
    stop_reason: StopReason | None = None
    stop_detail: str = ""


class Progress:
    """The state shared by the smooth motions of one run.

    Attributes:
        state: the last state that was reached.
        obstacles: the pairs, each with its present surface: a tip in a dent touches the bottom of the dent.
        flight, stepper: the integrators of motion without springs and of the present motion.
        noise: rates and accelerations below this have no sign.
    """

    def __init__(
        self, scene: Scene, start: State, flight: Stepper, plan: Plan, obstacles: Sequence[Obstacle] | None
    ) -> None:
        """Begin a run at its initial state."""
        self.scene, self.mechanism, self.plan, self.state = scene, scene.mechanism, plan, start
        self.flight = self.stepper = flight
        self.gaps, self.recording = Gaps(scene.mechanism), Recording()
        self.obstacles = list(scene.effects.obstacles if obstacles is None else obstacles)
        # A damped spring turns an error of the rate into one of the acceleration.
        damping = scene.effects.damping / scene.mechanism.links[0].inertia_about_joint
        self.noise = max(LEAST_VALUE, flight.noise * (1.0 + damping))
        self.sample()

    @property
    def slow(self) -> float:
        """Speed below which the rest of an approach or of a rebound is not followed."""
        return SLOW_FRACTION * self.mechanism.speed_bound(self.state)

    def slip_error(self, fastest: State) -> float:
        """Return the possible error of a slip velocity in a motion with this fastest state; a slower slip has no known sense."""
        return max(self.plan.accuracy, self.recording.summed) * self.mechanism.speed_bound(fastest)

    def approach(self, obstacle: Obstacle) -> float:
        """Return the normal velocity of a pair's contact point, negative where it approaches."""
        return self.gaps.closest(obstacle, self.state).velocity[0]

    def sample(
        self,
        forces: Mapping[Sustained, float] = MappingProxyType({}),
        *,
        again: bool = False,
        state: State | None = None,
    ) -> None:
        """Record the present state or another one, with the normal contact forces summed for each wire.

        With ``again``, only replace the forces of the last sample.
        """
        sums = [0.0] * self.mechanism.wires
        for contact, force in forces.items():
            for wire in self.wires_of(contact.obstacle):
                sums[wire] += force
        if again:
            self.recording.forces[-1] = sums
        else:
            self.recording.states.append(state or self.state)
            self.recording.forces.append(sums)

    def links_of(self, obstacle: Obstacle) -> tuple[int, ...]:
        """Return the numbers of the links that take part in a contact."""
        own = obstacle.link % len(self.mechanism.links)
        return (own,) if obstacle.partner is None else (own, obstacle.partner)

    def wires_of(self, obstacle: Obstacle) -> tuple[int, ...]:
        """Return the numbers of the wires that take part in a contact."""
        return tuple([link // self.mechanism.wire_links for link in self.links_of(obstacle)])

    def event(self, name: str, wires: Sequence[int], *, lasts: bool = False) -> None:
        """Record an event of some wires; the run ends once every wire has had the event ``stop_after``.

        If the event is a touch that ``lasts``, the run ends when that contact is over.
        """
        self.recording.events.append((Event(name, self.state.time), tuple(wires)))
        if name == self.plan.stop_after and not lasts and self.had_last_event:
            self.stop(StopReason.EVENT)

    @property
    def had_last_event(self) -> bool:
        """Whether every wire has had the event that ends the run."""
        last = self.plan.stop_after
        happened = {wire for each, wires in self.recording.events if each.name == last for wire in wires}
        return len(happened) == self.mechanism.wires

    def propagate(self, obstacle: Obstacle, before: State, record: ContactRecord) -> None:
        """Propagate the error over an impact, by two motions that are off by it in angle, and in rate with either sign.

        These touch at another instant, and their rates jump there in proportion to their approach. If the law has adjusted
        the slip so that it ends with the approach, it is uncertain whether the contact sticks or jams.
        """
        recording, error = self.recording, self.recording.error
        if recording.lost is not None:
            return
        earlier = next((each for each in reversed(recording.states) if each.time < before.time), before)
        since, (approach, slip) = before.time - earlier.time or math.inf, self.gaps.closest(obstacle, before).velocity
        changes = [(b - a) / since for a, b in zip(earlier.rates, before.rates, strict=True)]
        jumps = [b - a for a, b in zip(before.rates, record.rates_after, strict=True)]
        snap, jams = abs(slip - record.velocity_before[1]), obstacle.friction * abs(slip) >= abs(approach)
        undecided = snap > (0.0 if jams else error)
        for off in (error, -error):
            angles, rates = [each + error for each in before.angles], [each + off for each in before.rates]
            gap, opening = self.gaps.gap_and_rate(obstacle, State(before.time, tuple(angles), tuple(rates)))
            late = -gap / opening if opening else math.inf
            angles = [each + late * rate for each, rate in zip(angles, rates, strict=True)]
            rates = [each + late * change for each, change in zip(rates, changes, strict=True)]
            there = self.gaps.closest(obstacle, State(before.time + late, tuple(angles), tuple(rates))).velocity[0]
            part = there / approach - 1.0 if approach else math.inf
            if undecided or not abs(part) < MOST_CHANGED_APPROACH:
                recording.lost = before.time
                return
            for each in jumps:
                recording.error = max(recording.error, abs(error - each * late), abs(off + each * part))

    def contact(self, record: ContactRecord, obstacle: Obstacle) -> None:
        """Record a contact."""
        self.recording.contacts.append((record, self.links_of(obstacle)))

    def stop(self, reason: StopReason, detail: str = "") -> None:
        """End the run for a reason, with the law's detail of it; only the first reason is kept."""
        if self.recording.stop_reason is None:
            self.recording.stop_reason, self.recording.stop_detail = reason, detail
