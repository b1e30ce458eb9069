"""Where a run has got to, with what it runs, and what it has recorded so far."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact.gaps import GAP_ROUNDING, Gaps
from bristle_sim.scene.contact.obstacles import Obstacle, dented
from bristle_sim.scene.contact.sustained import Sustained
from bristle_sim.scene.events.functions import Kink
from bristle_sim.scene.events.signs import Signs
from bristle_sim.scene.integrate.stepping import Stepper
from bristle_sim.scene.mechanism import Mechanism, State
from bristle_sim.scene.plan import Plan, Recording
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import ContactRecord, Event

GROWTH = 16.0
"""Largest ratio of an interval after a contact to the one before it: a polynomial through the samples of both is accurate."""

CAPTURE = 1e-8
"""Fraction of the fastest point's speed below which an impact gets no restitution: ever smaller bounces would otherwise
follow each other without end within a finite time."""

FINAL = {"jam": StopReason.JAM, "retraction limit": StopReason.RETRACTION_LIMIT}
"""Events that end every run, requested or not."""


@dataclass(slots=True)
class Progress:
    """What is common to the smooth motions of one run.

    Attributes:
        scene, flight, plan: the scene, the integrator of motion without springs, and when the run ends.
        state: the last state that was reached.
        gaps: between links and what they can touch.
        signs: of the event functions.
        obstacles: the pairs, each with its surface where it is now: a tip in a dent touches the ground of it.
        recording: samples, events and contacts so far.
        stepper: the integrator of the present motion.
    """

    scene: Scene
    flight: Stepper
    plan: Plan
    state: State
    gaps: Gaps
    signs: Signs
    obstacles: list[Obstacle]
    recording: Recording
    stepper: Stepper

    @classmethod
    def at_start(
        cls,
        scene: Scene,
        start: State,
        stepper: Stepper,
        plan: Plan,
        obstacles: Sequence[Obstacle] | None = None,
    ) -> Progress:
        """Return the progress of a run that has not moved yet.

        Raises:
            ValueError: if the start overlaps an obstacle.
        """
        gaps, signs = Gaps(scene.mechanism), Signs(scene, stepper, plan.accuracy)
        pairs = list(scene.effects.obstacles if obstacles is None else obstacles)
        progress = cls(scene, stepper, plan, start, gaps, signs, pairs, Recording(), stepper)
        progress.sample()
        for obstacle in pairs:
            if (gap := gaps.gap(obstacle, start)) < -GAP_ROUNDING:
                raise ValueError(
                    f"{obstacle.name}: must not overlap the bristle at the start, by {-gap:.3g} of its length"
                )
        return progress

    @property
    def mechanism(self) -> Mechanism:
        """The scene's mechanism."""
        return self.scene.mechanism

    @property
    def stopped(self) -> bool:
        """Whether the run has a reason to stop."""
        return self.recording.stop_reason is not None

    @property
    def instant(self) -> float:
        """Time in which a single link does not move by more than the accuracy, whatever pushes it: what lasts less is over at once."""
        return min(1e-2, max(1e-5, math.sqrt(self.plan.accuracy))) * self.plan.time_scale

    @property
    def shortest(self) -> float:
        """Length of an interval within which a force that vanishes has vanished at once."""
        return max(1e-9, 0.1 * self.plan.accuracy) * self.plan.time_scale

    @property
    def first_interval(self) -> float:
        """Longest interval right after a contact, and the least that the growth of later ones starts from."""
        return min(GROWTH * self.instant, max(self.instant, self.plan.longest_interval / GROWTH))

    @property
    def slow(self) -> float:
        """Speed below which the rest of an approach or of a rebound is not followed."""
        return CAPTURE * self.mechanism.speed_bound(self.state)

    @property
    def slip_error(self) -> float:
        """Error that a slip velocity may have by now: of a sense that is no more than this nothing is known."""
        return max(self.plan.accuracy, self.recording.error) * self.mechanism.speed_bound(self.state)

    def approach(self, obstacle: Obstacle) -> float:
        """Return the normal velocity of a pair's contact point, negative where it approaches."""
        return self.gaps.closest(obstacle, self.state).velocity[0]

    @property
    def ends_after_touch(self) -> bool:
        """Whether the run ends once the contacts with springs are over that the event to stop after has begun."""
        return (
            self.plan.stop_after is not None and self.plan.stop_after not in FINAL and self._had(self.plan.stop_after)
        )

    def touches(self, obstacle: Obstacle) -> bool:
        """Whether a link is on an obstacle, but for rounding."""
        return abs(self.gaps.gap(obstacle, self.state)) <= GAP_ROUNDING

    def in_dent(self, obstacle: Obstacle) -> Obstacle:
        """Return the pair with its surface at the ground of the dent that a contact resolved in time has left the tip in."""
        gap = self.gaps.gap(obstacle, self.state)
        if gap >= -self.plan.accuracy or obstacle.partner is not None:
            return obstacle
        ground = dented(obstacle, obstacle.dent - gap)
        number = self.obstacles.index(obstacle)
        self.obstacles[number] = ground
        return ground

    def dents(self) -> list[int]:
        """Return the numbers of the pairs whose tips are in dents."""
        return [number for number, each in enumerate(self.obstacles) if each.dent]

    def leave_dent(self, number: int) -> Kink:
        """Have the pair of that number touch the surface again."""
        self.obstacles[number] = dented(self.obstacles[number], 0.0)
        return Kink()

    def sample(self, forces: Sequence[float] = (), contacts: Sequence[Sustained] = (), *, again: bool = False) -> None:
        """Record the state that was reached, with the normal forces of contacts, summed for each wire.

        With ``again`` the last sample gets the forces instead.
        """
        sums = [0.0] * self.mechanism.wires
        for force, contact in zip(forces, contacts, strict=True):
            for wire in self.wires_of(contact.obstacle):
                sums[wire] += force
        if again:
            self.recording.forces[-1] = sums
        else:
            self.recording.states.append(self.state)
            self.recording.forces.append(sums)

    def links_of(self, obstacle: Obstacle) -> tuple[int, ...]:
        """Return the numbers of the links that take part in a contact."""
        own = obstacle.link % len(self.mechanism.links)
        return (own,) if obstacle.partner is None else (own, obstacle.partner)

    def wires_of(self, obstacle: Obstacle) -> tuple[int, ...]:
        """Return the numbers of the wires that take part in a contact."""
        return tuple(link // self.mechanism.wire_links for link in self.links_of(obstacle))

    def event(self, name: str, time: float, wires: Sequence[int] = (0,), *, lasts: bool = False) -> None:
        """Record an event of some wires; the run ends once every wire has had the one that is to end it.

        A touch that ``lasts`` ends it when its contact is over.
        """
        events = self.recording.events
        events.append((Event(name, time), tuple(wires)))
        if name in FINAL and name == self.plan.stop_after:
            self.stop(FINAL[name])
        elif name == self.plan.stop_after and not lasts and self._had(name):
            self.stop(StopReason.EVENT)

    def _had(self, name: str) -> bool:
        """Whether every wire has had an event of that name."""
        happened = {wire for each, of in self.recording.events if each.name == name for wire in of}
        return len(happened) == self.mechanism.wires

    def contact(self, record: ContactRecord, obstacle: Obstacle) -> None:
        """Record a contact."""
        self.recording.contacts.append((record, self.links_of(obstacle)))

    def touched(self, obstacle: Obstacle) -> bool:
        """Whether a pair's wire has been in contact with the obstacle of that name."""
        wire, size = self.wires_of(obstacle)[0], self.mechanism.wire_links
        return any(
            each.obstacle == obstacle.name and wire in (link // size for link in links)
            for each, links in self.recording.contacts
        )

    def stop(self, reason: StopReason, detail: str = "") -> None:
        """End the run, for a reason and with what a law says about it; the first reason counts."""
        if not self.stopped:
            self.recording.stop_reason, self.recording.stop_detail = reason, detail
