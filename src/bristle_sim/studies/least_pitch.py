"""The least pitch of bristles in one plane by the motion of one alone: from what spacing do two wires touch each other?

On a hub of constant speed each bristle that touches no other one repeats the motion of the one before it, when the hub has
turned by the pitch beta. So two wires touch where the capsules (the centre line with half the wire's diameter about it) of
A(t) and of its follower A(t - beta/omega) do, A being the motion of a lone bristle.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.studies.pass_invariants import Points, complex_points
from bristle_sim.studies.timed_contact import cubics
from bristle_sim.trajectory import Trajectory

# Least step between the pitches that are tried, rad; a local minimum of the distance between them is refined
PITCH_STEP = math.radians(0.25)
PITCH_TOLERANCE = 1e-9  # Tolerance of the least pitch, rad: 6e-8 deg
# Evenly spaced instants of a pass at which the distance is computed, besides the samples; every 0.2 deg of the hub's
# turn
INSTANTS = 1500
MINIMA_REFINED = (
    2  # Local minima of the distance over time that are refined, beginning with the least
)
# Samples of a lone pass, eight times those of the operating point, beyond which no least pitch is searched
MOST_SAMPLES = 5000
LARGEST_PITCH = math.pi / 2.0  # Pitch at which the downward search starts, rad
# How far above a least pitch the search for a smaller one begins, rad: a thousand times its tolerance
NEXT_SEARCH = 1e-6


@dataclass(frozen=True, slots=True)
class LeastPitch:
    """A pitch, deg, above which two wires do not touch up to an instant of a pass; ``by_theory`` from a lone bristle's motion.

    The instant ``until``, s, is one of the pass of the bristle in front, or of the follower's own pass, a pitch later. It is
    None without a strike.
    """

    name: str
    until: float | None
    of_follower: bool
    by_theory: float | None


def polyline_distance(first: Points, second: Points) -> Array:
    """Return the least distance of two polylines of complex points, 0 where they cross; shapes (n, corners) to (n,)."""
    found = np.full(len(first), np.inf)
    for i in range(first.shape[1] - 1):
        for j in range(second.shape[1] - 1):
            pair = (first[:, i : i + 2], second[:, j : j + 2])
            crossing = np.full(len(first), True)
            for points, segment in (pair, pair[::-1]):
                along = (segment[:, 1] - segment[:, 0])[:, np.newaxis]
                seen = (
                    np.conj(along) * (points - segment[:, :1]) / abs(along) ** 2
                )  # from the segment, over its length
                away = abs(seen - np.clip(seen.real, 0.0, 1.0)) * abs(along)
                found = np.minimum(found, away.min(axis=1))
                crossing &= np.prod(seen.imag, axis=1) < 0.0
            found[crossing] = 0.0
    return found


def nearest_approach(lone: Trajectory, pitch: float, until: float) -> float:
    """Return the least distance of the centre lines of a bristle and its follower up to an instant, m.

    Between samples h rad of its motion apart the cubics of a line have an error of h^4/384, 1e-8 at 150 samples a period.
    """
    delay = pitch / lone.hub_speed
    begin = float(lone.time[0])
    lines = cubics(lone.time, lone.centre_line, lone.centre_line_velocity)

    def distance(time: Array) -> Array:
        within = np.maximum(time - delay, begin)  # before its start a bristle turns with the hub
        turned = np.exp(1j * lone.hub_speed * (time - delay - within))
        return polyline_distance(
            complex_points(lines(time)), complex_points(lines(within)) * turned[:, np.newaxis]
        )

    samples = np.concatenate([lone.time, lone.time + delay])
    inside = samples[(samples > begin) & (samples < until)]
    instants = np.unique(np.concatenate([np.linspace(begin, until, INSTANTS), inside]))
    values = distance(instants)
    least = float(values.min())
    inner = np.flatnonzero((values[1:-1] <= values[:-2]) & (values[1:-1] <= values[2:])) + 1
    for at in inner[np.argsort(values[inner])][:MINIMA_REFINED]:
        sides = instants[at - 1], instants[at + 1]
        least = min(least, _minimum(lambda time: float(distance(np.array([time]))[0]), *sides)[0])
    return least


def _minimum(function: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """Return the least value of a function of one minimum between bounds, and where it is."""
    found = minimize_scalar(
        function, bounds=(low, high), method="bounded", options={"xatol": 1e-7 * (high - low)}
    )
    return float(found.fun), float(found.x)


def least_pitch(
    lone: Trajectory,
    wire_diameter: float,
    *,
    until: float | None = None,
    of_follower: bool = False,
    largest: float = LARGEST_PITCH,
) -> float:
    """Return the pitch above which no wire touches its neighbour, by the motion of a lone bristle, rad.

    The lone bristle's run starts when it turns with the hub; two wires touch at a wire diameter, m, between their centre lines.
    Touches count until an instant of the pass of the bristle in front, s, by default the end of the run, or of the follower's
    own pass, a pitch later. The search goes down from the largest pitch, rad.

    Raises ValueError if the hub stands still, the wire has no thickness, or wires touch at the largest pitch.
    """
    if not lone.hub_speed:
        raise ValueError("hub_speed = 0: must be above 0, or no bristle follows another (in rad/s)")
    if not wire_diameter > 0.0:
        raise ValueError(
            f"wire_diameter = {wire_diameter:g}: must be above 0, or wires have no surface to touch (in m)"
        )
    last = float(lone.time[-1])
    end = last if until is None else until

    def gap(pitch: float) -> float:
        delay = pitch / lone.hub_speed if of_follower else 0.0
        return nearest_approach(lone, pitch, min(end + delay, last)) - wire_diameter

    pitch = largest
    open_gap = gap(largest)
    wider = math.inf
    before = largest
    # m/rad: the follower lags by pitch/omega, and no point of it moves faster.
    steepest = float(np.linalg.norm(lone.centre_line_velocity, axis=-1).max()) / lone.hub_speed
    if open_gap <= 0.0:
        raise ValueError(
            f"largest = {largest:g}: must be a pitch at which wires do not touch; they overlap by {-open_gap:g} m (in rad)"
        )
    while True:  # ends at the latest where the next wire would stand in this one
        narrower = max(pitch - max(PITCH_STEP, open_gap / steepest), 0.0)
        closed = gap(narrower)
        if closed <= 0.0:
            return float(brentq(gap, narrower, pitch, xtol=PITCH_TOLERANCE))
        if wider > open_gap < closed:
            depth, deepest = _minimum(gap, narrower, before)
            if depth <= 0.0:
                return float(brentq(gap, deepest, before, xtol=PITCH_TOLERANCE))
        pitch, before, wider, open_gap = narrower, pitch, open_gap, closed


def least_pitches_of(tool: Tool, lone: Trajectory) -> tuple[LeastPitch, ...]:
    """Return the theoretical least pitches, the narrowest first; without a value where ``unsearched`` gives a reason."""
    contact = lone.first_contact("workpart")
    found = list[LeastPitch]()
    largest = LARGEST_PITCH
    strike = None if contact is None else contact.time
    searched = not unsearched(tool, lone)
    instants = (
        ("whole_pass", float(lone.time[-1]), False),
        ("to_own_strike", strike, True),
        ("to_strike", strike, False),
    )
    for (
        words,
        until,
        own,
    ) in instants:  # each counts fewer touches than the one before, so that its pitch is smaller
        theory = None
        if until is not None and searched:
            largest = least_pitch(
                lone, tool.bristle.wire_diameter, until=until, of_follower=own, largest=largest
            )
            theory = math.degrees(largest)
            largest += NEXT_SEARCH
        found.append(LeastPitch(f"least_pitch_{words}_deg", until, own, theory))
    return tuple(reversed(found))


def unsearched(tool: Tool, lone: Trajectory) -> str:
    """Return the reason why no least pitch is searched; empty if it is."""
    if lone.time.size > MOST_SAMPLES:
        return "the pass has too many oscillations of the bristle on its belt"
    if nearest_approach(lone, LARGEST_PITCH, float(lone.time[-1])) <= tool.bristle.wire_diameter:
        return f"wires touch each other even {math.degrees(LARGEST_PITCH):g} deg apart"
    return ""
