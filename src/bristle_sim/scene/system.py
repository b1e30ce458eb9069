"""A run in progress: the scene, the end conditions, the present state and the record so far."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact import ActiveContact
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.impacts import ENERGETIC, ContactLaw
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.pairs import BarPair, ClosestApproach, ContactPair, WorkpartPair
from bristle_sim.scene.spring import SpringContact
from bristle_sim.settings import StopReason
from bristle_sim.trajectory import ContactRecord, Event

# Largest distance between a contact point and a link's end, as a fraction of the link's length, at
# which the contact counts as at that end.
AT_JOINT = 1e-9

# Largest distance between the contact points of two pairs, in engine units, at which two wires touch
# only once.
SAME_PLACE = 1e-6

GAP_ROUNDING = 1e-11  # largest gap that counts as closed, in engine units

# Largest ratio of an interval to the previous interval, after a change of contact. Up to this ratio
# a polynomial through the samples of both intervals is accurate.
MOST_GROWTH = 16.0

SLOW_FRACTION = 1e-8
"""Least approach speed of an impact with restitution, as a fraction of the speed of the fastest
point. Without this bound, infinitely many ever smaller rebounds would follow each other in a finite
time."""

# Smallest magnitude of an angular velocity, acceleration or force that is not rounding error, in
# engine units.
LEAST_VALUE = 1e-10


@dataclass(slots=True)
class Plan:
    """The end conditions, accuracy and sampling of a run, in engine units.

    Attributes:
        end: time at which the run ends.
        accuracy: requested relative accuracy.
        stop_after: name of an event that ends the run; None without such an event.
        longest_interval: longest interval between samples.
        damped_interval: length of an interval above which engine steps no longer resolve the
            damping; infinite without damping.
        maximum_steps: largest number of engine steps; a step of a mechanism with many links counts
            several times.
        time_scale: time scale of the fastest motion: 1 for rigid links on their belt, less if
            hinges vibrate.
        scale: angular velocity by which errors of the motion are divided, at most 1.
        single_contact: whether the run simulates a single contact. Extremes of the motion are then
            not recorded as events.
        instant: shortest time that is resolved. Within this time no force moves a link by more than
            the accuracy.
        shortest: length of an interval within which the fall of a contact force to zero is not
            resolved. The force counts as zero from the interval's start.
        first_interval: upper bound of the first interval after a contact begins. The bound grows
            from interval to interval.
    """

    end: float
    accuracy: float
    stop_after: str | None = None
    longest_interval: float = math.inf
    damped_interval: float = math.inf
    maximum_steps: int = 1_000_000
    time_scale: float = 1.0
    scale: float = 1.0
    single_contact: bool = False
    instant: float = field(init=False)
    shortest: float = field(init=False)
    first_interval: float = field(init=False)

    def __post_init__(self) -> None:
        """Compute ``instant``, ``shortest`` and ``first_interval`` from the accuracy."""
        self.instant = min(1e-2, max(1e-5, math.sqrt(self.accuracy))) * self.time_scale
        self.shortest = max(1e-9, 0.1 * self.accuracy) * self.time_scale
        longest = max(self.instant, self.longest_interval / MOST_GROWTH)
        self.first_interval = min(MOST_GROWTH * self.instant, longest)


@dataclass(slots=True)
class Recording:
    """The record of a run, in engine units.

    Attributes:
        states: samples of the motion; two samples at the same time are the end of one smooth motion
            and the start of the next.
        forces: sum of the normal contact forces on each wire, for each of ``states``.
        events: events, each with the indices of its wires.
        contacts: contact records, each with the indices of its links.
        summed: sum of the error estimates of all intervals.
        error: estimated error of the last state.
        lost: time of the impact after which the error is unknown, because the growth of the error
            in this impact is not linear; None without such an impact.
        stop_reason: why the run has stopped; None while it continues.
        stop_detail: explanation of the stop by the contact law, or empty.
        begun_wall: wall clock at the beginning of the run, s.
        begun_cpu: processor time at the beginning of the run, s.
    """

    states: list[State] = field(default_factory=list)
    forces: list[list[float]] = field(default_factory=list)
    events: list[tuple[Event, tuple[int, ...]]] = field(default_factory=list)
    contacts: list[tuple[ContactRecord, tuple[int, ...]]] = field(default_factory=list)
    summed: float = 0.0
    error: float = 0.0
    lost: float | None = None
    stop_reason: StopReason | None = None
    stop_detail: str = ""
    begun_wall: float = field(default_factory=clock.perf_counter)
    begun_cpu: float = field(default_factory=clock.process_time)


class System:
    """A run in progress.

    Attributes:
        scene: the scene.
        mechanism: the scene's mechanism.
        plan: plan of the run.
        pairs: the pairs of link and obstacle that can touch. The surface of a pair may have a dent,
            the indentation that an earlier compliant contact has left. The tip then touches the
            bottom of the dent.
        law: impact law of the workpart; the energetic law applies to all other pairs.
        state: the last state reached.
        flight: integrator of motion without contact springs.
        stepper: integrator of the present motion.
        noise: magnitude up to which an angular velocity or acceleration may be error, so that its
            sign is unknown.
        recording: the record so far.
        waiting: indices of the wires that have not yet had the event ``stop_after``.
        clearances: lower bounds of the gaps of pairs that are not in contact. Each interval reduces
            them by the longest path in it. A gap whose bound stays positive is not computed.
    """

    def __init__(
        self,
        scene: Scene,
        start: State,
        flight: Extrapolation,
        plan: Plan,
        pairs: Sequence[ContactPair] | None = None,
        law: ContactLaw = ENERGETIC,
    ) -> None:
        """Begin a run at its initial state.

        Args:
            scene: the scene.
            start: state at the start.
            flight: integrator of motion without contact springs.
            plan: plan of the run.
            pairs: the pairs that can touch; by default those of the scene.
            law: impact law of the workpart.
        """
        self.scene = scene
        self.mechanism = scene.mechanism
        self.plan = plan
        self.pairs = list(scene.effects.pairs if pairs is None else pairs)
        self.law = law
        self.state = start
        self.flight = flight
        self.stepper = flight
        # With a damped spring an error of the angular velocity causes one of the acceleration.
        damping = scene.effects.damping / scene.mechanism.links[0].inertia_about_joint
        self.noise = max(LEAST_VALUE, flight.noise * (1.0 + damping))
        self.recording = Recording()
        self.waiting = set(range(scene.mechanism.wires))
        self.clearances: dict[ContactPair, float] = {}
        self.sample()

    @property
    def slow(self) -> float:
        """Normal speed (engine units) below which a contact point counts as at rest."""
        return SLOW_FRACTION * self.mechanism.speed_bound(self.state)

    def law_of(self, pair: ContactPair) -> ContactLaw:
        """Return the impact law of a pair."""
        return self.law if isinstance(pair, WorkpartPair) else ENERGETIC

    @property
    def follows_law(self) -> bool:
        """Whether the impact law predicts how a contact with a spring ends.

        The law does so in the rigid-body limit, and in the simulation of a single contact of rigid
        links. In any other contact the links may move noticeably while the spring acts.
        """
        single = self.plan.single_contact and not self.scene.effects.hinge[0]
        return single or not self.law.finite_duration

    def slip_error(self, fastest: State) -> float:
        """Return the possible error of a slip velocity.

        The sense of a slip velocity below this error is unknown. The error is proportional to the
        largest speed in the state ``fastest``.
        """
        return max(self.plan.accuracy, self.recording.summed) * self.mechanism.speed_bound(fastest)

    def closest(self, pair: ContactPair, state: State | None = None) -> ClosestApproach:
        """Return the closest approach of a pair in a state, by default the present state."""
        state = state or self.state
        return pair.closest(self.mechanism.poses(state), state.rates)

    def penetration(self, spring: SpringContact, state: State | None = None) -> float:
        """Return the penetration of a contact in a state, by default the present state."""
        return spring.surface - self.closest(spring.pair, state).gap

    def along(self, pair: ContactPair, state: State) -> float:
        """Return the x coordinate (engine units) of a pair's contact point, along the workpart."""
        joint = self.mechanism.poses(state)[pair.link].joint
        return (joint + self.closest(pair, state).arm).real

    def approach(self, pair: ContactPair) -> float:
        """Return the normal velocity (engine units) of a contact point, negative in approach."""
        return self.closest(pair).velocity[0]

    def sample(
        self,
        forces: Mapping[ActiveContact, float] = MappingProxyType({}),
        state: State | None = None,
    ) -> None:
        """Record a state and the sum of the normal contact forces on each wire.

        Args:
            forces: normal force of each contact.
            state: the state; by default the present state.
        """
        sums = [0.0] * self.mechanism.wires
        for contact, force in forces.items():
            for wire in self.wires_of(contact.pair):
                sums[wire] += force
        self.recording.states.append(state or self.state)
        self.recording.forces.append(sums)

    def links_of(self, pair: ContactPair) -> tuple[int, ...]:
        """Return the indices of the links that take part in a contact."""
        own = pair.link % len(self.mechanism.links)
        return (own,) if pair.partner is None else (own, pair.partner)

    def wires_of(self, pair: ContactPair) -> tuple[int, ...]:
        """Return the indices of the wires that take part in a contact."""
        return tuple([link // self.mechanism.wire_links for link in self.links_of(pair)])

    def event(self, name: str, wires: Sequence[int], *, lasts: bool = False) -> None:
        """Record an event; the run ends once every wire has had the event ``stop_after``.

        Args:
            name: name of the event.
            wires: indices of its wires.
            lasts: whether the event is a touch that begins a contact with a spring. The run then
                does not end before the contact does.
        """
        self.recording.events.append((Event(name, self.state.time), tuple(wires)))
        if name == self.plan.stop_after:
            self.waiting -= set(wires)
            if not (self.waiting or lasts):
                self.stop(StopReason.EVENT)

    def stop(self, reason: StopReason, detail: str = "") -> None:
        """End the run for a reason, with an optional explanation; later reasons are ignored."""
        if self.recording.stop_reason is None:
            self.recording.stop_reason = reason
            self.recording.stop_detail = detail

    def coincide(self, pair: ContactPair, others: Sequence[ContactPair], *states: State) -> bool:
        """Return whether a pair of two wires touches at the same two corners as one of ``others``.

        The result is true if it does so in one of ``states``.
        """
        wires = {*self.wires_of(pair)}
        for other in others:
            for state in states if wires == {*self.wires_of(other)} else ():
                joints = [self.mechanism.poses(state)[each.link].joint for each in (pair, other)]
                touch, second = (self.closest(each, state) for each in (pair, other))
                apart = joints[0] + touch.arm - joints[1] - second.arm
                if abs(apart) <= SAME_PLACE + abs(touch.gap):
                    return True
        return False

    def neighbour(self, pair: ContactPair, step: int) -> BarPair | None:
        """Return the pair of the bar and the neighbouring link of the same wire.

        Return None if there is no such pair. ``step`` is 1 for the neighbour towards the tip, -1
        for the neighbour towards the root.
        """
        link = pair.link + step
        size = self.mechanism.wire_links
        if not isinstance(pair, BarPair) or link // size != pair.link // size:
            return None
        return next(
            (other for other in self.pairs if isinstance(other, BarPair) and other.link == link),
            None,
        )

    def behind_joint(
        self, pair: ContactPair, active: Sequence[ContactPair], end: State
    ) -> int | None:
        """Return the index of a link's segment that touches the bar only at a joint in contact.

        The link shares this joint with a neighbouring link, which is in contact already. The
        segment begins or ends at the joint. The joint must be the segment's point closest to the
        bar at present. In addition, the joint must be the closest point at ``end`` too, or the
        present gap must be closed. Otherwise the segment may touch the bar at another point, and
        the result is None.

        Args:
            pair: the link and the bar.
            active: pairs in contact or separating.
            end: state at the end of the interval.
        """
        if not self.mechanism.jointed or not isinstance(pair, BarPair):
            return None
        for sign, index, step in ((1.0, 0, -1), (-1.0, -1, 1)):
            if self.neighbour(pair, step) in active:
                ends, at_end = (
                    pair.ends_passed(self.mechanism.poses(state)[pair.link])
                    for state in (self.state, end)
                )
                if sign * ends[index] <= AT_JOINT and (
                    sign * at_end[index] <= AT_JOINT or self.closest(pair).gap <= GAP_ROUNDING
                ):
                    return 0 if step < 0 else len(ends) // 2 - 1
        return None

    def at_joint(self, pair: ContactPair) -> ContactPair:
        """Return the pair to which a touch is assigned.

        Where two links meet at a joint, the wire's round end belongs to the link nearer to the
        root. If the bar touches the link of ``pair`` at this joint, the result is the pair of the
        bar and the link nearer to the root. Otherwise it is ``pair``.
        """
        lower = self.neighbour(pair, -1)
        if lower is None or not isinstance(pair, BarPair):
            return pair
        pose = self.mechanism.poses(self.state)[pair.link]
        return pair if pair.ends_passed(pose)[0] > 0.0 else lower
