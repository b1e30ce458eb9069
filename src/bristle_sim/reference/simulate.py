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
from bristle_sim.reference.log import Log
from bristle_sim.reference.mechanics import Chain
from bristle_sim.reference.run import Run
from bristle_sim.reference.state import State
from bristle_sim.reference.system import System
from bristle_sim.settings import STOP_AFTER, StopReason
from bristle_sim.trajectory import ContactHistory, ContactRecord, Cost, Trajectory

METHOD = "scipy DOP853"  # name of the method in a trajectory's parameters
PERIODS_AT_REST = 3.0  # duration of a run on a resting hub, in natural periods of the bristle
SAMPLES_PER_PERIOD = 64
MOST_SAMPLES = 2e6
OVERLAP_ROUNDING = 1e-12  # rounding error of a gap, over hub radius plus length
FINEST = 1e-13  # smallest relative tolerance of the integrator: 500 rounding errors of a float
SAMPLES_OF_STRIKE = 200  # number of samples in the longest permitted duration of a contact
MOST_RADIANS = 1e5  # longest duration of a run, times the fastest rate, rad

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
    """Simulate a pass with SciPy's integrator, independently of the engine.

    A pass consists of flight, taps and slides along the bar, release, strike and rebound. A wire
    obeys the equations of the module ``mechanics``. With the hub angle psi and the angle alpha of
    the bristle from the radial direction, the flight of a straight rigid bristle is

        I alpha'' + c alpha' + k alpha + m r_h (L/2) omega^2 sin alpha = -m g (L/2) sin(psi +
        alpha).

    A touch obeys the energetic impact law. A sustained contact keeps its gap closed with a force
    that pushes. A rebound is neglected if its height is below 1e-10 of hub radius plus length, so
    that taps become a sustained contact.

    Args:
        tool: the tool; its bar and workpart may be None.
        start_hub_angle: hub angle at the start, rad; by default ``tool.start_hub_angle``.
        start_relative_angle: angle of the bristle from the radial direction at the start, rad,
            within a quarter turn.
        start_relative_rate: rate of this angle at the start, rad/s.
        hub_turn: angle by which the hub turns in the run, rad. On a resting hub the run lasts three
            natural periods of the bristle.
        duration: duration of the run (s) in place of ``hub_turn``.
        accuracy: relative accuracy of the motion. The integrator's tolerance is a hundredth of it,
            but at least 1e-13.
        stop_after: event that ends the run, as for the scene's ``simulate``. A touch ends the run
            just after the impact, or at the end of a contact that is resolved in time.
        sample_interval: time between samples, s; by default 1/64 of a natural period or of a hub
            turn, whichever is shorter.

    Returns:
        The trajectory. Its ``cost.steps`` is the number of evaluations of the equations of motion.

    Raises:
        ValueError: for settings out of range, a start inside an obstacle, or a run of more than 1e5
            radians of its fastest motion.
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
    """Simulate a row of straight rigid bristles that touch the bar, the workpart and each other.

    All bristles start together, radial and at rest relative to the hub, unless ``requested`` says
    otherwise. A touch of two wires obeys the energetic impact law with the inverse mass of both
    wires.

    Args:
        tool: a tool with a straight rigid bristle.
        bristles: number of bristles.
        pitch: angle between the roots of neighbours, rad.
        neighbour_friction: coefficient of friction between two wires.
        neighbour_restitution: energetic coefficient of restitution between two wires.
        hub_turn: angle by which the hub turns in the pass of each bristle, rad. The run lasts until
            the last bristle has turned by it from the hub angle at which the foremost one starts.
        requested: further arguments of ``simulate_reference``. The hub angle at the start is that
            of the foremost bristle. The run stops when every bristle has had the event
            ``stop_after``.

    Returns:
        One trajectory for each bristle, the foremost first, with common sample times. A touch of
        two wires is the event ``wire touch`` of both.
    """
    wall = clock.perf_counter()
    cpu = clock.process_time()
    given = {"start_hub_angle": tool.start_hub_angle} | requested
    request = Request(hub_turn=hub_turn, **given)
    starts = [request.start_hub_angle - number * pitch for number in range(bristles)]
    surface = Surface(friction=neighbour_friction, restitution=neighbour_restitution)
    wires = WirePairs(bristles, tool.bristle.wire_diameter, surface)
    fixed = obstacles_of(tool)
    chain = Chain(tool, *starts)
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
    """Raise ValueError if a wire starts inside the bar or the workpart."""
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
    """Return the end of the run and the time between samples, s.

    ``row`` is the angle between the roots of the first and the last bristle, rad.
    """
    # Natural rate of the wire on its belt with rigid hinges, and c/I, twice the rate of its decay,
    # rad/s.
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
    """Raised when the wire or its contact is too stiff for the explicit integrator.

    The integration would take too many evaluations of the equations of motion.
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
    """Return the first contact of a wire's tip with the workpart, resolved in time on springs.

    The springs are those of :class:`bristle_sim.reference.state.Compliant`. The record contains the
    history of forces and penetration.

    Args:
        tool: a tool with a workpart; its bar is ignored.
        hub_angle: hub angle at the touch, rad. The tip is then at the surface and approaches it.
        angles: absolute angles of the links at the touch, rad.
        rates: absolute rates of the links at the touch, rad/s.
        stiffness: stiffness of the contact, N/m.
        longest: time within which the contact must end, s.
        accuracy: requested relative accuracy; the integrator's tolerance is a hundredth of it.
        most_evaluations: largest number of evaluations of the equations of motion. The contact of a
            usual wire of 8 links takes a thousand.

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
