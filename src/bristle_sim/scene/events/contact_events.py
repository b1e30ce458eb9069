"""Event functions of sustained contacts: what changes or ends them, and states within an interval in touch."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from bristle_sim.scene.contact.forces import ContactForces
from bristle_sim.scene.contact.gaps import Gaps
from bristle_sim.scene.contact.obstacles import Obstacle
from bristle_sim.scene.contact.sustained import Sustained, SustainedContacts
from bristle_sim.scene.contact.wire_joints import neighbour
from bristle_sim.scene.events.functions import (
    Change,
    EventFunction,
    HandOver,
    Release,
    Slip,
    Touch,
    freedom,
    in_flight,
    retraction,
)
from bristle_sim.scene.events.search import interpolate
from bristle_sim.scene.integrate.stepping import Advance
from bristle_sim.scene.mechanism import State
from bristle_sim.stop_reason import StopReason

if TYPE_CHECKING:
    from bristle_sim.scene.progress import Progress


SHORTEST_SAMPLED = 2e-3
"""Intervals shorter than this, in the scene's time units, are left to the cubic: its error falls with their third power."""

BEYOND = 1.02
"""Multiple of the time until a force is expected to vanish that the next interval takes: the release is within it then."""

CUBIC = 0.1
"""Error of the cubic's rate, as a fraction of the requested one, above which the middle alone is not enough."""

LEAST_GRIP = 1e-3
"""With less, the force that keeps a contact closed grows beyond bounds: a jam."""


def until_release(sustained: Sequence[Sustained]) -> float:
    """Return the length of an interval in which the first force vanishes, as far as the last interval tells."""
    return BEYOND * min((each.vanishes_in for each in sustained), default=math.inf)


def in_touch(gaps: Gaps, contact: Sustained, state: State) -> list[EventFunction]:
    """Return functions of the state that have kinks of a sustained contact for zeros: it passes a corner, its slip turns."""
    obstacle = contact.obstacle

    def kink(index: int, at: Advance) -> float:
        return gaps.touch(obstacle, at.state).kinks[index]

    def slip(sense: int, at: Advance) -> float:
        return sense * gaps.touch(obstacle, at.state).velocity[1]

    where = _label(obstacle)
    functions = [
        EventFunction(f"corner {index} of {where}", partial(kink, index))
        for index in range(len(gaps.touch(obstacle, state).kinks))
    ]
    if obstacle.friction and contact.slip is None:
        functions.append(EventFunction(f"slip of {where}", partial(slip, 1)))
    elif contact.slip:
        # Geometry and hub alone tell how a single link slips: it turns back where several may stick.
        turns = partial(Slip, obstacle, 0 if len(state.angles) > 1 else -contact.slip)
        functions.append(EventFunction(f"slip of {where}", partial(slip, contact.slip), falling=True, act=turns))
    return functions


def extremes(progress: Progress, sustained: Sequence[Sustained]) -> list[EventFunction]:
    """Return extremes of the motion relative to the hub, and kinks of sustained contact."""
    if not sustained:
        return in_flight(progress.scene)
    kinks = [function for each in sustained for function in in_touch(progress.gaps, each, progress.state)]
    return [*retraction(progress.mechanism), *kinks]


def limits(progress: Progress) -> list[EventFunction]:
    """Return the event functions of the retraction limit, if there is one, and of tips that come out of dents."""
    limit = progress.plan.retraction_limit
    found = freedom(progress.mechanism, limit, progress.state) if math.isfinite(limit) else []
    return found + [_out_of_dent(progress, number) for number in progress.dents()]


def _out_of_dent(progress: Progress, number: int) -> EventFunction:
    """Watch a tip come out of the dent that a contact resolved in time has left it in."""
    outside = progress.scene.effects.obstacles[number]

    def gap(at: Advance) -> float:
        return progress.gaps.gap(outside, at.state)

    return EventFunction(f"dent {number}", gap, falling=False, act=lambda: progress.leave_dent(number))


def sustained_contact_events(progress: Progress, contacts: SustainedContacts) -> list[EventFunction]:
    """Return the event functions that end or change sustained contacts: no force, slip that begins, a jam, another link or piece."""
    found = []
    for index, obstacle in enumerate(contacts.obstacles):
        found += [locking(contacts, progress.gaps, index), _parting(contacts.forces, index)]
        if progress.mechanism.links[obstacle.link].knees:
            found.append(elbow(contacts, progress.gaps, index))
        if len(progress.mechanism.links) > 1:
            found += _hand_overs(progress, obstacle)
            found += [_sticking(contacts.forces, index)] if contacts.slips[index] == 0 else []
    return found


def locking(contacts: SustainedContacts, gaps: Gaps, index: int) -> EventFunction:
    """Watch the grip get too small: friction locks the link, or without it the link meets the obstacle end-on."""
    obstacle = contacts.obstacles[index]
    jams = obstacle.friction > 0.0
    final = StopReason.JAM if jams else StopReason.NO_GRIP

    def spare(at: Advance) -> float:
        return contacts.grip(gaps, at.state, index) - LEAST_GRIP

    wire = obstacle.link % len(gaps.mechanism.links) // gaps.mechanism.wire_links
    event = "jam" if jams else None
    return EventFunction(f"locking of {_label(obstacle)}", spare, True, event, final=final, wire=wire)


def elbow(contacts: SustainedContacts, gaps: Gaps, index: int) -> EventFunction:
    """Watch another piece of a bent link meet the obstacle that this one is on: it takes over by an impact."""
    obstacle = contacts.obstacles[index]

    def beside(at: Advance) -> float:
        return obstacle.gap_beside(gaps.poses(at.state)[obstacle.link], contacts.pieces[index] or 0)

    return EventFunction(f"other piece of {_label(obstacle)}", beside, falling=True, act=partial(Touch, obstacle))


def _hand_overs(progress: Progress, obstacle: Obstacle) -> list[EventFunction]:
    """Watch the contact slide over a joint onto a neighbouring link."""
    gaps, found = progress.gaps, []

    def before(at: Advance) -> float:
        return obstacle.foot(gaps.poses(at.state)[obstacle.link])[0]

    def after(following: Obstacle, at: Advance) -> float:
        poses = gaps.poses(at.state)
        return min(obstacle.foot(poses[obstacle.link])[1], following.foot(poses[following.link])[0])

    def act(following: Obstacle) -> Change:
        return HandOver(obstacle, following)

    where = _label(obstacle)
    if (lower := neighbour(progress, obstacle, -1)) is not None:
        found.append(EventFunction(f"start of {where}", before, falling=True, act=partial(act, lower)))
    if (upper := neighbour(progress, obstacle, 1)) is not None:
        found.append(EventFunction(f"end of {where}", partial(after, upper), falling=False, act=partial(act, upper)))
    return found


def _parting(forces: ContactForces, index: int) -> EventFunction:
    """Watch the normal force fall to zero: the link leaves the obstacle."""
    obstacle = forces.obstacles[index]

    def push(at: Advance) -> float:
        return forces.normal(at.totals)[index] if at.totals else math.nan

    return EventFunction(f"force of {_label(obstacle)}", push, True, act=partial(Release, (obstacle,)), difference=True)


def _sticking(forces: ContactForces, index: int) -> EventFunction:
    """Watch the force of stick reach what friction gives: slip begins."""

    def spare(at: Advance) -> float:
        return forces.spare_friction(at.totals, index) if at.totals else math.nan

    def act() -> Change:
        return Slip(forces.obstacles[index], forces.driven(forces.reached, index))

    return EventFunction(f"stick of {_label(forces.obstacles[index])}", spare, True, act=act, difference=True)


def _label(obstacle: Obstacle) -> str:
    return f"{obstacle.name} at link {obstacle.link}" + ("" if obstacle.partner is None else f" and {obstacle.partner}")


def inner_states(progress: Progress, contacts: SustainedContacts, start: State) -> list[State]:
    """Return states within an interval that has ended: those of a single link in touch follow from the geometry alone."""
    end = progress.state
    length = end.time - start.time
    if length < SHORTEST_SAMPLED or len(start.angles) > 1:
        return []

    def state_at(fraction: float) -> State:
        """Return the state that touches, nearest to the cubic's."""
        return contacts.set_back(progress.gaps, interpolate(start, end, fraction))

    guess, middle = interpolate(start, end, 0.5).angles[-1], state_at(0.5)
    # An error e of the angle that grows from one end and falls to the other is one of 8 e/length in the rate.
    near = 8.0 * abs(middle.angles[-1] - guess) <= CUBIC * progress.plan.accuracy * length * abs(middle.rates[-1])
    return [middle] if near else [state_at(0.25), middle, state_at(0.75)]
