"""The entry: checks what was requested, runs the pass and writes the result."""

from __future__ import annotations

import dataclasses
import math
import time as clock
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle_sim.parameters import Tool
from bristle_sim.quantity import quantity, validate
from bristle_sim.reference.contacts import Bar, Workpart, obstacles_of
from bristle_sim.reference.log import PEAK, STRIKE, Log
from bristle_sim.reference.mechanics import Chain
from bristle_sim.reference.run import Run
from bristle_sim.reference.system import State, System
from bristle_sim.stop_reason import EVENTS, checked_event
from bristle_sim.trajectory import Cost, Trajectory

METHOD = "scipy DOP853"
"""Says in a trajectory's parameters that the reference was integrated."""

PERIODS_AT_REST = 3.0
SAMPLES_PER_PERIOD = 64

FINEST = 1e-13
"""Least relative tolerance of the integrator: five hundred roundings."""

MOST_SAMPLES = 2e6

LONGEST = 1e5
"""Radians of the fastest motion that a run may last."""


@dataclass(frozen=True, slots=True)
class Request:
    """What was requested, checked."""

    start_hub_angle: float = quantity(0.0, "start_hub_angle", "rad", at_least=-1e6, at_most=1e6, source="requested")
    start_relative_angle: float = quantity(
        0.0, "start_relative_angle", "rad", at_least=-1.57, at_most=1.57, source="requested: within a quarter turn"
    )
    start_relative_rate: float = quantity(
        0.0, "start_relative_rate", "rad/s", at_least=-1e9, at_most=1e9, source="requested"
    )
    hub_turn: float = quantity(1.0, "hub_turn", "rad", above=0.0, at_most=1e6, source="requested")
    duration: float | None = quantity(None, "duration", "s", above=0.0, at_most=1e9, source="requested")
    accuracy: float = quantity(1e-10, "accuracy", "1", at_least=1e-12, at_most=0.1, source="requested")
    sample_interval: float | None = quantity(None, "sample_interval", "s", above=0.0, at_most=1e9, source="requested")
    contact_stiffness: float | None = quantity(
        None, "contact_stiffness", "N/m", above=0.0, at_most=1e20, source="requested"
    )
    stop_after: str | None = None

    def __post_init__(self) -> None:
        validate(self)
        if self.stop_after is not None:
            checked_event("stop_after", self.stop_after, EVENTS)


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
) -> Trajectory:
    """Simulate a pass: flight, taps and slides along the bar, release, strike, rebound.

    A wire of several links moves as the module ``mechanics`` says. Flight of a straight rigid bristle obeys
    I alpha'' + c alpha' + k alpha + m r_h (L/2) omega^2 sin alpha + m g (L/2) sin(psi + alpha) = 0; a knee moves the centre
    of mass. A touch obeys the energetic impact law, and a sustained contact gap = 0 with a force that pushes. A rebound too low to be distinguished from rounding (1e-10 of hub radius
    and length) counts as none, so that ever smaller taps become a sustained contact.

    Args:
        tool: what is simulated; its bar and workpart may be None.
        start_hub_angle: psi at t = 0, rad; by default the bristle points along -x.
        start_relative_angle, start_relative_rate: alpha (rad, within a quarter turn) and its rate (rad/s) at t = 0.
        hub_turn: how far the hub turns, rad. A hub at rest runs for three of the bristle's natural periods.
        duration: length of the run instead, s.
        accuracy: relative accuracy of the motion requested; the integrator's tolerance is a hundredth of it.
        stop_after: name of the event that ends the run, as for the scene's ``simulate``; a touch ends it just after the
            impact.
        sample_interval: s; by default 1/64 of a natural period or of a hub turn, whichever is shorter.
        contact_stiffness: of the contact with the workpart, N/m, a spring with energetic restitution; by default it is rigid.

    Returns:
        The trajectory. Events: ``bar touch``, ``bar release``, ``strike``, ``workpart touch``, ``workpart release``,
        ``largest retraction``, ``highest relative speed``, ``bar not touched``, ``workpart not reached``,
        ``retraction limit`` (the bristle leans over by 90 degrees) and ``jam`` (friction or geometry locks it).
        ``cost.steps`` counts right-hand sides.

    Raises:
        ValueError: for settings out of range, a start inside an obstacle, or a run of more than 1e5 radians of its
            fastest motion.
    """
    wall, cpu = clock.perf_counter(), clock.process_time()
    request = Request(
        start_hub_angle,
        start_relative_angle,
        start_relative_rate,
        hub_turn,
        duration,
        accuracy,
        sample_interval,
        contact_stiffness,
        stop_after,
    )
    chain = Chain.of(tool, request.start_hub_angle)
    obstacles = obstacles_of(tool)
    start = State(
        0.0,
        np.full(chain.links, request.start_hub_angle + request.start_relative_angle),
        np.full(chain.links, chain.speed + request.start_relative_rate),
    )
    check_start(chain, obstacles, start)
    end, interval = span(chain, request)
    log = Log(chain, interval, request.stop_after)
    one_run = Run(System(chain, obstacles, contact_stiffness), log, start, end, max(request.accuracy / 100.0, FINEST))
    reason = one_run.run()
    note_absences(obstacles, log, one_run.state.time)
    cost = Cost(clock.perf_counter() - wall, clock.process_time() - cpu, one_run.evaluations)
    return log.trajectory(reason, cost, parameters(tool, request))


def check_start(chain: Chain, obstacles: dict[str, Bar | Workpart], start: State) -> None:
    """Refuse a start inside an obstacle."""
    motion = chain.kinematics(*start)
    for name, each in obstacles.items():
        gap = float(each.gaps(chain, motion).min())
        if gap < -1e-12 * (chain.hub_radius + chain.length):
            relative = start.angles[0] - chain.start_hub_angle
            raise ValueError(
                f"start_hub_angle = {chain.start_hub_angle:g}, start_relative_angle = {relative:g}: must be angles at"
                f" which the bristle is outside the {name}; it is {-gap:g} m inside (in rad)"
            )


def span(chain: Chain, request: Request) -> tuple[float, float]:
    """Return the end of the run and the time between samples, s."""
    period = _period(chain)
    end = request.duration
    if end is None:
        end = request.hub_turn / chain.speed if chain.speed else PERIODS_AT_REST * period
    fastest = chain.swing_rate + chain.decay_rate + chain.speed
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


def _period(chain: Chain) -> float:
    """Return the period of the bristle as a rigid rod or of the hub, whichever is shorter; infinite if nothing moves it."""
    fastest = max(chain.swing_rate, chain.speed)
    return 2.0 * math.pi / fastest if fastest else math.inf


def note_absences(obstacles: Iterable[str], log: Log, last: float) -> None:
    """Note what never happened up to the last instant."""
    log.note_largest_retraction()
    if "bar" in obstacles and not log.seen("bar touch"):
        log.event("bar not touched", last)
    if "workpart" in obstacles and not log.seen(STRIKE) and log.stop_after != PEAK:
        log.event("workpart not reached", last)


def parameters(tool: Tool, request: Request) -> dict[str, Any]:
    """What the run depends on: method, tool and settings, as the scene's trajectories have them."""
    given = dataclasses.asdict(request)
    start = {name.removeprefix("start_"): given.pop(name) for name in tuple(given) if name.startswith("start_")}
    stop_after = given.pop("stop_after")
    tool_values = dataclasses.asdict(tool)
    return {"method": METHOD, "tool": tool_values, "settings": given, "start": start, "stop_after": stop_after}
