"""A contact that lasts, rigid or with a spring: its impulse, its work and its record."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

from bristle_sim.scene.gaps import Gaps
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.pairs import ClosedPair
from bristle_sim.trajectory import ContactRecord


class Sums(NamedTuple):
    """Forces of one contact on its link at the end of an interval, and the forces' impulse and work
    in the interval; engine units.

    Attributes:
        normal: normal force.
        tangential: tangential force; in stick, the force that friction would have to supply.
        impulse_normal: impulse of the normal force.
        impulse_tangential: impulse of the tangential force.
        work_normal: work of the normal force.
        work_tangential: work of the tangential force.
        tangential_at_start: tangential force of a contact with a spring in stick, at the beginning
            of the interval; otherwise 0.
    """

    normal: float = 0.0
    tangential: float = 0.0
    impulse_normal: float = 0.0
    impulse_tangential: float = 0.0
    work_normal: float = 0.0
    work_tangential: float = 0.0
    tangential_at_start: float = 0.0


# count of values of one contact in the flat list that an integrator extrapolates
NUMBERS = len(Sums._fields)


def sums_of(totals: Sequence[float], index: int) -> Sums:
    """Return one contact's forces, impulses and work from the flat list of all contacts' values."""
    return Sums(*totals[NUMBERS * index : NUMBERS * (index + 1)])


class Outcome(StrEnum):
    """The ways in which a contact can end.

    The record of a sustained contact may instead name the obstacle whose impact ended the contact,
    or the reason why the simulation stopped.
    """

    REBOUND = "rebound"
    NO_REBOUND = "no rebound"
    STICTION = "stiction"
    JAM = "jam"
    RELEASE = "release"


@dataclass(slots=True, eq=False)
class ActiveContact(ClosedPair):
    """A contact that lasts, with its impulse and work so far.

    Objects of this class itself are rigid contacts; ``SpringContact`` is the subclass of contacts
    with springs. In a rigid contact friction opposes ``slip``.

    Attributes:
        start: state at which the contact began; None until it has begun.
        impulse: normal and tangential impulse since the start.
        work: work of the normal and of the tangential force since the start.
        force: normal force at the end of the last interval; None before the first interval.
        tangential: tangential force at the end of the last interval.
        stopped: sense of the slip that has just stopped, 1 or -1; 0 if no slip has just stopped.
    """

    start: State | None = None
    impulse: tuple[float, float] = (0.0, 0.0)
    work: tuple[float, float] = (0.0, 0.0)
    force: float | None = None
    tangential: float = 0.0
    stopped: int = 0

    def turn(self, sense: int) -> None:
        """Let the contact slip in a given sense, 1 or -1, from now on; 0 lets it stick."""
        self.stopped = (self.slip or 0) if sense == 0 else 0
        self.slip = sense

    def add(self, sums: Sums) -> None:
        """Add the impulse and the work of an interval."""
        self.impulse = (
            self.impulse[0] + sums.impulse_normal,
            self.impulse[1] + sums.impulse_tangential,
        )
        self.work = (self.work[0] + sums.work_normal, self.work[1] + sums.work_tangential)

    def expect_release(self, sums: Sums, length: float) -> tuple[float, float, float]:
        """Estimate when the normal force of a rigid contact reaches zero.

        The force is extrapolated by a parabola over time. The parabola matches the forces at both
        ends of the interval, and the impulse of the interval.

        Returns:
            The normal force at the interval's beginning; the coefficient of the parabola's quadratic
                term, with the time as a fraction of the interval; and the time from the interval's
                end until the force reaches zero.
        """
        last = first = sums.normal
        bend = 0.0
        left = math.inf
        if length > 0.0:
            mean = sums.impulse_normal / length
            first = 2.0 * mean - last if self.force is None else self.force
            bend = 3.0 * (first + last) - 6.0 * mean
            slope = last - first + bend
            square = slope * slope - 4.0 * bend * last
            falls = math.sqrt(square) - slope if square >= 0.0 else 0.0
            left = 2.0 * length * last / falls if falls > 0.0 else math.inf
        self.force = last
        self.tangential = sums.tangential
        return first, bend, left

    def record(self, gaps: Gaps, last: State, outcome: str) -> ContactRecord | None:
        """Return the contact record; None for a contact of zero duration."""
        first = self.start
        if first is None or last.time <= first.time:
            return None
        before, after = (gaps.closest(self.pair, state).velocity for state in (first, last))
        return ContactRecord(
            obstacle=self.pair.name,
            law="sustained",
            outcome=str(outcome),
            time=first.time,
            duration=last.time - first.time,
            impulse=self.impulse,
            compressive_impulse=None,
            compressive_work=self.work,
            restitutive_work=None,
            velocity_before=(0.0, before[1]),
            velocity_after=(0.0, after[1]),
            angles=first.angles,
            rates_before=first.rates,
            rates_after=last.rates,
        )
