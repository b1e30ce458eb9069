"""Where a run has got to, with what it runs, and what it has recorded so far."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact.compliant import CompliantLaw
from bristle_sim.scene.contact.gaps import GAP_ROUNDING, Gaps
from bristle_sim.scene.contact.laws import ContactLaw
from bristle_sim.scene.contact.obstacles import Obstacle, WorkpartObstacle
from bristle_sim.scene.events.changes import Changes
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
"""Events after which a run cannot be resumed, requested or not."""


class Rebound(NamedTuple):
    """The last rebound: from which obstacle, when, and how fast the contact point left."""

    obstacle: Obstacle
    time: float
    speed: float


@dataclass(slots=True)
class Progress:
    """What is common to the smooth motions of one run.

    Attributes:
        scene, stepper, law, plan: of the run.
        state: the last state that was reached.
        gaps: between links and what they can touch.
        changes: signs of the event functions.
        obstacles: the pairs, each with its surface where it is now: a tip in a dent touches the ground of it.
        recording: what the run leaves behind.
        rebound: the last rebound, if there was one.
    """

    scene: Scene
    stepper: Stepper
    law: ContactLaw
    plan: Plan
    state: State
    gaps: Gaps
    changes: Changes
    obstacles: list[Obstacle]
    recording: Recording
    rebound: Rebound | None = None

    @classmethod
    def at_start(cls, scene: Scene, start: State, stepper: Stepper, law: ContactLaw, plan: Plan) -> Progress:
        """Return the progress of a run that has not moved yet.

        Raises:
            ValueError: if the start overlaps an obstacle.
        """
        gaps, changes = Gaps(scene.mechanism), Changes(scene, stepper, plan.accuracy)
        obstacles = list(scene.effects.obstacles)
        progress = cls(scene, stepper, law, plan, start, gaps, changes, obstacles, Recording())
        progress.sample(0.0)
        if isinstance(law, CompliantLaw):
            law.observe = progress.recording.inner.extend
        for obstacle in scene.effects.obstacles:
            if plan.contact is not None:
                progress.in_dent(obstacle)
            elif (gap := gaps.gap(obstacle, start)) < -GAP_ROUNDING:
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

    def touches(self, obstacle: Obstacle) -> bool:
        """Whether a link is on an obstacle, but for rounding."""
        return abs(self.gaps.gap(obstacle, self.state)) <= GAP_ROUNDING

    def in_dent(self, obstacle: Obstacle) -> Obstacle:
        """Return the pair with its surface at the ground of the dent that a contact resolved in time has left the tip in."""
        gap = self.gaps.gap(obstacle, self.state)
        if gap >= -self.plan.accuracy or not isinstance(obstacle, WorkpartObstacle):
            return obstacle
        ground = dataclasses.replace(obstacle, depth=obstacle.depth - gap)
        number = self.obstacles.index(obstacle)
        self.obstacles[number] = ground
        return ground

    def dents(self) -> list[int]:
        """Return the numbers of the pairs whose tips are in dents."""
        outside = self.scene.effects.obstacles
        return [number for number, each in enumerate(self.obstacles) if outside[number] is not each]

    def leave_dent(self, number: int) -> None:
        """Have the pair of that number touch the surface again."""
        self.obstacles[number] = self.scene.effects.obstacles[number]

    def sample(self, force: float | tuple[float, ...]) -> None:
        """Record the state that was reached, with the normal force, of each wire if there are several."""
        self.recording.states.append(self.state)
        self.recording.forces.append(force)

    def links_of(self, obstacle: Obstacle) -> tuple[int, ...]:
        """Return the numbers of the links that take part in a contact."""
        own = obstacle.link % len(self.mechanism.links)
        return (own,) if obstacle.partner is None else (own, obstacle.partner)

    def wires_of(self, obstacle: Obstacle) -> tuple[int, ...]:
        """Return the numbers of the wires that take part in a contact."""
        return tuple(link // self.mechanism.wire_links for link in self.links_of(obstacle))

    def force_of_wires(self, forces: Sequence[float], obstacles: Sequence[Obstacle]) -> float | tuple[float, ...]:
        """Return the sum of normal forces, for each wire if there are several."""
        if self.mechanism.wires == 1:
            return math.fsum(forces)
        pairs = [(force, self.wires_of(each)) for force, each in zip(forces, obstacles, strict=True)]
        return tuple(math.fsum(force for force, of in pairs if wire in of) for wire in range(self.mechanism.wires))

    def event(self, name: str, time: float, wires: Sequence[int] = (0,)) -> None:
        """Record an event of some wires; the run ends once every wire has had the one that is to end it."""
        events = self.recording.events
        events.append((Event(name, time), tuple(wires)))
        if name in FINAL and name == self.plan.stop_after:
            self.stop(FINAL[name])
        elif name == self.plan.stop_after:
            happened = {wire for each, of in events if each.name == name for wire in of}
            if len(happened) == self.mechanism.wires:
                self.stop(StopReason.EVENT)

    def contact(self, record: ContactRecord, obstacle: Obstacle) -> None:
        """Record a contact."""
        self.recording.contacts.append((record, self.links_of(obstacle)))

    def touched(self, obstacle: Obstacle) -> bool:
        """Whether a pair's wire has been in contact with the obstacle of that name."""
        if obstacle.name in self.plan.touched:
            return True
        wire, size = self.wires_of(obstacle)[0], self.mechanism.wire_links
        return any(
            each.obstacle == obstacle.name and wire in (link // size for link in links)
            for each, links in self.recording.contacts
        )

    def stop(self, reason: StopReason, detail: str = "") -> None:
        """End the run, for a reason and with what a law says about it; the first reason counts."""
        if not self.stopped:
            self.recording.stop_reason, self.recording.stop_detail = reason, detail
