"""The table of events: every function that can end an interval of smooth motion, and the change of contacts that it causes.
Gaps to obstacles that may be touched are searched in :mod:`bristle_sim.scene.events.touches`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from enum import Enum, auto
from functools import lru_cache, partial
from typing import TYPE_CHECKING, NamedTuple

from bristle_sim.scene.build import Scene, damping_rate
from bristle_sim.scene.contact.gaps import neighbour
from bristle_sim.scene.contact.obstacles import BarObstacle, ClosestApproach, Obstacle, dented
from bristle_sim.scene.contact.rigid import TOTALS, RigidContacts
from bristle_sim.scene.contact.spring import SPRING_TOTALS, Spring
from bristle_sim.scene.contact.sustained import Sustained
from bristle_sim.scene.events.locate import EventFunction
from bristle_sim.scene.extrapolation import Advance, lagrange_weights
from bristle_sim.scene.mechanism import State
from bristle_sim.settings import LARGEST_RETRACTION, StopReason

if TYPE_CHECKING:
    from bristle_sim.scene.progress import Progress

LEAST_COMPLIANCE_IN_SLIP = (
    1e-3  # of a free link's; with less, the force that keeps a contact closed grows beyond bounds: a jam
)
LOCATED_VELOCITY = 0.1  # fraction of an interval's error in velocity to which a spring's events are located


class Touch(NamedTuple):
    """A link meets an obstacle; with ``rests`` the impact has no restitution."""

    obstacle: Obstacle
    rests: bool = False


class Release(NamedTuple):
    """Links leave their obstacles; the gaps are still closed."""

    obstacles: tuple[Obstacle, ...]


class HandOver(NamedTuple):
    """A contact slides over a joint, from one link to its neighbour."""

    obstacle: Obstacle
    following: Obstacle


class Slip(NamedTuple):
    """A rigid contact slips in another sense from now on; 0 sticks."""

    contact: Sustained
    sense: int


class Kink(NamedTuple):
    """The motion has a kink: the contact passes a corner of the wire, or the tip leaves a dent (that of the given pair)."""

    dent: int | None = None


class SpringEvent(Enum):
    """The kinds of events of a contact with a spring."""

    COMPRESSION_ENDS = auto()
    UNLOADED = auto()
    PRESSED_ON = auto()
    SLIP_STOPS = auto()
    STICK_BREAKS = auto()
    OVERDUE = auto()


class SpringChange(NamedTuple):
    """A contact with a spring passes into another phase, or ends."""

    contact: Sustained
    event: SpringEvent


Change = Touch | Release | HandOver | Slip | Kink | SpringChange
"""A change of the contacts by an event."""


def motion_events(progress: Progress, sustained: Sequence[Sustained]) -> list[EventFunction]:
    """Return the events of the motion as a whole: extremes, kinks of sustained contact, limits."""
    mechanism, plan, scene, size = progress.mechanism, progress.plan, progress.scene, progress.mechanism.wire_links
    found: list[EventFunction] = []

    def relative_rate(link: int, at: Advance) -> float:
        return at.state.rates[link] - mechanism.hub_speed

    def acceleration_of(link: int, at: Advance) -> float:
        return at.accelerations[link]

    def left(link: int, at: Advance) -> float:
        return plan.retraction_limit - abs(at.state.angles[link] - mechanism.root_angle(link, at.state.time))

    for wire in range(mechanism.wires):
        link = wire * size
        if not plan.single_contact:
            found.append(EventFunction(partial(relative_rate, link), False, LARGEST_RETRACTION, wire))
        if not (plan.single_contact or sustained or size > 1):
            # A wire of several links vibrates.
            exact, event = partial(acceleration, scene, link=wire), "highest relative speed"
            value = partial(acceleration_of, wire)
            found.append(EventFunction(value, True, event, wire, exact=exact, difference=True))
        if math.isfinite(plan.retraction_limit):
            final = StopReason.RETRACTION_LIMIT
            found.append(
                EventFunction(partial(left, link), True, "retraction limit", wire, final, turns=True, positive=True)
            )
    for number, obstacle in enumerate(progress.obstacles):
        if obstacle.dent:
            # The tip comes out of the dent that a contact resolved in time has left it in.
            outside = partial(_gap, progress, dented(obstacle, 0.0))
            found.append(EventFunction(outside, False, act=partial(Kink, number), turns=True))
    return found


def _gap(progress: Progress, obstacle: Obstacle, at: Advance) -> float:
    return progress.gaps.gap(obstacle, at.state)


def contact_events(
    progress: Progress, contacts: Sequence[Sustained], rigid: RigidContacts | None
) -> list[EventFunction]:
    """Return the events that change or end contacts: the rigid ones', in the order of ``rigid``, and those of springs."""
    found: list[EventFunction] = []
    ordered = [each for each in contacts if each.spring is None]
    for index, contact in enumerate(ordered):
        assert rigid is not None
        found += _rigid_events(progress, contact, rigid, index)
        if isinstance(contact.obstacle, BarObstacle):
            found += _slides(progress, contact.obstacle, rigid, index)
    springs = [(contact, contact.spring) for contact in contacts if contact.spring is not None]
    for number, (contact, spring) in enumerate(springs):
        found += _spring_events(progress, contact, spring, TOTALS * len(ordered) + SPRING_TOTALS * number)
    return found


def _rigid_events(progress: Progress, contact: Sustained, rigid: RigidContacts, index: int) -> list[EventFunction]:
    """Return the events of a rigid contact: locked slip, zero force, end of stick, reversal of slip, a passed corner.

    With too little compliance friction locks the link, or a frictionless link meets the obstacle end-on.
    """
    obstacle, gaps, reached = rigid.obstacles[index], progress.gaps, [0.0]

    def compliance(at: Advance) -> float:
        return rigid.compliance_in_slip(gaps, at.state, index) - LEAST_COMPLIANCE_IN_SLIP

    def push(at: Advance) -> float:
        return rigid.normal(at.totals)[index] if at.totals else math.nan

    def spare(at: Advance) -> float:
        if not at.totals:
            return math.nan
        reached[0] = at.totals[TOTALS * index + 1]
        return rigid.spare_friction(at.totals, index)

    def slips() -> Slip:
        return Slip(contact, -1 if reached[0] > 0.0 else 1)

    def slip(at: Advance) -> float:
        return (contact.slip or 1) * gaps.closest(obstacle, at.state).velocity[1]

    def kink(number: int, at: Advance) -> float:
        return gaps.closest(obstacle, at.state).kinks[number]

    event, final = ("jam", StopReason.JAM) if obstacle.friction else (None, StopReason.NO_GRIP)
    found = [
        EventFunction(compliance, True, event, progress.wires_of(obstacle)[0], final, positive=True),
        EventFunction(push, True, act=partial(Release, (obstacle,)), difference=True),
    ]
    if contact.slip == 0:
        found.append(EventFunction(spare, True, act=slips, difference=True))
    elif contact.slip:
        # Geometry and hub alone determine how a lone link slips: it turns back where several may stick.
        following = -contact.slip if progress.mechanism.lone else 0
        found.append(EventFunction(slip, True, act=partial(Slip, contact, following)))
    elif obstacle.friction:
        found.append(EventFunction(slip, act=Kink))
    for number in range(len(gaps.closest(obstacle, progress.state).kinks)):
        found.append(EventFunction(partial(kink, number), act=Kink))
    return found


def _slides(progress: Progress, obstacle: BarObstacle, rigid: RigidContacts, index: int) -> list[EventFunction]:
    """Return the events at which a contact slides over a joint, or another piece of a bent link meets the same bar.

    Contact passes to the other piece by an impact.
    """
    gaps, found = progress.gaps, []
    lower, upper = neighbour(progress, obstacle, -1), neighbour(progress, obstacle, 1)

    def beside(at: Advance) -> float:
        return obstacle.gap_beside(gaps.poses(at.state)[obstacle.link], rigid.pieces[index] or 0)

    def before(at: Advance) -> float:
        return obstacle.foot(gaps.poses(at.state)[obstacle.link])[0]

    def after(following: BarObstacle, at: Advance) -> float:
        poses = gaps.poses(at.state)
        return min(obstacle.foot(poses[obstacle.link])[1], following.foot(poses[following.link])[0])

    if progress.mechanism.links[obstacle.link].knees:
        found.append(EventFunction(beside, True, act=partial(Touch, obstacle)))
    if lower is not None:
        found.append(EventFunction(before, True, act=partial(HandOver, obstacle, lower)))
    if upper is not None:
        found.append(EventFunction(partial(after, upper), False, act=partial(HandOver, obstacle, upper)))
    return found


def _spring_events(progress: Progress, contact: Sustained, spring: Spring, first: int) -> list[EventFunction]:
    """Return the events of a spring: compression ends, unloading ends at zero force or by reloading, slip stops or begins.

    The contact's totals begin at the index ``first``. Each function is a velocity, or a penetration over the contact's duration.
    Of two events that end a phase together, each located to the tolerance, the later one may lie just before the other.
    """
    obstacle, gaps, duration = contact.obstacle, progress.gaps, spring.expected.duration
    tolerance = max(LOCATED_VELOCITY * spring.expected.stepper.noise, math.ulp(1.0))

    @lru_cache(maxsize=1)
    def touch(state: State) -> ClosestApproach:
        return gaps.closest(obstacle, state)

    def closing(at: Advance) -> float:
        return -touch(at.state).velocity[0]

    def slip(at: Advance) -> float:
        return spring.slip * spring.foot_speed(touch(at.state).velocity)

    def beyond(level: float, at: Advance) -> float:
        return (spring.surface - touch(at.state).gap - level) / duration

    def spare(at: Advance) -> float:
        if not at.totals:
            return math.nan
        penetration = spring.surface - touch(at.state).gap
        return spring.spare_friction(penetration, at.totals[first + 5]) / (spring.stiffness * duration)

    def event(
        what: SpringEvent, value: Callable[[Advance], float], *, falling: bool = True, together: bool = False
    ) -> EventFunction:
        # A lone link turns back within an interval before its last event only. Several links also do where a tangential spring
        # swings and carries their normal velocity beyond zero and back; else they do not in the rigid-body limit.
        moves = spring.expected.moves
        turns = moves and what is SpringEvent.UNLOADED if progress.mechanism.lone else moves or spring.elastic
        begins = what in (SpringEvent.SLIP_STOPS, SpringEvent.STICK_BREAKS)  # slip in its sense, stick below its limit
        function = EventFunction(
            value, falling, tolerance=tolerance, turns=turns, positive=begins, ends_together=together
        )
        function.act = partial(SpringChange, contact, what)
        return function

    if spring.deepest is None:
        # A tip at rest that its load presses on may still open at first.
        found = [event(SpringEvent.COMPRESSION_ENDS, closing, together=contact.sums[0] > 0.0)]
    else:
        found = [
            event(SpringEvent.UNLOADED, partial(beyond, spring.residual), together=True),
            event(SpringEvent.PRESSED_ON, partial(beyond, spring.deepest), falling=False),
        ]
    if spring.slip:
        found.append(event(SpringEvent.SLIP_STOPS, slip))
    elif spring.compliance_in_stick:
        found.append(event(SpringEvent.STICK_BREAKS, spare))
    return found


LONGEST_PROBE = 0.3
"""Longest step of a probed acceleration, in the scene's time units and time constants of the engine's damping. Measured:
rounding and the error left by extrapolation are then both some 1e-12 times the rate of the damping."""

PROBES = (1, 2, 3, 4, 5, 6, 8, 10, 12)  # its steps are this many times shorter

PROBE_WEIGHTS = lagrange_weights(PROBES)


def acceleration(scene: Scene, state: State, link: int = 0) -> float:
    """Return the acceleration of a link without contact, engine units: that of the second step, extrapolated to zero step."""
    longest, found = LONGEST_PROBE / (1.0 + damping_rate(scene)), []
    for count, weight in zip(PROBES, PROBE_WEIGHTS, strict=True):
        scene.place(state)
        found.append(weight * scene.step(longest / count, 2)[2 * len(scene.links) + link])
    return math.fsum(found)
