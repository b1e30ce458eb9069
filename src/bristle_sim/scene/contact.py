"""Sustained contacts with their impulse, work and record, and the forces of rigid contacts.

The solver of the joints keeps rigid contacts closed. A single link has one degree of freedom, so a
contact determines its motion, which then follows from the geometry and the hub's motion alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from operator import mul
from typing import NamedTuple

from bristle_sim.scene.build import Scene
from bristle_sim.scene.impacts import contact_at
from bristle_sim.scene.mechanism import State, cross
from bristle_sim.scene.pairs import ClosedPair, Closest
from bristle_sim.trajectory import ContactRecord

LEAST_SLIP = 1e-9
"""Slip velocity, in scene units, up to which its sign is attributed to rounding error."""

LEAST_ACCELERATION = 1e-7
"""Slip acceleration, in scene units, up to which its sign is attributed to rounding error of the
difference quotient over the time ``MOMENT``."""

MOMENT = 1e-6
"""Time step of a difference quotient, in engine units: the slip acceleration follows from the slip
velocities now and after this time. Where two straight segments of a link touch at a corner, the
contact belongs to the segment that is closer after this time."""


class Sums(NamedTuple):
    """Forces, impulses and work of one contact on its link in an interval; engine units.

    Unknown values are NaN.

    Attributes:
        normal: normal force at the end of the interval.
        tangential: tangential force at the end of the interval. In stick it is the force that would
            be required to prevent slip, which may exceed the friction limit.
        impulse_normal: impulse of the normal force in the interval.
        impulse_tangential: impulse of the tangential force in the interval.
        work_normal: work of the normal force in the interval.
        work_tangential: work of the tangential force in the interval.
        tangential_at_start: tangential force of a contact with springs at the beginning of the
            interval; 0 for a rigid contact.
    """

    normal: float = math.nan
    tangential: float = math.nan
    impulse_normal: float = math.nan
    impulse_tangential: float = math.nan
    work_normal: float = math.nan
    work_tangential: float = math.nan
    tangential_at_start: float = math.nan


# number of values of one contact in the flat list that an integrator extrapolates
NUMBERS = len(Sums._fields)


def sums_of(totals: Sequence[float], index: int) -> Sums:
    """Return one contact's forces, impulses and work from the list ``totals`` of all contacts."""
    return Sums(*totals[NUMBERS * index : NUMBERS * (index + 1)])


def force_within(part: float, first: float, last: float, mean: float) -> float:
    """Return a force at the fraction ``part`` of an interval, from its two end values and its mean.

    The three determine the parabola F = F_0 + s (F_1 - F_0) - s (1 - s) (3 (F_0 + F_1) - 6 F_m).
    """
    return first + part * (last - first) - part * (1.0 - part) * (3.0 * (first + last) - 6.0 * mean)


def forces_within(
    first: Sequence[float], last: Sequence[float], length: float, part: float
) -> tuple[float, ...]:
    """Return the forces of all contacts at the fraction ``part`` of an interval, in order as ``Sums``.

    ``first`` and ``last`` are the totals at the interval's two ends. The result is empty if those
    at the beginning are unknown.
    """
    found = list[float]()
    for index in range(len(first) // NUMBERS):
        a, b = sums_of(first, index), sums_of(last, index)
        means = (b.impulse_normal / length, b.impulse_tangential / length)
        normal = force_within(part, a.normal, b.normal, means[0])
        found += Sums(normal, force_within(part, a.tangential, b.tangential, means[1]))
    return tuple(found)


class Outcome(StrEnum):
    """The ways in which a contact can end.

    A contact record may instead state another outcome: the obstacle with which an impact ended the
    contact, or the reason why the simulation stopped.
    """

    REBOUND = "rebound"
    NO_REBOUND = "no rebound"
    STICTION = "stiction"
    JAM = "jam"
    RELEASE = "release"


@dataclass(slots=True, eq=False)
class ActiveContact(ClosedPair):
    """A sustained contact, with its impulse and work so far.

    The class describes a rigid contact, in which friction opposes ``slip``. Its subclass
    ``SpringContact`` describes a contact with springs.

    Attributes:
        start: state at which the contact began; None until it has begun.
        impulse: normal and tangential impulse since the start.
        work: work of the normal and of the tangential force since the start.
        force: normal force at the end of the last interval; None before the first interval.
        tangential: tangential force at the end of the last interval.
    """

    start: State | None = None
    impulse: tuple[float, float] = (0.0, 0.0)
    work: tuple[float, float] = (0.0, 0.0)
    force: float | None = None
    tangential: float = 0.0

    def add(self, sums: Sums) -> None:
        """Add the impulse and the work of an interval, and store the forces at its end."""
        self.force = sums.normal
        self.tangential = sums.tangential
        self.impulse = (
            self.impulse[0] + sums.impulse_normal,
            self.impulse[1] + sums.impulse_tangential,
        )
        self.work = (self.work[0] + sums.work_normal, self.work[1] + sums.work_tangential)

    def expect_release(self, sums: Sums, length: float) -> tuple[float, float]:
        """Estimate when the normal force of a rigid contact reaches zero.

        The force is extrapolated by the parabola that agrees with the forces at both ends of the
        interval, and with the impulse of the interval.

        Args:
            sums: forces, impulses and work of the interval.
            length: duration of the interval.

        Returns:
            The normal force at the interval's beginning.
            The time from the interval's end until the force reaches zero; infinite if it does not.
        """
        last = sums.normal
        mean = sums.impulse_normal / length
        first = 2.0 * mean - last if self.force is None else self.force
        bend = 3.0 * (first + last) - 6.0 * mean
        slope = last - first + bend
        square = slope * slope - 4.0 * bend * last
        falls = math.sqrt(square) - slope if square >= 0.0 else 0.0
        return first, 2.0 * length * last / falls if falls > 0.0 else math.inf

    def record(self, closest: Closest, last: State, outcome: str) -> ContactRecord | None:
        """Return the contact record; None for a contact of zero duration.

        Args:
            closest: function that returns the closest approach of a pair in a state.
            last: state at which the contact ends.
            outcome: outcome that the record states.
        """
        first = self.start
        if first is None or last.time <= first.time:
            return None
        before, after = (closest(self.pair, state).velocity for state in (first, last))
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


class RigidContacts:
    """The rigid contacts of a smooth motion.

    Their forces are solved for simultaneously with the joint forces. The motion ends when the
    normal force of a contact reaches zero.

    Attributes:
        scene: the scene.
        closed: the contacts. Each has a sense of slip, which friction opposes and which is constant
            until the next event. The sense is None in two cases: the contact has no friction, or
            the wire is a single rigid link and this link is at rest.
    """

    def __init__(self, scene: Scene, closed: Sequence[ClosedPair]) -> None:
        self.scene = scene
        self.closed = closed
        self._solver = scene.joint_solver

    def engage(self, state: State) -> None:
        """Keep the contacts closed in all further steps, which start from ``state``.

        If the link touches at a corner of its centre line, also select which of the two segments at
        this corner is in contact.
        """
        mechanism = self.scene.mechanism
        for contact in self.closed:
            pair = contact.pair
            if pair.partner is None and len(mechanism.links[pair.link].corners) > 2:
                # At a corner two segments touch. The motion in the time MOMENT selects one.
                later = state.moved(MOMENT, [0.0] * len(state.rates))
                contact.piece = pair.closest(mechanism.poses(later), later.rates).piece
        self.scene.keep_closed(self.closed)

    def totals(self, step: float, *, symmetric: bool = False) -> list[float]:
        """Return the forces, impulses and work of all contacts in one list, ordered as in ``Sums``.

        The normal force is that in the last step. If a contact would have had to pull in some of
        the steps, its normal force is that in the last of these steps.

        Args:
            step: length of a step.
            symmetric: whether the steps are symmetric in time. Each force is then the mean of two
                successive steps, in which their opposite errors cancel.
        """
        found = list[float]()
        for each in zip(*self._solver.impulses, strict=True):
            pushes, rubs, slips = zip(*each, strict=True)
            normal: Sequence[float] = pushes
            tangential = rubs[-1]
            if symmetric:
                normal = [0.5 * sum(pair) for pair in zip(pushes[::2], pushes[1::2], strict=True)]
                tangential = 0.5 * (rubs[-2] + tangential)
            last = ([push for push in normal if push < 0.0] or normal)[-1]
            work = sum(map(mul, rubs, slips))
            found += [last / step, tangential / step, sum(pushes), sum(rubs), 0.0, work, 0.0]
        return found

    def fails(self, totals: Sequence[float]) -> bool:
        """Return whether any contact would have to pull to stay closed.

        ``totals`` is a list as the method ``totals`` returns it.
        """
        return min(totals[: NUMBERS * len(self.closed) : NUMBERS]) <= 0.0

    def spare_friction(self, totals: Sequence[float], index: int) -> float:
        """Return the friction limit of a contact minus the magnitude of its tangential force.

        ``totals`` is a list as the method ``totals`` returns it, ``index`` the index of the contact
        in ``closed``.
        """
        sums = sums_of(totals, index)
        return self.closed[index].pair.friction * sums.normal - abs(sums.tangential)

    def compliance_in_slip(self, state: State, index: int) -> float:
        """Return the relative compliance of a contact in slip, dimensionless.

        A unit normal impulse and its friction change the normal velocity. The relative compliance
        is this change, divided by the change that the normal impulse would cause without joints and
        friction. If it is not positive, friction or geometry locks the link: no force keeps the
        contact closed.

        ``index`` is the index of the contact in ``closed``.
        """
        contact = self.closed[index]
        pair = contact.pair
        mechanism = self.scene.mechanism
        poses = mechanism.poses(state)
        point = contact_at(mechanism, state, pair)
        touch = point.touch
        normal, coupling = point.inverse_mass[0]
        free = 0.0
        for number, arm in ((pair.link, touch.arm), (pair.partner, touch.partner_arm)):
            if number is not None and arm is not None:
                link = mechanism.links[number]
                lever = cross(arm - poses[number].to_centre, touch.normal)
                free += 1.0 / link.mass + lever**2 / link.inertia
        return (normal - pair.friction * (contact.slip or 0) * coupling) / free

    def prescribes_slip(self, contact: ClosedPair) -> bool:
        """Return whether the geometry alone determines the slip velocity of a contact.

        The geometry does so if the links from the wire's root to the contact are subject to at
        least as many conditions as there are such links. A closed gap is one condition, and stick
        of another contact is a further one. A contact with this property cannot stick while the hub
        moves it along its obstacle, however small the tangential force is.
        """
        if contact.pair.partner is not None:
            return False
        mechanism = self.scene.mechanism
        count = len(mechanism.links)
        last = contact.pair.link % count
        first = last - last % mechanism.wire_links
        conditions = sum(
            2 if other.slip == 0 and other is not contact else 1
            for other in self.closed
            if other.pair.partner is None and first <= other.pair.link % count <= last
        )
        return conditions > last - first

    def set_slip(self, state: State, contact: ClosedPair, error: float) -> None:
        """Set the sense of slip of a new contact, which friction opposes.

        The sense is the sign of the slip velocity if that velocity exceeds its error. Otherwise, if
        the geometry determines the slip, the sense is the sign of the contact point's tangential
        acceleration. If this acceleration is zero too, the link is at rest, and the sense stays
        unknown. Any other contact sticks until its tangential force exceeds the friction limit.

        Args:
            state: the state at the touch.
            contact: the contact, which must be closed already.
            error: possible error of the slip velocity, in scene units.
        """
        prescribed = self.prescribes_slip(contact)
        poses = self.scene.mechanism.poses(state)
        slip = contact.pair.closest(poses, state.rates).velocity[1]
        least = max(LEAST_SLIP, error)
        if abs(slip) <= least and prescribed:
            slip = self.slip_acceleration(contact, state)
            least = LEAST_ACCELERATION
        if abs(slip) > least:
            contact.slip = int(math.copysign(1.0, slip))
        elif not prescribed:
            contact.slip = 0

    def slip_acceleration(self, contact: ClosedPair, state: State) -> float:
        """Return the tangential acceleration (scene units) of a contact point on its obstacle."""
        later = state.moved(MOMENT, [0.0] * len(state.rates))
        before, after = (
            contact.pair.closest(self.scene.mechanism.poses(each), each.rates).velocity[1]
            for each in map(self._solver.set_back, (state, later))
        )
        return (after - before) / MOMENT
