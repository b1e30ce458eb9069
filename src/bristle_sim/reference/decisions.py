"""The consequences of an event: impacts, changes of sustained contacts, and the end of a run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Surface
from bristle_sim.reference.contacts import Point, Touch, Workpart, follows
from bristle_sim.reference.forces import EDGE, Compliant, State, Sustained, acting, closed, solve
from bristle_sim.reference.system import Instant, System
from bristle_sim.theory.contact_spring import (
    ContactSpring,
    check_restitution,
    frictionless_stiffness,
    stiffness_for_duration,
)
from bristle_sim.theory.impact import LEAST_COMPLIANCE, Impact, energetic_impact

# Lowest height of a rebound, as a fraction of hub radius plus wire length. A contact with a lower
# rebound becomes sustained.
LOWEST_REBOUND = 1e-10
# Number of impacts of a single wire within the time ``AT_ONCE`` at which the wire counts as jammed.
MOST_AT_ONCE = 64
# Time within which impacts count as simultaneous, times the highest angular frequency, rad.
AT_ONCE = 1e-10


def close_contact(system: System, name: str, piece: int, state: State) -> State:
    """Record a touch, resolve its impact, and determine which contacts last.

    Args:
        system: the wires and their contacts.
        name: name of the obstacle that is touched.
        piece: index of the straight piece or of the pair of wires. The bar can touch a piece on its
            flank or at either end.
        state: state at the touch.

    Returns:
        The state after the impact, and after further impacts that it causes.
    """
    new = Point(name, piece, name == "workpart")
    if name == "bar":
        foot = float(system.at(state).feet[piece])
        new = Point(name, piece, foot >= system.chain.pieces.lengths[piece])
        if foot <= 0.0 and follows(system.chain, piece):
            new = Point(name, piece - 1, True)
    system.log.touched(new, state.time)
    return decide(system, state, new)


def decide(
    system: System, state: State, new: Point | None = None, stopped: Compliant | None = None
) -> State:
    """Resolve impacts at the closed contacts, then determine which contacts stay closed.

    Args:
        system: the wires and their contacts.
        state: the state at the event.
        new: point of a contact that begins in this state; None if no contact begins.
        stopped: contact in which the foot of the tangential spring, its end at the obstacle, has
            just stopped; None if there is no such contact.

    Returns:
        The state after the impacts.

    Raises:
        Finished: if the wires jam or the event that ends the run has occurred.
    """
    begun = [] if new is None or new in system.rigid else [_begun(system, state, new)]
    touching = [*system.sustained, *begun]
    points = [each.point for each in touching if not isinstance(each, Compliant)]
    while points:  # the fastest approach first; an impact may cause another one
        instant = system.at(state)
        approaches = [instant.touch(point).velocity[0] for point in points]
        if min(approaches) >= -system.still(state):
            break
        state = _hit(system, state, points[int(np.argmin(approaches))])
    state = _low_rebounds_stopped(system, state, points)
    instant = system.at(state)
    still = system.still(state)
    resting = []
    for each in touching:
        touch = instant.touch(each.point)
        if isinstance(each, Compliant):
            if each.law.compliance and each is not stopped:
                _set_foot(each, touch, system.slip_rounding(state))
        elif abs(touch.velocity[0]) > still:
            continue
        elif each in begun:
            each.since = state
            each.velocity_before = np.array([0.0, touch.velocity[1]])
        resting.append(each)
    kept = acting(instant.mass, instant.forces, instant.acting(resting), still)
    if kept is None:
        raise system.log.jam(state)
    for number, slip in kept.items():
        resting[number].slip = slip
    staying = [resting[number] for number in kept]
    # A contact that begins with a rebound has no release.
    lasted = dict.fromkeys([*system.sustained, *resting])
    ending = [each for each in lasted if each not in staying]
    system.sustained = staying
    record(system, state, ending, "release" if new is None else new.obstacle)
    system.check_stop(state)
    for each in ending:
        if not any(system.same_contact(each.point, other.point) for other in staying):
            system.log.released(each.point, state.time)
    system.check_stop(state)
    return system.closed(state)


def _begun(system: System, state: State, point: Point) -> Sustained:
    """Return the sustained contact, compliant or rigid, that begins at a point of a wire."""
    instant = system.at(state)
    obstacle = system.obstacles[point.obstacle]
    surface = obstacle.surface
    touch = instant.touch(point)
    known = (point, surface, state, touch.velocity)
    stiffness = _stiffness(instant, touch, surface) if isinstance(obstacle, Workpart) else None
    if stiffness is None:
        return Sustained(*known)
    # A stiffer tangential spring is taken as rigid in a contact in time; the impact law uses a mean
    # instead.
    compliance = obstacle.compliance if obstacle.compliance >= LEAST_COMPLIANCE else 0.0
    law = ContactSpring(
        stiffness,
        surface.restitution,
        surface.friction,
        surface.friction_in_restitution,
        compliance,
    )
    return Compliant(*known, law=law, level=touch.gap, anchor=touch.along)


def _stiffness(instant: Instant, touch: Touch, surface: Surface) -> float | None:
    """Return the stiffness of contacts with the workpart (N/m), or None if the contacts are rigid.

    At the first contact of any wire the stiffness is computed from the requested duration of that
    contact. All later contacts have the same stiffness. For a wire of one link the impact law
    relates duration and stiffness. For a wire of several links friction is neglected, and the
    hinges are treated as rigid.
    """
    system = instant.system
    chain = system.chain
    duration = system.duration
    if duration is None or system.stiffness is not None:
        return system.stiffness
    check_restitution(surface.restitution)
    if chain.links > chain.wires:
        straight = chain.mass_matrix(np.ones(chain.links, dtype=complex))
        inertia = float(straight.sum()) / chain.wires
        lever = float(touch.rows[0].sum())  # normal velocity per angular velocity of a stiff wire
        system.stiffness = frictionless_stiffness(lever**2 / inertia, surface.restitution, duration)
    else:
        hit, _ = _impact(instant, touch, surface)
        approach = float(touch.velocity[0])
        system.stiffness = stiffness_for_duration(hit, approach, surface.restitution, duration)
    return system.stiffness


def _impact(
    instant: Instant,
    touch: Touch,
    surface: Surface,
    compliance: float = 0.0,
    *,
    plastic: bool = False,
) -> tuple[Impact, Array]:
    """Resolve an impact by the energetic law, and return its effect on all links.

    A plastic impact has no restitution.

    Returns:
        The impact; and the change of the links' angular velocities (rad/s) per unit normal and per
        unit tangential impulse, shape (links, 2).
    """
    response = solve(instant.mass, touch.rows.T)
    inverse_mass = 0.5 * (touch.rows @ response + response.T @ touch.rows.T)
    restitution = 0.0 if plastic else surface.restitution
    coefficients = surface.friction, restitution, surface.friction_in_restitution
    hit = energetic_impact(
        inverse_mass, touch.velocity, *coefficients, tangential_compliance=compliance
    )
    return hit, response


def _set_foot(each: Compliant, touch: Touch, rounding: float) -> None:
    """Determine whether the foot of a tangential spring sticks or slides, and the sense of slip.

    The foot is the end of the spring at the obstacle. A sticking foot is moved so far that the
    spring's force does not exceed the friction limit. ``rounding`` is the rounding error of a slip
    velocity, m/s.
    """
    mu = each.friction
    most = mu * max(each.force(touch.gap), 0.0)
    pull = min(max(each.rub(touch) or 0.0, -most), most)
    sense = int(-np.sign(pull) or np.sign(touch.velocity[1]))
    if not mu or (abs(pull) >= (1.0 - EDGE) * most and each.foot(touch, sense) > rounding):
        each.slip = sense or 1
    else:
        each.anchor = each.law.foot(touch.along, pull)
        each.slip = 0


def record(system: System, state: State, ending: Iterable[Sustained], outcome: str) -> None:
    """Record sustained contacts that end at a state.

    A contact of zero duration is not recorded. ``outcome`` is the reason why the contacts end.
    """
    instant = system.at(state)
    for each in ending:
        velocity = instant.touch(each.point).velocity
        law = "compliant"
        if not isinstance(each, Compliant):
            velocity = velocity * [0.0, 1.0]
            law = "sustained"
        if state.time > each.since.time:
            system.log.contact(each, state, velocity, law=law, outcome=outcome)


def end_compression(system: System, each: Compliant, state: State) -> State:
    """End the compression of a compliant contact and begin its restitution.

    If the coefficient of restitution is 0, the contact ends with its compression.
    """
    each.compression = each.sums
    if not each.law.restitution:
        return end_compliant_contact(system, each, state)
    return change_phase(system, each, each.level - system.at(state).touch(each.point).gap, state)


def change_phase(system: System, each: Compliant, deepest: float | None, state: State) -> State:
    """Change the normal spring of a contact from loading to unloading or back.

    The tangential force stays the same unless it exceeds the new friction limit. ``deepest`` is the
    penetration (m) from which the spring unloads; None if the spring is loaded from now on.
    """
    _hold_foot(system, each, state)
    each.law = replace(each.law, deepest=deepest)
    return decide(system, state)


def stop_foot(system: System, each: Compliant, state: State) -> State:
    """Let the foot of a tangential spring stick at the instant at which its slip velocity is zero.

    The sign of the computed slip velocity is only rounding error at this instant, so it must not be
    taken for reversed slip.
    """
    _hold_foot(system, each, state)
    return decide(system, state, stopped=each)


def _hold_foot(system: System, each: Compliant, state: State) -> None:
    """Let a tangential spring's sliding foot stick where the spring keeps its present force."""
    touch = system.at(state).touch(each.point)
    pull = each.rub(touch)
    if each.slip and pull is not None:
        each.anchor = each.law.foot(touch.along, pull)
        each.slip = 0


def end_compliant_contact(system: System, each: Compliant, state: State) -> State:
    """Record a compliant contact whose force has fallen to zero, and remove it from the system.

    The gap at this instant is stored as the dent, the indentation that the contact leaves in the
    workpart.
    """
    touch = system.at(state).touch(each.point)
    parts = each.law.restitution > 0.0 or touch.velocity[0] > system.still(state)
    record(system, state, [each], "rebound" if parts else "no rebound")
    system.sustained.remove(each)
    system.dents[each.point.piece] = touch.gap
    system.log.released(each.point, state.time)
    system.check_stop(state)
    return state


def _hit(system: System, state: State, point: Point) -> State:
    """Resolve and record one impact by the energetic law, and return the state after it."""
    log = system.log
    instant = system.at(state)
    obstacle = system.obstacles[point.obstacle]
    touch = instant.touch(point)
    for plastic in (False, True):
        hit, response = _impact(
            instant, touch, obstacle.surface, obstacle.compliance, plastic=plastic
        )
        impulse = np.array([hit.impulse_normal, hit.impulse_tangential], dtype=float)
        after = state._replace(rates=state.rates + response @ impulse)
        if hit.outcome_name != "rebound" or not _hardly_rebounds(system, after, point):
            break
    works = np.add(hit.compressive_work, hit.restitutive_work)
    compressive = (hit.compressive_impulse_normal, hit.compressive_impulse_tangential)
    contact = Sustained(
        point,
        obstacle.surface,
        state,
        touch.velocity,
        sums=np.append(impulse, works),
        compression=np.array([*compressive, *hit.compressive_work], dtype=float),
    )
    velocity = np.array([hit.velocity_normal, hit.velocity_tangential], dtype=float)
    outcome = hit.outcome_name
    log.contact(contact, after, velocity, law="energetic", outcome=outcome, phases=hit.phases)
    log.impacts.append((state, point))
    most = MOST_AT_ONCE * len(log.records) ** 2  # wires in a row pass on impacts to each other
    recent = log.impacts[-most:]
    moment = AT_ONCE / max(system.fastest, float(np.abs(after.rates).max()))
    if hit.outcome_name == "jam":
        raise log.jam(after)
    before, first = recent[0]
    if len(recent) == most and state.time - before.time < moment:
        # The impacts at wedged links have no end, so their impulses have no sum.
        log.forget_impacts(before.time, first)
        raise log.jam(before._replace(time=state.time))
    return after


def _low_rebounds_stopped(system: System, state: State, points: Sequence[Point]) -> State:
    """Return the state with zero normal velocity at points that hardly rebound.

    An impact at a different point has given them a small velocity away from the obstacle.
    """
    instant = system.at(state)
    low = [instant.touch(point) for point in points if _hardly_rebounds(system, state, point)]
    return state._replace(rates=state.rates + closed(instant.mass, low)[1]) if low else state


def _hardly_rebounds(system: System, state: State, point: Point) -> bool:
    """Return whether a contact point parts, but rises to no more than ``LOWEST_REBOUND``.

    It then counts as being at rest. Otherwise a wire that comes to rest would rebound infinitely
    often.
    """
    instant = system.at(state)
    touch = instant.touch(point)
    falling = float(touch.rows[0] @ solve(instant.mass, instant.forces)) + touch.bias[0]
    parting = float(touch.velocity[0])
    lowest = -2.0 * falling * LOWEST_REBOUND * system.size
    return bool(falling < 0.0 < parting and parting**2 < lowest)
