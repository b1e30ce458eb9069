"""The entry: checks what was asked for, runs the pass and writes the result."""

from __future__ import annotations

import dataclasses
import math
import time as clock
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle_sim.parameters import Tool
from bristle_sim.quantity import quantity, validate
from bristle_sim.reference.chain import Chain
from bristle_sim.reference.chain_contact import Bar, Workpart, obstacles_of
from bristle_sim.reference.chain_log import ChainLog, ChainState
from bristle_sim.reference.chain_run import END_OF_RUN, PEAK, STRIKE, ChainRun
from bristle_sim.trajectory import Cost, Trajectory

__all__ = ["simulate_reference"]

PERIODS_AT_REST = 3.0
SAMPLES_PER_PERIOD = 64

FINEST = 1e-13
"""Least relative tolerance of the integrator: five hundred roundings."""

MOST_SAMPLES = 2e6

LONGEST = 1e5
"""Radians of the fastest motion that a run may last."""


@dataclass(frozen=True, slots=True)
class _Request:
    """What was asked for, checked."""

    start_hub_angle: float = quantity(0.0, "start_hub_angle", "rad", at_least=-1e6, at_most=1e6, source="asked for")
    start_relative_angle: float = quantity(
        0.0, "start_relative_angle", "rad", at_least=-1.57, at_most=1.57, source="asked for: within a quarter turn"
    )
    start_relative_rate: float = quantity(
        0.0, "start_relative_rate", "rad/s", at_least=-1e9, at_most=1e9, source="asked for"
    )
    hub_turn: float = quantity(1.0, "hub_turn", "rad", above=0.0, at_most=1e6, source="asked for")
    duration: float | None = quantity(None, "duration", "s", above=0.0, at_most=1e9, source="asked for")
    accuracy: float = quantity(1e-10, "accuracy", "1", at_least=1e-12, at_most=0.1, source="asked for")
    sample_interval: float | None = quantity(None, "sample_interval", "s", above=0.0, at_most=1e9, source="asked for")
    stop_after: str | None = None

    def __post_init__(self) -> None:
        validate(self)
        if self.stop_after not in (None, STRIKE, PEAK):
            raise ValueError(f"stop_after = {self.stop_after!r}: None, {STRIKE!r} or {PEAK!r} is allowed")


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
) -> Trajectory:
    """Simulate a pass: flight, taps and slides along the bar, release, strike, rebound.

    Flight of a straight bristle obeys I alpha'' + c alpha' + k alpha + m r_h (L/2) omega^2 sin alpha
    + m g (L/2) sin(psi + alpha) = 0; a knee moves the centre of mass. A touch obeys the energetic impact law, and a
    sustained touch gap = 0 with a force that pushes. A rebound too low to be told from rounding (1e-10 of hub radius
    and length) counts as none, so that ever smaller taps become a sustained touch.

    Args:
        tool: what is simulated; its bar and workpart may be None.
        start_hub_angle: psi at t = 0, rad; by default the bristle points along -x.
        start_relative_angle, start_relative_rate: alpha (rad, within a quarter turn) and its rate (rad/s) at t = 0.
        hub_turn: how far the hub turns, rad. A hub at rest runs for three of the bristle's natural periods.
        duration: length of the run instead, s.
        accuracy: relative accuracy of the motion asked for; the integrator's tolerance is a hundredth of it.
        stop_after: ``strike`` ends just after the first impact on the workpart, ``highest relative speed`` where the
            relative rate is highest before it.
        sample_interval: s; by default 1/64 of a natural period or of a hub turn, whichever is shorter.

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
    request = _Request(
        start_hub_angle,
        start_relative_angle,
        start_relative_rate,
        hub_turn,
        duration,
        accuracy,
        sample_interval,
        stop_after,
    )
    chain = Chain.of(tool, request.start_hub_angle)
    obstacles = obstacles_of(tool)
    start = ChainState(
        0.0,
        np.full(chain.links, request.start_hub_angle + request.start_relative_angle),
        np.full(chain.links, chain.speed + request.start_relative_rate),
    )
    _check_start(chain, obstacles, start)
    end, interval = _span(chain, request)
    log = ChainLog(chain, interval, request.stop_after)
    one = ChainRun(chain, obstacles, log, start, end, max(request.accuracy / 100.0, FINEST))
    reason = _conclude(one, one.run())
    cost = Cost(clock.perf_counter() - wall, clock.process_time() - cpu, one.evaluations)
    return log.trajectory(reason, cost, _parameters(tool, request))


def _check_start(chain: Chain, obstacles: dict[str, Bar | Workpart], start: ChainState) -> None:
    motion = chain.kinematics(*start)
    for name, each in obstacles.items():
        gaps = each.height(chain, motion) if isinstance(each, Workpart) else each.feet(chain, motion)[1]
        gap = float(gaps.min())
        if gap < -1e-12 * (chain.hub_radius + chain.length):
            relative = start.angles[0] - chain.start_hub_angle
            raise ValueError(
                f"start_hub_angle = {chain.start_hub_angle:g}, start_relative_angle = {relative:g}: angles at"
                f" which the bristle is outside the {name} are allowed, it is {-gap:g} m inside (in rad)"
            )


def _span(chain: Chain, request: _Request) -> tuple[float, float]:
    """End of the run and time between samples, s."""
    period = _period(chain)
    end = request.duration
    if end is None:
        end = request.hub_turn / chain.speed if chain.speed else PERIODS_AT_REST * period
    fastest = chain.fastest_rate if chain.links == 1 else chain.speed
    if fastest and end * fastest > LONGEST:
        raise ValueError(
            f"duration = {end:g}: at most {LONGEST / fastest:g} is allowed, {LONGEST:g} radians of the"
            " fastest motion of hub and bristle on its belt (in s)"
        )
    if not math.isfinite(end):
        raise ValueError("duration = None: a number is allowed, as hub, belt and gravity set no time scale (in s)")
    interval = request.sample_interval or min(period / SAMPLES_PER_PERIOD, end)
    if end / interval > MOST_SAMPLES:
        raise ValueError(f"sample_interval = {interval:g}: at least {end / MOST_SAMPLES:g} is allowed (in s)")
    return end, interval


def _period(chain: Chain) -> float:
    """Period of the bristle as a rigid rod or of the hub, whichever is shorter; infinite if nothing moves it, s."""
    fastest = max(chain.swing_rate, chain.speed)
    return 2.0 * math.pi / fastest if fastest else math.inf


def _conclude(one: ChainRun, reason: str) -> str:
    """Note what never happened; the stop reason."""
    one.conclude()
    log, last = one.log, one.state.time
    log.largest_retraction()
    if "bar" in one.obstacles and not log.seen("bar touch"):
        log.event("bar not touched", last)
    if "workpart" in one.obstacles and not log.seen(STRIKE) and reason != PEAK:
        log.event("workpart not reached", last)
        if reason == END_OF_RUN and log.stop_after == STRIKE:
            return "workpart not reached"
    return reason


def _parameters(tool: Tool, request: _Request) -> dict[str, Any]:
    """Every number that the run depends on, by its key."""
    found: dict[str, Any] = {"method": "scipy DOP853"}
    for owner in (tool.hub, tool.belt, tool.bristle, tool.bar, tool.workpart, tool, request):
        for each in dataclasses.fields(owner) if owner is not None else ():
            if "declaration" in each.metadata:
                found[each.metadata["declaration"].key] = getattr(owner, each.name)
    return {**found, "stop_after": request.stop_after}
