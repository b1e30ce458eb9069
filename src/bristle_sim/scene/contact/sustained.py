"""A sustained contact: rigid until its force has fallen to zero, or with a spring; its sums and its record."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from bristle_sim.scene.contact.gaps import Gaps
from bristle_sim.scene.contact.obstacles import Obstacle
from bristle_sim.scene.contact.spring import Spring
from bristle_sim.scene.mechanism import State
from bristle_sim.trajectory import ContactRecord


class Outcome(StrEnum):
    """The end of a contact; a sustained one may instead name the obstacle that ended it, or why the run stopped."""

    REBOUND = "rebound"
    NO_REBOUND = "no rebound"
    STICTION = "stiction"
    JAM = "jam"
    RELEASE = "release"


@dataclass(slots=True, eq=False)
class Sustained:
    """A contact that lasts.

    Attributes:
        obstacle: the pair in contact.
        spring: of a contact resolved in time; None of a rigid one.
        start: state at which it began; None before.
        sums: normal and tangential impulse, normal and tangential work since.
        force: normal force at the end of the last interval; None before.
        vanishes_in: time from then to the zero of the force, from the parabola with the interval's forces and impulse.
        slip: sense of slip that friction opposes in a rigid contact; 0 sticks, None until it is determined.
        stopped: sense of the slip that has just stopped; 0 if none has.
    """

    obstacle: Obstacle
    spring: Spring | None = None
    start: State | None = None
    sums: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    force: float | None = None
    vanishes_in: float = math.inf
    slip: int | None = None
    stopped: int = 0

    def begin(self, state: State) -> None:
        """Prepare for the next smooth motion in contact."""
        self.start = self.start or state
        self.force, self.vanishes_in = None, math.inf

    def turn(self, sense: int) -> None:
        """Change the sense of slip, or stick, from now on."""
        self.stopped, self.slip = (self.slip or 0) if sense == 0 else 0, sense

    def add(self, force: float, sums: Sequence[float], length: float) -> float:
        """Add a rigid contact's impulse and work in an interval; return the normal force at the interval's beginning."""
        self.sums = tuple(a + b for a, b in zip(self.sums, sums, strict=True))
        first = force
        if length > 0.0:
            mean = sums[0] / length
            first = 2.0 * mean - force if self.force is None else self.force
            bend = 3.0 * (first + force) - 6.0 * mean
            slope = force - first + bend
            square = slope * slope - 4.0 * bend * force
            falls = math.sqrt(square) - slope if square >= 0.0 else 0.0
            self.vanishes_in = 2.0 * length * force / falls if falls > 0.0 else math.inf
        self.force = force
        return first

    def add_spring(self, totals: Sequence[float]) -> None:
        """Add the spring's impulse and work in an interval, see :class:`SpringForce`."""
        assert self.spring is not None
        self.sums = tuple(a + b for a, b in zip(self.sums, totals, strict=False))
        self.spring.stick_force = totals[5]

    def sample(self, gaps: Gaps, state: State) -> float:
        """Record the spring's force at a state, and return the normal one."""
        assert self.spring is not None
        touch = gaps.closest(self.obstacle, state)
        penetration = self.spring.surface - touch.gap
        normal, tangential = self.spring.forces(penetration)
        self.spring.course.rows.append((state.time, normal, tangential, penetration, *touch.velocity))
        return normal

    def record(self, gaps: Gaps, last: State, outcome: str) -> ContactRecord | None:
        """Return the contact record; None for a contact that took no time."""
        first = self.start
        if first is None or last.time <= first.time:
            return None
        normal, tangential, work_n, work_t = self.sums
        course = None if self.spring is None else self.spring.course
        before, after = (gaps.closest(self.obstacle, state).velocity for state in (first, last))
        compression = self.sums if course is None or course.compression is None else course.compression
        return ContactRecord(
            obstacle=self.obstacle.name,
            law="sustained" if course is None else self.obstacle.law.name,
            outcome=str(outcome),
            time=first.time,
            duration=last.time - first.time,
            impulse=(normal, tangential),
            compressive_impulse=None if course is None else (compression[0], compression[1]),
            compressive_work=(compression[2], compression[3]),
            restitutive_work=None if course is None else (work_n - compression[2], work_t - compression[3]),
            velocity_before=before if course else (0.0, before[1]),
            velocity_after=after if course else (0.0, after[1]),
            angles=first.angles,
            rates_before=first.rates,
            rates_after=last.rates,
            phases=() if course is None else course.phase_names(normal, jams=outcome == Outcome.JAM),
            history=None if self.spring is None else self.spring.history(),
        )
