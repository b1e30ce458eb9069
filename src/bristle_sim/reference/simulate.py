"""Passes of one wire or of a row of straight rigid bristles, and one compliant strike."""

from __future__ import annotations

import dataclasses
import functools
import math
import time as clock
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle_sim.declared import Declared
from bristle_sim.fields import ANY, quantity
from bristle_sim.parameters import START, Surface, Tool
from bristle_sim.parameters.tool import checked_tool
from bristle_sim.reference.contacts import Point, WirePairs, obstacles_of
from bristle_sim.reference.decisions import close_contact
from bristle_sim.reference.forces import State
from bristle_sim.reference.log import Log
from bristle_sim.reference.mechanics import Chain
from bristle_sim.reference.run import Run
from bristle_sim.reference.system import System
from bristle_sim.settings import STOP_AFTER, StopReason
from bristle_sim.trajectory import ContactHistory, ContactRecord, Cost, Trajectory

METHOD = "scipy DOP853"  # name of the method in a trajectory's parameters
PERIODS_AT_REST = 3.0  # duration of a run on a resting hub, in natural periods of the bristle
SAMPLES_PER_PERIOD = 64
MOST_SAMPLES = 2e6  # largest number of samples of a run, which bounds its memory
# Overlap at the start that counts as rounding error, as a fraction of hub radius plus wire length.
OVERLAP_ROUNDING = 1e-12
FINEST = 1e-13  # least relative tolerance of the integrator: 500 rounding errors of a float
SAMPLES_OF_STRIKE = 200  # number of samples in ``longest``, the time in which a contact must end
MOST_RADIANS = 1e5  # longest duration of a run, times the highest angular frequency, rad

declared = functools.partial(quantity, usual=ANY)


@dataclass(frozen=True, slots=True)
class Request(Declared):
    """The arguments of a run, checked against their ranges."""

    start_hub_angle: float = declared(START, "-1e6 <= start_hub_angle <= 1e6 rad")
    start_relative_angle: float = declared(0.0, "-1.57 <= start_relative_angle <= 1.57 rad")
    start_relative_rate: float = declared(0.0, "-1e9 <= start_relative_rate <= 1e9 rad/s")
    hub_turn: float = declared(1.0, "0 < hub_turn <= 1e6 rad")
    duration: float | None = declared(None, "0 < duration <= 1e9 s")
    accuracy: float = declared(1e-10, "1e-12 <= accuracy <= 0.1")
    sample_interval: float | None = declared(None, "0 < sample_interval <= 1e9 s")
    stop_after: str | None = None

    def __post_init__(self) -> None:
        Declared.__post_init__(self)
        if self.stop_after is not None:
            STOP_AFTER.check(self.stop_after)


def simulate_reference(
    tool: Tool,
    *,
    start_hub_angle: float | None = None,
    start_relative_angle: float = 0.0,
    start_relative_rate: float = 0.0,
    hub_turn: float = 1.5 * math.pi,
    duration: float | None = None,
    accuracy: float = 1e-10,
    stop_after: str | None = None,
    sample_interval: float | None = None,
) -> Trajectory:
    """Simulate one pass of a bristle with SciPy's integrator, independently of the engine.

    In a pass the bristle touches the bar and slides along it, is released, strikes the workpart and
    rebounds. The equations of motion are those of the module ``mechanics``. For a straight rigid
    bristle in flight, with the hub angle psi and the angle alpha from the radial direction, they
    are

        I alpha'' + c alpha' + k alpha + m r_h (L/2) omega^2 sin alpha
            = -m g (L/2) sin(psi + alpha).

    I, m and L are the bristle's moment of inertia about its root, its mass and its length. c and k
    are the belt's damping and stiffness, r_h and omega the hub's radius and speed, and g is
    gravity.

    A touch is an impact by the energetic law. The force of a sustained contact keeps the gap closed
    and can only push. A rebound lower than 1e-10 times the sum of hub radius and bristle length is
    neglected, so that repeated impacts end in a sustained contact.

    Args:
        tool: the tool; its bar and workpart may be None.
        start_hub_angle: hub angle at the start, rad; by default ``tool.start_hub_angle``.
        start_relative_angle: angle of the bristle from the radial direction at the start, rad. Its
            magnitude must be at most 1.57.
        start_relative_rate: angular velocity of the bristle relative to the hub at the start,
            rad/s.
        hub_turn: angle by which the hub turns in the run, rad. On a resting hub the run lasts three
            natural periods of the bristle.
        duration: duration of the run (s) in place of ``hub_turn``.
        accuracy: relative accuracy of the motion. The integrator's tolerance is a hundredth of
            ``accuracy``, but at least 1e-13.
        stop_after: event that ends the run, as for the scene's ``simulate``. A touch ends the run
            just after the impact, or at the end of a contact that is resolved in time.
        sample_interval: time between samples, s; by default 1/64 of the bristle's natural period or
            of the hub's period of revolution, whichever is shorter.

    Returns:
        The trajectory. Its ``cost.steps`` is the number of evaluations of the equations of motion.

    Raises:
        ValueError: for an argument out of range, for a start inside an obstacle, if the duration
            times the highest natural angular frequency is above 1e5 rad, or if the restitution of a
            contact resolved in time is too small for double precision.
    """
    tool = checked_tool(tool)
    angle = tool.start_hub_angle if start_hub_angle is None else start_hub_angle
    (run,) = simulate_row_reference(
        tool,
        bristles=1,
        pitch=0.0,
        hub_turn=hub_turn,
        start_hub_angle=angle,
        start_relative_angle=start_relative_angle,
        start_relative_rate=start_relative_rate,
        duration=duration,
        accuracy=accuracy,
        stop_after=stop_after,
        sample_interval=sample_interval,
    )
    return run


def simulate_row_reference(
    tool: Tool,
    *,
    bristles: int,
    pitch: float,
    neighbour_friction: float = 0.0,
    neighbour_restitution: float = 1.0,
    hub_turn: float = 1.5 * math.pi,
    **requested: Any,
) -> tuple[Trajectory, ...]:
    """Simulate a row of bristles that touch the bar, the workpart and each other.

    All bristles start at the same time, radial and at rest relative to the hub unless ``requested``
    sets another start. A touch of two wires is an impact by the energetic law, in which both wires
    move.

    Args:
        tool: the tool; every bristle has its parameters.
        bristles: number of bristles.
        pitch: angle between the roots of neighbours, rad.
        neighbour_friction: coefficient of friction between two wires.
        neighbour_restitution: energetic coefficient of restitution between two wires.
        hub_turn: angle that sets the duration of the run, rad. At the end of the run the root of
            the last bristle is this angle beyond the hub angle at which the foremost bristle
            started.
        requested: further arguments of ``simulate_reference``. ``start_hub_angle`` is that of the
            foremost bristle. The run stops when the event ``stop_after`` has occurred on every
            bristle.

    Returns:
        One trajectory for each bristle, the foremost first, all with the same sample times. A touch
        of two wires is recorded for both of them as the event ``wire touch``.
    """
    wall = clock.perf_counter()
    cpu = clock.process_time()
    given = {"start_hub_angle": tool.start_hub_angle} | requested
    request = Request(hub_turn=hub_turn, **given)
    starts = [request.start_hub_angle - number * pitch for number in range(bristles)]
    surface = Surface(friction=neighbour_friction, restitution=neighbour_restitution)
    chain = Chain(tool, *starts)
    wires = WirePairs(chain, tool.bristle.wire_diameter, surface)
    fixed = obstacles_of(tool)
    rates = np.full(chain.links, chain.speed + request.start_relative_rate)
    start = State(0.0, chain.start_hub_angles + request.start_relative_angle, rates)
    end, interval = _span(tool, request, (bristles - 1) * pitch)
    log = Log([Chain(tool, each) for each in starts], interval, request.stop_after, wires.pairs)
    system = System(chain, {**fixed, "wire": wires}, log, duration=tool.contact.duration)
    _check_start(system, start)
    run = Run(system, start, end, max(request.accuracy / 100.0, FINEST))
    reason = run.run()
    cost = Cost(clock.perf_counter() - wall, clock.process_time() - cpu, run.evaluations)
    parameters = {
        "method": METHOD,
        "tool": dataclasses.asdict(tool),
        "settings": dataclasses.asdict(request),
    }
    runs = [
        own.trajectory(log.samples, fixed, stop_reason=reason, cost=cost, parameters=parameters)
        for own in log.records
    ]
    return tuple([each.with_places(tool) for each in runs])


def _check_start(system: System, start: State) -> None:
    """Raise ValueError if a wire would start inside the bar or the workpart."""
    for name in system.obstacles:
        gaps = system.at(start).gaps(name)
        if name != "wire" and gaps.min() < -OVERLAP_ROUNDING * system.size:
            link = system.chain.pieces.links[gaps.argmin()]
            hub_angle = system.chain.start_hub_angles[link]
            raise ValueError(
                f"start_hub_angle = {hub_angle:g}, start_relative_angle = {start.angles[link] - hub_angle:g}: must be angles at"
                f" which the bristle is outside the {name}; it is {-gaps.min():g} m inside (in rad)"
            )


def _span(tool: Tool, request: Request, row: float) -> tuple[float, float]:
    """Return the time at which the run ends and the time between samples, s.

    ``row`` is the angle between the roots of the first and the last bristle, rad.
    """
    # ``swing``: natural angular frequency of the wire on its belt with rigid hinges, rad/s.
    # ``decay``: c/I, twice the decay rate of the oscillation, 1/s.
    bristle = tool.bristle
    speed = tool.hub.speed
    inertia = bristle.inertia_about_root
    moment = bristle.mass * math.hypot(*bristle.centre)
    field = moment * (tool.hub.radius * speed**2 + tool.gravity)
    swing = math.sqrt((tool.belt.stiffness + field) / inertia)
    decay = tool.belt_damping / inertia
    moving = max(swing, speed)
    period = 2.0 * math.pi / moving if moving else math.inf  # infinite if nothing moves the wire
    end = request.duration
    if end is None:
        end = (request.hub_turn + row) / speed if speed else PERIODS_AT_REST * period
    if not math.isfinite(end):
        raise ValueError(
            "duration = None: must be a number, as hub, belt and gravity set no time scale (in s)"
        )
    fastest = swing + decay + speed
    if end * fastest > MOST_RADIANS:
        raise ValueError(
            f"duration = {end:g}: must be at most {MOST_RADIANS / fastest:g}, {MOST_RADIANS:g} radians of the fastest motion of hub and"
            " bristle on its belt (in s)"
        )
    interval = request.sample_interval or min(period / SAMPLES_PER_PERIOD, end)
    if end / interval > MOST_SAMPLES:
        raise ValueError(
            f"sample_interval = {interval:g}: must be at least {end / MOST_SAMPLES:g} (in s)"
        )
    return end, interval


class TooStiffError(ValueError):
    """Raised if the wire or its contact is too stiff for the explicit integrator.

    The integration would then require more evaluations of the equations of motion than are
    permitted.
    """


def strike_reference(
    tool: Tool,
    hub_angle: float,
    angles: Sequence[float],
    rates: Sequence[float],
    stiffness: float,
    *,
    longest: float,
    accuracy: float = 1e-9,
    most_evaluations: int = 20_000,
) -> ContactRecord:
    """Return the first contact of a wire's tip with the workpart, computed on contact springs.

    The springs are those of :class:`bristle_sim.reference.forces.Compliant`. The record contains the
    history of forces and penetration.

    Args:
        tool: a tool with a workpart; its bar is ignored.
        hub_angle: hub angle at the touch, rad. The tip is then at the surface and approaches it.
        angles: absolute angles of the links at the touch, rad.
        rates: absolute angular velocities of the links at the touch, rad/s.
        stiffness: normal stiffness of the contact, N/m.
        longest: time within which the contact must end, s.
        accuracy: requested relative accuracy; the integrator's tolerance is a hundredth of it.
        most_evaluations: largest number of evaluations of the equations of motion. A wire of 8
            links usually takes about a thousand.

    Raises:
        ValueError: if the contact does not end within ``longest``.
        TooStiffError: if the contact takes more than ``most_evaluations`` evaluations.
    """
    chain = Chain(tool, hub_angle)
    log = Log([chain], longest / SAMPLES_OF_STRIKE, "workpart release")
    system = System(chain, obstacles_of(dataclasses.replace(tool, bar=None)), log, stiffness)
    start = State(0.0, np.array(angles, dtype=float), np.array(rates, dtype=float))
    begun = close_contact(system, "workpart", len(chain.masses) - 1, start)
    reason = Run(system, begun, longest, accuracy / 100.0, most_evaluations).run()
    if reason is StopReason.STEP_BUDGET:
        raise TooStiffError(
            f"stiffness = {stiffness:g}: must be less for the independent solution (in N/m)"
        )
    if reason is not StopReason.EVENT:
        raise ValueError(
            f"longest = {longest:g}: must be a time in which the contact ends; it stops: {reason} (in s)"
        )
    tip = Point("workpart", len(chain.masses) - 1, True)
    touches = [system.at(state).touch(tip) for state, _ in log.samples]
    pushes = np.array([forces[0] for _, forces in log.samples])
    velocities = np.array([each.velocity for each in touches])
    history = ContactHistory(
        time=np.array([state.time for state, _ in log.samples]),
        normal_force=pushes[:, 0],
        tangential_force=pushes[:, 1],
        penetration=np.array([-each.gap for each in touches]),
        normal_velocity=velocities[:, 0],
        tangential_velocity=velocities[:, 1],
    )
    return dataclasses.replace(log.records[0].contacts[0], history=history)
