"""Simulate a pass of one wire, or of a row of straight rigid bristles: check the request, run, return the results."""

from __future__ import annotations

import dataclasses
import functools
import math
import time as clock
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle_sim.parameters import Surface, Tool
from bristle_sim.reference.contacts import Bar, WirePairs, Workpart, obstacles_of
from bristle_sim.reference.log import LARGEST_RETRACTION, PEAK, STRIKE, Log
from bristle_sim.reference.mechanics import Chain
from bristle_sim.reference.run import Run
from bristle_sim.reference.system import Obstacles, State, System
from bristle_sim.stop_reason import EVENTS, checked_name
from bristle_sim.trajectory import Cost, Trajectory
from bristle_sim.units import ANY, quantity, validate

METHOD = "scipy DOP853"  # says in a trajectory's parameters that the reference was integrated

PERIODS_AT_REST = 3.0  # natural periods of the bristle that a run with a hub at rest lasts
SAMPLES_PER_PERIOD = 64
MOST_SAMPLES = 2e6
FINEST = 1e-13  # least relative tolerance of the integrator: five hundred roundings
LONGEST = 1e5  # radians of the fastest motion that a run may last


requested = functools.partial(quantity, source="requested", usual=ANY)


@dataclass(frozen=True, slots=True)
class Request:
    """The arguments of a run, checked."""

    start_hub_angle: float = requested(0.0, "-1e6 <= start_hub_angle <= 1e6 rad")
    start_relative_angle: float = requested(0.0, "-1.57 <= start_relative_angle <= 1.57 rad")
    start_relative_rate: float = requested(0.0, "-1e9 <= start_relative_rate <= 1e9 rad/s")
    hub_turn: float = requested(1.0, "0 < hub_turn <= 1e6 rad")
    duration: float | None = requested(None, "0 < duration <= 1e9 s")
    accuracy: float = requested(1e-10, "1e-12 <= accuracy <= 0.1")
    sample_interval: float | None = requested(None, "0 < sample_interval <= 1e9 s")
    contact_stiffness: float | None = requested(None, "0 < contact_stiffness <= 1e20 N/m")
    bar_stiffness: float | None = requested(None, "0 < bar_stiffness <= 1e20 N/m")
    stop_after: str | None = None

    def __post_init__(self) -> None:
        validate(self)
        if self.stop_after is not None:
            checked_name("stop_after", self.stop_after, EVENTS)


def simulate_reference(
    tool: Tool,
    *,
    start_hub_angle: float = -0.5 * math.pi,
    start_relative_angle: float = 0.0,
    start_relative_rate: float = 0.0,
    hub_turn: float = 1.5 * math.pi,
    duration: float | None = None,
    accuracy: float = 1e-10,
    stop_after: str | None = None,
    sample_interval: float | None = None,
    contact_stiffness: float | None = None,
    bar_stiffness: float | None = None,
) -> Trajectory:
    """Simulate a pass: flight, taps and slides along the bar, release, strike, rebound.

    A wire moves as the module ``mechanics`` says; flight of a straight rigid bristle is
    I alpha'' + c alpha' + k alpha + m r_h (L/2) omega^2 sin alpha + m g (L/2) sin(psi + alpha) = 0. A touch obeys the
    energetic impact law. A sustained contact keeps its gap closed with a force that pushes. A rebound too low to be
    distinguished from rounding (1e-10 of hub radius and length) counts as none, so that taps become a sustained contact.

    Args:
        tool: its bar and workpart may be None.
        start_hub_angle: psi at t = 0, rad; by default the bristle points along -x.
        start_relative_angle, start_relative_rate: alpha (rad, within a quarter turn) and its rate (rad/s) at t = 0.
        hub_turn: how far the hub turns, rad. A hub at rest runs for three of the bristle's natural periods.
        duration: length of the run instead, s.
        accuracy: relative, of the motion; the integrator's tolerance is a hundredth of it, but at least 1e-13.
        stop_after: event that ends the run, as for the scene's ``simulate``; a touch ends it just after the impact.
        sample_interval: s; by default 1/64 of a natural period or of a hub turn, whichever is shorter.
        contact_stiffness, bar_stiffness: of contacts with workpart and bar, N/m, springs with energetic restitution;
            rigid by default.

    Returns:
        The trajectory, with the events of ``stop_reason``. ``cost.steps`` counts right-hand sides.

    Raises:
        ValueError: for settings out of range, a start inside an obstacle, or a run of more than 1e5 radians of its
            fastest motion.
    """
    start = (start_hub_angle, start_relative_angle, start_relative_rate)
    stiffness = (contact_stiffness, bar_stiffness)
    request = Request(*start, hub_turn, duration, accuracy, sample_interval, *stiffness, stop_after)
    return _simulate(tool, request, [request.start_hub_angle])[0]


def simulate_row_reference(
    tool: Tool,
    *,
    bristles: int,
    pitch: float,
    neighbour_friction: float = 0.0,
    neighbour_restitution: float = 1.0,
    start_hub_angle: float = -0.5 * math.pi,
    hub_turn: float = 1.5 * math.pi,
    accuracy: float = 1e-10,
    stop_after: str | None = None,
    sample_interval: float | None = None,
    contact_stiffness: float | None = None,
    bar_stiffness: float | None = None,
) -> tuple[Trajectory, ...]:
    """Simulate a row of bristles that touch each other, bar and workpart.

    All start together, radial and turning with the hub, each a pitch behind the one before it. A touch of two wires obeys
    the energetic impact law with both wires' inverse mass. Arguments and errors not named are those of
    ``simulate_reference``.

    Args:
        tool: its bristle must be straight and rigid.
        bristles: at least 1.
        pitch: angle between neighbours' roots, rad.
        neighbour_friction, neighbour_restitution: Coulomb's coefficient and the energetic one between two wires.
        start_hub_angle: of the foremost bristle, rad.
        hub_turn: after which the last bristle's pass ends, from its passage through the foremost one's start, rad.
        stop_after: name of a touch or release; the run ends when every bristle has had one.

    Returns:
        One trajectory for each bristle, the foremost first, at common instants. A touch of two wires is the event
        ``wire touch`` of both.
    """
    _check_row(tool, bristles, pitch, stop_after)
    whole_turn = hub_turn + (bristles - 1) * pitch
    stiffness = (contact_stiffness, bar_stiffness)
    request = Request(start_hub_angle, 0.0, 0.0, whole_turn, None, accuracy, sample_interval, *stiffness, stop_after)
    surface = Surface(friction=neighbour_friction, restitution=neighbour_restitution)
    starts = [request.start_hub_angle - number * pitch for number in range(bristles)]
    touches = WirePairs(bristles, tool.bristle.wire_diameter, surface)
    return _simulate(tool, request, starts, touches, bristles=bristles, pitch=pitch)


def _simulate(
    tool: Tool,
    request: Request,
    start_hub_angles: Sequence[float],
    touches: WirePairs | None = None,
    **shared: Any,
) -> tuple[Trajectory, ...]:
    """Run all links, of one wire or of several that touch each other; return a trajectory for each wire."""
    wall, cpu = clock.perf_counter(), clock.process_time()
    fixed, chain = obstacles_of(tool), Chain.of(tool, *start_hub_angles)
    wires = [Chain.of(tool, each) for each in start_hub_angles]
    rates = np.full(chain.links, chain.speed + request.start_relative_rate)
    start = State(0.0, chain.start_hub_angles + request.start_relative_angle, rates)
    end, interval = _span(wires[0], request)
    log = Log(wires, interval, request.stop_after, touches.pairs if touches else ())
    for record in log.records:
        _check_start(record.chain, fixed, record.own(start))
    obstacles: Obstacles = {**fixed, WirePairs.name: touches} if touches and touches.pairs else fixed
    stiffness = {"workpart": request.contact_stiffness, "bar": request.bar_stiffness}
    system = System(chain, obstacles, {name: each for name, each in stiffness.items() if each is not None})
    run = Run(system, log, start, end, max(request.accuracy / 100.0, FINEST))
    reason = run.run()
    cost = Cost(clock.perf_counter() - wall, clock.process_time() - cpu, run.evaluations)
    for record in log.records:
        record.note_largest_retraction([state for state, _ in log.samples])
        if "bar" in fixed and not record.seen("bar touch"):
            record.event("bar not touched", run.state.time)
        if "workpart" in fixed and not record.seen(STRIKE) and request.stop_after != PEAK:
            record.event("workpart not reached", run.state.time)
    settings = dataclasses.asdict(request)
    begun = {name.removeprefix("start_"): settings.pop(name) for name in [*settings] if name.startswith("start_")}
    given = {
        "stop_after": settings.pop("stop_after"),
        "settings": settings,
        "start": begun,
        "tool": dataclasses.asdict(tool),
    }
    return log.trajectories(reason, cost, {"method": METHOD, **given, **shared})


def _check_start(chain: Chain, obstacles: dict[str, Bar | Workpart], start: State) -> None:
    """Refuse a start inside an obstacle."""
    motion = chain.kinematics(*start)
    for name, each in obstacles.items():
        gap = float(each.gaps(chain, motion).min())
        if gap < -1e-12 * (chain.hub_radius + chain.length):
            relative = start.angles[0] - chain.start_hub_angles[0]
            raise ValueError(
                f"start_hub_angle = {chain.start_hub_angles[0]:g}, start_relative_angle = {relative:g}: must be angles at"
                f" which the bristle is outside the {name}; it is {-gap:g} m inside (in rad)"
            )


def _check_row(tool: Tool, bristles: int, pitch: float, stop_after: str | None) -> None:
    """Refuse bristles that are not rigid and straight, a row that does not fit the hub, and events that do not stop it."""
    if tool.bristle.links != 1 or len(tool.bristle.path) != 1:
        raise ValueError(f"wire_links = {tool.bristle.links}: must be 1, without a knee, in a row (dimensionless)")
    if type(bristles) is not int or bristles < 1:
        raise ValueError(f"bristles = {bristles!r}: must be a whole number of at least 1 (dimensionless)")
    apart = 2.0 * tool.hub.radius * math.sin(min(pitch, math.pi) / 2.0)
    if not (apart > tool.bristle.wire_diameter and (bristles - 1) * pitch < 2.0 * math.pi - pitch):
        raise ValueError(
            f"pitch = {pitch:g}: must be one at which the roots are more than wire_diameter apart, and the row less than a"
            " turn (in rad)"
        )
    if stop_after in (PEAK, LARGEST_RETRACTION):
        raise ValueError(f"stop_after = {stop_after!r}: must be a touch or a release in a row")


def _span(chain: Chain, request: Request) -> tuple[float, float]:
    """Return the end of the run and the time between samples, s."""
    # Natural rate of the wire on its belt, with rigid hinges, and c/I, twice the rate at which it decays, rad/s.
    inertia = float(chain.mass_matrix(np.ones(chain.links, dtype=complex)).sum())
    field = abs(complex(chain.moments.sum())) * (chain.hub_radius * chain.speed**2 + chain.gravity)
    swing, decay = math.sqrt((float(chain.stiffness[0]) + field) / inertia), float(chain.damping[0]) / inertia
    moving = max(swing, chain.speed)
    period = 2.0 * math.pi / moving if moving else math.inf  # of the rigid rod or the hub; infinite if nothing moves it
    end = request.duration
    if end is None:
        end = request.hub_turn / chain.speed if chain.speed else PERIODS_AT_REST * period
    fastest = swing + decay + chain.speed
    if fastest and end * fastest > LONGEST:
        raise ValueError(
            f"duration = {end:g}: must be at most {LONGEST / fastest:g}, {LONGEST:g} radians of the"
            " fastest motion of hub and bristle on its belt (in s)"
        )
    if not math.isfinite(end):
        raise ValueError("duration = None: must be a number, as hub, belt and gravity set no time scale (in s)")
    interval = request.sample_interval or min(period / SAMPLES_PER_PERIOD, end)
    if end / interval > MOST_SAMPLES:
        raise ValueError(f"sample_interval = {interval:g}: must be at least {end / MOST_SAMPLES:g} (in s)")
    return end, interval
