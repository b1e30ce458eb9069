"""The system that a run moves: the scene, the plan of the run, its present state and its record so far."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact import ActiveContact
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.gaps import AT_JOINT, GAP_ROUNDING, Gaps
from bristle_sim.scene.impacts import ENERGETIC, ContactLaw
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.pairs import BarPair, ContactPair, WorkpartPair
from bristle_sim.settings import StopReason
from bristle_sim.trajectory import ContactRecord, Event

MOST_GROWTH = 16.0  # of an interval after a contact, so that a polynomial through the samples of both is accurate

SLOW_FRACTION = 1e-8
"""Fraction of the fastest point's speed below which an impact gets no restitution: otherwise infinitely many ever smaller
bounces would follow each other in a finite time."""

LEAST_VALUE = 1e-10  # rates, accelerations and forces of a scene's units below this have no sign


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


class System:
    """A scene on its way through a run.

    Attributes:
        scene, mechanism, plan: of the run.
        pairs: the pairs that can touch, each with its present surface: a tip in a dent touches the bottom of the dent.
        law: the impact law of the workpart; all other pairs have the energetic law.
        gaps: the gaps of the pairs in any state.
        state: the last state that was reached.
        flight, stepper: the integrators of motion without springs and of the present motion.
        noise: rates and accelerations below this have no sign.
        recording: the record so far.
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
            start: its state at the start.
            flight: integrator of motion without springs.
            plan: of the run.
            pairs: the pairs that can touch, those of the scene by default.
            law: impact law of the workpart.
        """
        self.scene = scene
        self.mechanism = scene.mechanism
        self.plan = plan
        self.pairs = list(scene.effects.pairs if pairs is None else pairs)
        self.law = law
        self.gaps = Gaps(scene.mechanism)
        self.state = start
        self.flight = flight
        self.stepper = flight
        # A damped spring turns an error of the rate into one of the acceleration.
        damping = scene.effects.damping / scene.mechanism.links[0].inertia_about_joint
        self.noise = max(LEAST_VALUE, flight.noise * (1.0 + damping))
        self.recording = Recording()
        self.sample()

    @property
    def slow(self) -> float:
        """Speed below which the rest of an approach or of a rebound is not followed."""
        return SLOW_FRACTION * self.mechanism.speed_bound(self.state)

    def law_of(self, pair: ContactPair) -> ContactLaw:
        """Return the impact law of a pair."""
        return self.law if isinstance(pair, WorkpartPair) else ENERGETIC

    def slip_error(self, fastest: State) -> float:
        """Return the possible error of a slip velocity in a motion with this fastest state; a slower slip has no known sense."""
        return max(self.plan.accuracy, self.recording.summed) * self.mechanism.speed_bound(fastest)

    def approach(self, pair: ContactPair) -> float:
        """Return the normal velocity of a pair's contact point, negative where it approaches."""
        return self.gaps.closest(pair, self.state).velocity[0]

    def touches(self, pair: ContactPair) -> bool:
        """Return whether a pair's gap is closed."""
        return abs(self.gaps.gap(pair, self.state)) <= GAP_ROUNDING

    def sample(
        self,
        forces: Mapping[ActiveContact, float] = MappingProxyType({}),
        *,
        again: bool = False,
        state: State | None = None,
    ) -> None:
        """Record the present state or another one, with the normal contact forces summed for each wire.

        With ``again``, only replace the forces of the last sample.
        """
        sums = [0.0] * self.mechanism.wires
        for contact, force in forces.items():
            for wire in self.wires_of(contact.pair):
                sums[wire] += force
        if again:
            self.recording.forces[-1] = sums
        else:
            self.recording.states.append(state or self.state)
            self.recording.forces.append(sums)

    def links_of(self, pair: ContactPair) -> tuple[int, ...]:
        """Return the numbers of the links that take part in a contact."""
        own = pair.link % len(self.mechanism.links)
        return (own,) if pair.partner is None else (own, pair.partner)

    def wires_of(self, pair: ContactPair) -> tuple[int, ...]:
        """Return the numbers of the wires that take part in a contact."""
        return tuple([link // self.mechanism.wire_links for link in self.links_of(pair)])

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
        happened = {
            wire for each, wires in self.recording.events if each.name == last for wire in wires
        }
        return len(happened) == self.mechanism.wires

    def contact(self, record: ContactRecord, pair: ContactPair) -> None:
        """Record a contact."""
        self.recording.contacts.append((record, self.links_of(pair)))

    def stop(self, reason: StopReason, detail: str = "") -> None:
        """End the run for a reason, with the law's detail of it; only the first reason is kept."""
        if self.recording.stop_reason is None:
            self.recording.stop_reason = reason
            self.recording.stop_detail = detail

    def neighbour(self, pair: ContactPair, step: int) -> BarPair | None:
        """Return the pair of the same bar and the next link of the wire towards the tip (1) or the root (-1)."""
        link = pair.link + step
        size = self.mechanism.wire_links
        if pair.link < 0 or not isinstance(pair, BarPair) or link // size != pair.link // size:
            return None
        return next(
            (other for other in self.pairs if isinstance(other, BarPair) and other.link == link),
            None,
        )

    def behind_joint(self, pair: ContactPair, active: Sequence[ContactPair], end: State) -> bool:
        """Return whether, up to a state, the link's point closest to a touching neighbour's bar is the joint they share.

        A link that is clear of the bar and ends elsewhere may touch it by itself.
        """
        if not isinstance(pair, BarPair):
            return False
        gaps = self.gaps
        for sign, index, step in ((1.0, 0, -1), (-1.0, 1, 1)):
            if self.neighbour(pair, step) in active:
                now, later = (
                    sign * pair.foot(gaps.poses(state)[pair.link])[index]
                    for state in (self.state, end)
                )
                if now <= AT_JOINT and (
                    later <= AT_JOINT or gaps.gap(pair, self.state) <= GAP_ROUNDING
                ):
                    return True
        return False

    def at_joint(self, pair: ContactPair) -> ContactPair:
        """Return the pair that a touch belongs to: at a joint, that of the link before it, whose round end is there."""
        lower = self.neighbour(pair, -1)
        if lower is None or not isinstance(pair, BarPair):
            return pair
        return pair if pair.foot(self.gaps.poses(self.state)[pair.link])[0] > 0.0 else lower
