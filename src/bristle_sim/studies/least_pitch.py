"""The least pitch of the bristles in one plane, below which two neighbouring wires touch each
other.

The pitch is the angle beta between neighbouring bristles on the hub. The least pitch follows from
the motion A(t) of a single bristle relative to the hub. At constant hub speed omega a bristle that
touches no other bristle repeats the motion of the preceding one after the time beta/omega. The
motion of this follower is therefore A(t - beta/omega). Two wires touch if the distance between
their centre lines is the wire's diameter.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.studies.pass_invariants import X_Y, Points
from bristle_sim.trajectory import Trajectory
from bristle_sim.trajectory.interpolation import cubics

# Smallest step between tried pitches, rad. If the distance of the wires has a minimum between tried
# pitches, the pitch of the minimum is also tried.
PITCH_STEP = math.radians(0.25)
PITCH_TOLERANCE = 1e-9  # largest error of the least pitch, rad: 6e-8 deg
# Number of equally spaced instants of a pass at which the distance is computed, besides the
# samples: one for every 0.2 deg of the hub's turn.
INSTANTS = 1500
# Number of local minima of the distance over time that are refined, beginning with the smallest
MINIMA_REFINED = 2
# Largest number of samples of a lone bristle's motion for which the pitch is searched: eight times
# the number at the operating point.
MOST_SAMPLES = 5000
LARGEST_PITCH = math.pi / 2.0  # pitch at which the downward search starts, rad
# Distance above a least pitch at which the search for a smaller one begins, rad: a thousand times
# the tolerance.
NEXT_SEARCH = 1e-6


@dataclass(frozen=True, slots=True)
class LeastPitch:
    """The angle between neighbouring bristles above which their wires do not touch.

    A pass is the trip of one bristle past bar and workpart. Only its touches up to the instant
    ``until`` count.

    Attributes:
        name: name under which a report lists the pitch.
        until: latest instant of a touch that counts, s; None if there is no strike.
        of_follower: whether ``until`` is measured in the pass of the following bristle, which is
            delayed by the pitch, instead of the pass of the leading bristle.
        by_theory: the pitch that follows from the motion of a lone bristle, deg; None if it was not
            computed.
    """

    name: str
    until: float | None
    of_follower: bool
    by_theory: float | None


def polyline_distance(first: Points, second: Points) -> Array:
    """Return the smallest distance between the polylines of each pair; 0 if the two cross.

    ``first`` and ``second`` hold the corners as complex numbers x + i y, shape (n, corners). The
    distances have the shape (n,).
    """

    def seen(points: Points, line: Points) -> tuple[Array, NDArray[np.bool_]]:
        """Compare the corners of the polyline ``points`` with the segments of ``line``.

        Returns:
            The smallest distance of a corner from a segment.
            For each pair of consecutive corners and each segment, whether the corners are on
                opposite sides of the segment's line.
        """
        along = np.diff(line)[:, np.newaxis]
        from_start = points[:, :, np.newaxis] - line[:, np.newaxis, :-1]
        place = np.conj(along) * from_start / abs(along) ** 2  # 0 to 1 along the segment
        away = abs(place - np.clip(place.real, 0.0, 1.0)) * abs(along)
        return away.min(axis=(1, 2)), place.imag[:, 1:] * place.imag[:, :-1] < 0.0

    distance, around = seen(first, second)
    other_distance, other_around = seen(second, first)
    crossing = (around & other_around.swapaxes(1, 2)).any(axis=(1, 2))
    return np.where(crossing, 0.0, np.minimum(distance, other_distance))


def nearest_approach(lone: Trajectory, pitch: float, until: float) -> float:
    """Return the smallest distance between the centre lines of a bristle and its follower, m.

    The follower repeats the motion of a lone bristle with a delay. Between samples the centre line
    is interpolated by a cubic in time. The relative error of the interpolation is h^4/384, where h
    is the phase of the oscillation between samples, rad. It is 1e-8 at 150 samples per period.

    Args:
        lone: motion of the lone bristle.
        pitch: angle by which the follower is behind, rad.
        until: instant up to which the distance is computed, s.
    """
    delay = pitch / lone.hub_speed
    begin = float(lone.time[0])
    lines = cubics(lone.time, lone.centre_line, lone.centre_line_velocity)

    def distance(time: Array) -> Array:
        """Return the distance between the two centre lines at given instants, m."""
        within = np.maximum(time - delay, begin)  # before the start a bristle turns with the hub
        turned = np.exp(1j * lone.hub_speed * (time - delay - within))
        return polyline_distance(lines(time) @ X_Y, lines(within) @ X_Y * turned[:, np.newaxis])

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
    """Return the minimum of a function between two bounds, and the argument at which it occurs.

    The function must have a single local minimum between the bounds.
    """
    found = minimize_scalar(
        function, bounds=(low, high), method="bounded", options={"xatol": 1e-7 * (high - low)}
    )
    return float(found.fun), float(found.x)


def least_pitch(
    lone: Trajectory,
    wire_diameter: float,
    *,
    until: float,
    of_follower: bool = False,
    largest: float,
) -> float:
    """Return the pitch above which the wire does not touch its neighbour, rad.

    Both wires are assumed to repeat the motion of a lone bristle.

    Args:
        lone: motion of the lone bristle, which starts at rest relative to the hub.
        wire_diameter: diameter of the wires, m. The wires touch if the distance between their
            centre lines is no larger.
        until: instant up to which touches count, s.
        of_follower: whether ``until`` is measured in the pass of the following bristle, which is
            delayed by the pitch, instead of the pass of the leading bristle.
        largest: largest pitch of the search, rad. At this pitch the wires must not touch.
    """
    last = float(lone.time[-1])

    def gap(pitch: float) -> float:
        """Return the smallest gap between the two wires (m) at a pitch (rad)."""
        delay = pitch / lone.hub_speed if of_follower else 0.0
        return nearest_approach(lone, pitch, min(until + delay, last)) - wire_diameter

    pitch = largest
    open_gap = gap(largest)
    wider = math.inf
    before = largest
    # Bound of the gap's derivative with respect to the pitch, m/rad. The follower's delay is
    # pitch/omega, so the bound is the largest speed of a point of the wire divided by omega.
    steepest = float(np.linalg.norm(lone.centre_line_velocity, axis=-1).max()) / lone.hub_speed
    while True:  # ends at the latest at a pitch at which the two wires would overlap
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
    """Return three theoretical least pitches, in ascending order.

    Above the first pitch, neighbouring wires do not touch before the leading bristle strikes. Above
    the second, they do not touch before the following bristle strikes. Above the third, they do not
    touch during the whole pass. The theoretical pitch is None if the strike does not occur, or if
    :func:`unsearched` returns a reason.
    """
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
    ) in instants:  # each entry counts fewer touches than the one before, so its pitch is smaller
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
    """Return the reason why the least pitch cannot be searched; empty if it can."""
    if lone.time.size > MOST_SAMPLES:
        return "the pass has too many oscillations of the bristle on its belt"
    if nearest_approach(lone, LARGEST_PITCH, float(lone.time[-1])) <= tool.bristle.wire_diameter:
        return f"wires touch each other even {math.degrees(LARGEST_PITCH):g} deg apart"
    return ""
