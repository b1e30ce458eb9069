"""The motion of a run as numbers for an HTML page.

The page interpolates between the numbers. It shows the same motion as :meth:`Trajectory.at`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.readable import MILLIMETRES, MILLISECONDS
from bristle_sim.render.story import phases, story_end
from bristle_sim.trajectory import ContactRecord, Interpolation, Motion, Trajectory

# Point of an interval, as a fraction of its length, at which the error of interpolation is evaluated.
# In the middle of the interval errors may cancel.
TRIED = 0.4

LINE_SHOWN = 0.001
RETRACTION_SHOWN = 0.001
SPEED_SHOWN = 0.01
"""Largest permitted errors of the page's interpolation: of the wire's centre line (mm), of the
retraction (degrees) and of the tip speed (m/s).

Each is at most a tenth of the last digit that the page shows."""

FINEST_FORCE = 0.01
FORCE_RATIO = 1e-3
"""Smallest place value of the last digit of a force on the page: in N, and as a fraction of the
largest force of the contact.

The fraction bounds the number of times between which the page interpolates. The force of a contact
that lasts 0.4 ns reaches 10 MN. To show it to 10 mN would take a hundred thousand such times."""

FORCE_ERROR = (
    0.09  # largest permitted error of the force, divided by the place value of its last digit
)
# Largest count of numbers in the data of a page. At 12 bytes for a number the data stay below 2 MB.
MOST_NUMBERS = 100_000
STRIKE_SHOWN = 0.01  # time for which an instantaneous impact is shown, as a fraction of the run
ROUNDS = 40  # largest number of rounds in which intervals are halved
WORST = 0.5  # least error of an interval that is halved, as a fraction of the largest error
JUMP = 1e-9  # smallest discontinuity that counts as a jump, in the page's units


def motion_data(run: Trajectory, tool: Tool) -> dict[str, Any]:
    """Return the motion of a pass as JSON data for an HTML page.

    The data extend to the last time that the page shows. Times are in ms, lengths in mm, velocities
    in m/s, forces in N, impulses in mN s and angles in degrees, except the hub angle, which is in
    rad.

    The data contain the state at chosen times, the nodes. Between nodes the page interpolates the
    centre line and the retraction by cubic Hermite polynomials, and the force linearly. At a jump
    of a quantity two nodes have the same time. The text ``drawn`` states the number of nodes and
    the interpolation errors.
    """
    end = story_end(run)
    intervals, error = _intervals(run, end)
    begins, ends = intervals
    nodes = 1 + begins.shape[1]
    jumps = np.abs(begins[:, 1:] - ends[:, :-1]).max(axis=(0, 2)) > JUMP
    kept = np.stack([np.ones(nodes - 1, dtype=bool), np.append(jumps, True)], axis=1)
    # Times are rounded to 1e-15 s and lengths to 1e-12 m. Speeds within a short contact then stay
    # correct, and the page stays small.
    places, slopes = np.moveaxis(intervals, 0, 2)[:, kept]
    bar = None
    if tool.bar is not None:
        bar = [each * MILLIMETRES for each in (*tool.bar.centre, tool.bar.radius)]
    return {
        "time": places[:, 0].round(12).tolist(),
        "line": places[:, 1:-2].round(9).tolist(),
        "velocity": slopes[:, 1:-2].round(9).tolist(),
        "retraction": np.stack([places[:, -2], slopes[:, -2]], axis=1).round(9).tolist(),
        "force": places[:, -1:].round(9).tolist(),
        "drawn": f"{nodes} instants drawn; between these the motion is interpolated to {error * LINE_SHOWN:.2g} mm,"
        f" {error * RETRACTION_SHOWN:.2g}° and {error * SPEED_SHOWN:.2g} m/s",
        "hub": [float(run.hub_angle[0]), run.hub_speed / MILLISECONDS],
        "hubRadius": tool.hub.radius * MILLIMETRES,
        "wire": tool.bristle.wire_diameter * MILLIMETRES,
        "bar": bar,
        "surface": None if tool.workpart is None else -tool.workpart_depth * MILLIMETRES,
        "contacts": [
            [
                each.obstacle,
                *(round(1e3 * part, 12) for part in (each.time, each.duration, *each.impulse)),
                _force_digit(run, each),
            ]
            for each in run.contacts
            if each.time <= end
        ],
        "phases": [
            [round(MILLISECONDS * each.start, 12), each.caption]
            for each in phases(run, STRIKE_SHOWN * (end - run.time[0]))
            if each.start <= end
        ],
    }


def _intervals(run: Trajectory, end: float) -> tuple[Array, float]:
    """Choose the times (nodes) between which the page interpolates, and return their intervals.

    The last node is the first sample of the run at or after the time ``end`` (s). At first all
    nodes are samples of the run. Intervals with large interpolation errors are then halved, until
    the errors do not affect the digits shown or the data reach their largest size.

    Returns:
        The states at both ends of every interval, shape (2, 2, intervals, columns). The axes are:
            beginning or end; value or time derivative; interval; column as in :func:`_states`.
        The largest interpolation error divided by the permitted error, at least 1.
    """
    motion = Interpolation(run, run.contacts)
    last = int(np.searchsorted(run.time, run.time[np.searchsorted(run.time, end)], side="right"))
    time, first = np.unique(run.time[:last], return_index=True)
    states = _states(run)
    before = states[:, first]
    after = states[:, np.append(first[1:], last) - 1]
    before[0, :, -1] = motion.normal_force(time, "before")
    after[0, :, -1] = motion.normal_force(time, "after")
    most = MOST_NUMBERS // (2 * states.shape[2])
    # If the run has many samples, the first nodes are a selection of them. It leaves three quarters
    # of the permitted nodes for the halving.
    chosen = np.arange(time.size) % (1 + 4 * time.size // most) == 0
    chosen |= np.abs(after - before).max(axis=(0, 2)) > JUMP
    chosen[-1] = True
    intervals = np.stack([after[:, chosen][:, :-1], before[:, chosen][:, 1:]])
    errors = _errors(run, motion, intervals)
    for _ in range(ROUNDS):
        halved = errors > max(1.0, WORST * errors.max())
        count = int(halved.sum())
        if not count or errors.size + count >= most:
            break
        middles = intervals[:, 0, halved, 0].mean(axis=0) / MILLISECONDS
        halves = np.concatenate(2 * [intervals[:, :, halved]], axis=2)
        halves[1, :, :count] = halves[0, :, count:] = _states(motion(middles))
        intervals = np.concatenate([intervals[:, :, ~halved], halves], axis=2)
        errors = np.append(errors[~halved], _errors(run, motion, halves))
    order = np.argsort(intervals[0, 0, :, 0])
    return intervals[:, :, order], max(1.0, float(errors.max()))


def _errors(run: Trajectory, motion: Interpolation, intervals: Array) -> Array:
    """Return the error of the page's interpolation in each interval, divided by the permitted
    error.

    The errors of all quantities are evaluated at one time within the interval; the largest counts.
    An error is the difference from ``motion``, the interpolation that the run itself provides.
    ``intervals`` holds states in the form that :func:`_intervals` returns.
    """
    (p, v), (q, w) = intervals
    s = TRIED
    length = (q - p)[:, :1]
    time = (p + s * length)[:, 0] / MILLISECONDS
    true, velocity = _states(motion(time))
    # Hermite's cubic polynomial from values and slopes at both ends, and the slope of the
    # polynomial. The force is interpolated linearly.
    place = (
        q
        + (1.0 - s) ** 2 * (1.0 + 2.0 * s) * (p - q)
        + s * (1.0 - s) * length * ((1.0 - s) * v - s * w)
    )
    slope = (
        6.0 * s * (s - 1.0) * (p - q) / length
        + (1.0 - s) * (1.0 - 3.0 * s) * v
        + s * (3.0 * s - 2.0) * w
    )
    place[:, -1] = (p + s * (q - p))[:, -1]
    allowed = np.full_like(place, LINE_SHOWN)
    allowed[:, -2] = RETRACTION_SHOWN
    allowed[:, -1] = FORCE_ERROR * FINEST_FORCE
    for contact in run.contacts:
        during = (time >= contact.time) & (time <= contact.time + contact.duration)
        allowed[during, -1] = FORCE_ERROR * _force_digit(run, contact)
    speed, true_speed = (np.hypot(*each[:, -4:-2].T) for each in (slope, velocity))
    wrong = (np.abs(place - true) / allowed)[:, 1:].max(axis=1)
    return np.asarray(np.maximum(wrong, np.abs(speed - true_speed) / SPEED_SHOWN))


def _states(motion: Motion | Trajectory) -> Array:
    """Return the quantities that the page interpolates, and their time derivatives.

    The columns are the time (ms), the corners of the centre line (mm), the retraction (degrees) and
    the normal force (N). Derivatives are per ms; those of time and force are not used. Velocities
    need no conversion, since 1 m/s is 1 mm/ms.

    Returns:
        Array of shape (2, instants, columns): values, then derivatives.
    """
    rows = motion.time.size
    time = motion.time * MILLISECONDS
    retraction, falling = np.degrees([motion.retraction, -motion.relative_rate / MILLISECONDS])
    force = motion.normal_force
    line = (motion.centre_line * MILLIMETRES).reshape(rows, -1)
    velocity = motion.centre_line_velocity.reshape(rows, -1)
    places = (time, line, retraction, force)
    slopes = (time, velocity, falling, force)
    return np.stack([np.column_stack(each) for each in (places, slopes)])


def _force_digit(run: Trajectory, contact: ContactRecord) -> float:
    """Return the place value (N) of the last digit of the normal force shown during a contact."""
    during = (run.time >= contact.time) & (run.time <= contact.time + contact.duration)
    largest = float(run.normal_force[during].max(initial=0.0)) if contact.duration else 0.0
    digit = max(FINEST_FORCE, FORCE_RATIO * largest)
    return float(10.0 ** math.ceil(math.log10(digit) - 1e-9))
