"""The consequences of an event: impacts, changes of sustained contacts, and the end of a run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Surface
from bristle_sim.reference.contacts import Point, Spring, Touch, WirePairs, Workpart, follows
from bristle_sim.reference.forces import EDGE, acting, closed
from bristle_sim.reference.log import Log
from bristle_sim.reference.system import Instant, State, Sustained, System
from bristle_sim.theory.contact_spring import ContactSpring
from bristle_sim.theory.contact_stiffness import frictionless_stiffness, stiffness_for_duration
from bristle_sim.theory.impact import LEAST_COMPLIANCE, Impact, energetic_impact

# Lowest height of a rebound, over hub radius plus length; after a lower one the contact is
# sustained.
LOWEST_REBOUND = 1e-10
# Number of impacts of a single wire within ``AT_ONCE`` from which the wire counts as jammed.
MOST_AT_ONCE = 64
# Time within which impacts count as simultaneous, times the fastest rate, rad.
AT_ONCE = 1e-10


def close_contact(system: System, log: Log, name: str, piece: int, state: State) -> State:
    """Record a touch, resolve the impacts that follow, and determine the contacts that last.

    ``name`` is the obstacle, ``piece`` the index of the straight piece, corner or pair of wires.

    Returns:
        The state after the impacts.
    """
    new = _place(system, name, piece, state)
    log.touched(new, state.time)
    return decide(system, log, state, new)


def _place(system: System, name: str, piece: int, state: State) -> Point:
    """Return where a straight piece is touched: on its flank, at its end, or at its start.

    The start of a piece is the corner at the end of the piece before it.
    """
    if isinstance(system.obstacles[name], Workpart):
        return Point(name, system.chain.corners[piece], True)
    if isinstance(system.obstacles[name], WirePairs):
        return Point(name, piece, False)
    foot = float(system.at(state).feet[piece])
    if foot <= 0.0 and follows(system.chain, piece):
        return Point(name, piece - 1, True)
    return Point(name, piece, foot >= system.chain.pieces.lengths[piece])


def decide(system: System, log: Log, state: State, new: Point | None = None) -> State:
    """Resolve impacts among the closed contacts, then determine the contacts that stay closed.

    Returns:
        The state after the impacts.

    Raises:
        Finished: if the run ends here.
    """
    begun = [] if new is None or new in system.rigid else [_begun(system, state, new)]
    touching = sorted([*system.sustained, *begun], key=lambda each: each.spring is not None)
    points = [each.point for each in touching if each.spring is None]
    state = _low_rebounds_stopped(system, _impacts(system, log, state, points), points)
    instant = system.at(state)
    still = system.still(state)
    for each in begun:
        if each.spring is None:
            each.since, each.velocity_before = state, (0.0, instant.touch(each.point).velocity[1])
    resting = [
        each
        for each in touching
        if each.spring or abs(instant.touch(each.point).velocity[0]) <= still
    ]
    for each in resting:
        if each.spring is not None and each.spring.law.compliance:
            each.slip = _foot(system, instant, each, each.spring)
    kept = acting(instant.mass, instant.forces, instant.acting(resting), still)
    if kept is None:
        raise log.jam(state)
    for number, slip in kept:
        resting[number].slip = slip
    staying = [resting[number] for number, _ in kept]
    ending = [each for each in system.sustained if each not in staying]
    for each in ending:
        system.sustained.remove(each)
        record(system, log, state, each, "release" if new is None else new.obstacle)
    log.check_stop(state, staying)
    system.sustained = staying
    for each in [*ending, *(each for each in begun if each not in staying)]:
        log.released(each.point, state.time)
    log.check_stop(state, staying)
    return system.closed(state)


def _begun(system: System, state: State, point: Point) -> Sustained:
    """Return the new contact at a point of a wire, with its spring if it is compliant."""
    instant = system.at(state)
    obstacle = system.obstacles[point.obstacle]
    spring = None
    touch = instant.touch(point)
    if (
        isinstance(obstacle, Workpart)
        and (stiffness := _stiffness(instant, touch, point)) is not None
    ):
        surface = obstacle.surface
        # A stiffer tangential spring is taken as rigid in a contact in time; the impact law uses a
        # mean instead.
        compliance = obstacle.compliance if obstacle.compliance >= LEAST_COMPLIANCE else 0.0
        law = ContactSpring(
            stiffness,
            surface.restitution,
            surface.friction,
            surface.friction_in_restitution,
            compliance,
        )
        spring = Spring(law, touch.gap, touch.along)
    return Sustained(point, 0, state, touch.velocity, spring)


def _stiffness(instant: Instant, touch: Touch, point: Point) -> float | None:
    """Return the stiffness of contacts with the workpart, N/m; None if they are rigid.

    At the first contact of any wire the stiffness is computed from the requested duration; it
    belongs to the surface, so all later contacts have it too. For a rigid wire the impact law
    relates the two. For a wire of several links the contact is taken to be frictionless,
    and the hinges rigid.
    """
    system = instant.system
    chain = instant.system.chain
    if system.duration is None or system.stiffness is not None:
        return system.stiffness
    surface = system.obstacles[point.obstacle].surface
    if len(chain.tips) == 1 and chain.links > 1:
        inertia = float(chain.mass_matrix(np.ones(chain.links, dtype=complex)).sum())
        lever = touch.along - float(instant.motion.joint[0].real)
        stiffness = frictionless_stiffness(lever**2 / inertia, surface.restitution, system.duration)
    else:
        hit = _impact(instant, touch, surface, 0.0)[0]
        stiffness = stiffness_for_duration(
            hit, touch.velocity[0], surface.restitution, system.duration
        )
    system.stiffness = stiffness
    return stiffness


def _impact(
    instant: Instant, touch: Touch, surface: Surface, compliance: float
) -> tuple[Impact, Array]:
    """Return an impact by the energetic law, and its effect on the rates of all links.

    The second result is the change of the rates, rad/s, per unit normal and per unit tangential
    impulse, shape (links, 2).
    """
    rows = np.array([touch.normal_row, touch.tangential_row])
    response = np.linalg.solve(instant.mass, rows.T)
    inverse_mass = 0.5 * (rows @ response + response.T @ rows.T)
    coefficients = surface.friction, surface.restitution, surface.friction_in_restitution
    return energetic_impact(
        inverse_mass, touch.velocity, *coefficients, tangential_compliance=compliance
    ), response


def _foot(system: System, instant: Instant, each: Sustained, spring: Spring) -> int:
    """Return the sense in which a tangential spring's foot slides, or 0 if it sticks.

    If the foot sticks, it is moved so that the force lies within the friction cone.
    """
    touch = instant.touch(each.point)
    mu = system.friction(each.point, spring)
    pull = spring.rub(touch, each.slip) or 0.0
    most = mu * max(spring.force(touch.gap), 0.0)
    pull = min(max(pull, -most), most)
    sense = int(-np.sign(pull) or np.sign(touch.velocity[1]))
    if not mu or (abs(pull) >= (1.0 - EDGE) * most and spring.foot(touch, sense) > 0.0):
        return sense or 1
    spring.stretch(touch, pull)
    return 0


def record(system: System, log: Log, state: State, each: Sustained, outcome: str) -> None:
    """Record a sustained contact that ends in a state, with its outcome."""
    normal, tangential = system.at(state).touch(each.point).velocity
    for own in log.of(each.point):
        own.lasting(each, state, (normal if each.spring else 0.0, tangential), outcome)


def end_compression(
    system: System, log: Log, each: Sustained, spring: Spring, state: State
) -> State:
    """End the compression of a compliant contact and begin its restitution.

    With a coefficient of restitution of 0 the contact ends.
    """
    spring.deepest = spring.surface - system.at(state).touch(each.point).gap
    change_phase(system, each, spring, state)
    each.compression = each.sums
    return (
        decide(system, log, state)
        if spring.law.restitution
        else end_compliant_contact(system, log, each, state)
    )


def change_phase(system: System, each: Sustained, spring: Spring, state: State) -> None:
    """Change a spring from loading to unloading or back.

    The tangential force does not change, except that it must lie within the new friction cone.
    """
    touch = system.at(state).touch(each.point)
    if each.slip and (pull := spring.rub(touch, each.slip)) is not None:
        spring.stretch(touch, pull)
        each.slip = 0
    spring.loading = not spring.loading


def end_compliant_contact(system: System, log: Log, each: Sustained, state: State) -> State:
    """Record a compliant contact whose force has fallen to zero, and remove it from the system."""
    rebounds = each.spring is not None and each.spring.law.restitution > 0.0
    record(system, log, state, each, "rebound" if rebounds else "no rebound")
    system.sustained.remove(each)
    log.released(each.point, state.time)
    log.check_stop(state, system.sustained)
    return state


def move_contact(system: System, each: Sustained, point: Point, state: State) -> State:
    """Move a contact with the bar from the flank of a wire to a corner, or back."""
    each.point = point
    return system.closed(state)


def _impacts(system: System, log: Log, state: State, points: Sequence[Point]) -> State:
    """Resolve the impacts at several points one by one, the fastest approach first.

    An impact may cause another one. Raises ``Finished`` if the wires jam.
    """
    while points:
        instant = system.at(state)
        approaches = [instant.touch(point).velocity[0] for point in points]
        if min(approaches) >= -system.still(state):
            break
        state = _hit(system, log, state, points[int(np.argmin(approaches))])
    return state


def _hit(system: System, log: Log, state: State, point: Point) -> State:
    """Resolve and record one impact by the energetic law; return the state after it."""
    instant = system.at(state)
    obstacle = system.obstacles[point.obstacle]
    touch = instant.touch(point)
    hit, response = _impact(instant, touch, obstacle.surface, obstacle.compliance)
    impulse = np.array([hit.impulse_normal, hit.impulse_tangential], dtype=float)
    after = state._replace(rates=state.rates + response @ impulse)
    log.impacts.append(state.time)
    for own in log.of(point):
        own.impact(point, state, after, touch.velocity, hit, system.rate_rounding(state))
    most = MOST_AT_ONCE * len(log.records) ** 2  # wires in a row pass on impacts to each other
    recent = log.impacts[-most:]
    moment = AT_ONCE / max(system.fastest, float(np.abs(after.rates).max()))
    if hit.outcome_name == "jam" or (len(recent) == most and recent[-1] - recent[0] < moment):
        raise log.jam(after)
    return after


def _low_rebounds_stopped(system: System, state: State, points: Sequence[Point]) -> State:
    """Set the normal velocity to zero where a rebound would be too low to resolve.

    Such a rebound has a height below ``LOWEST_REBOUND``.
    """
    if not points:
        return state
    instant = system.at(state)
    free = np.linalg.solve(instant.mass, instant.forces)
    low = []
    for touch in (instant.touch(point) for point in points):
        falling = float(touch.normal_row @ free) + touch.bias[0]
        parting = touch.velocity[0]
        if falling < 0.0 < parting and parting**2 < -2.0 * falling * LOWEST_REBOUND * system.size:
            low.append(touch)
    return state._replace(rates=state.rates + closed(instant.mass, low)[1]) if low else state
