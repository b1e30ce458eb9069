"""The motion of a run as plain numbers, from which a page interpolates the same motion as :meth:`Trajectory.at`."""

from __future__ import annotations

from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.render.story import phases, story_end
from bristle_sim.render.style import MILLIMETRES, MILLISECONDS
from bristle_sim.trajectory import Interpolation, Motion, Trajectory

ROUNDS, TRIED = 12, 0.4
"""Most times that an interval is halved, and where in it the page's interpolation is tried: where errors do not cancel."""

SHOWN = {"line": 0.001, "retraction": 0.001, "force": 0.0007}
SPEED_SHOWN = 0.01
"""Errors of the page's interpolation, a tenth of the last digit that it shows or less: mm, degrees, N, and m/s of the tip."""

STRIKE_SHOWN = 0.01  # part of the run for which an impact at an instant is shown
Columns = dict[str, tuple[Array, Array]]
"""Values and slopes of the line's corners, mm, the retraction, degrees, and the force, N, each (n, m); times are in ms."""


def motion_data(run: Trajectory, tool: Tool) -> dict[str, Any]:
    """Return a pass up to the end of its story as JSON data: ms, mm, m/s and degrees; the hub's angle in rad.

    Between the nodes the page interpolates centre line and retraction by cubic Hermite polynomials, and the force linearly.
    Nodes are added until that is exact to the digits shown. Two nodes at one instant are the motion before and after it.
    """
    interpolation, end = Interpolation(run), story_end(run)
    time = _nodes(interpolation, end)
    before, after = _columns(interpolation(time, "before")), _columns(interpolation(time))
    columns = {name: np.stack([np.hstack(before[name]), np.hstack(after[name])], axis=1) for name in after}
    jumps = [np.abs(np.diff(each, axis=1)).max(axis=(1, 2)) > 1e-9 for each in columns.values()]
    kept = np.stack([np.any(jumps, axis=0) & (time > time[0]), np.ones(time.size, dtype=bool)], axis=1)
    # To attoseconds and picometres, so that speeds within a short contact are true, and no more, to keep a page small.
    nodes = {name: np.round(each[kept], 9) for name, each in columns.items()}
    line, velocity = np.hsplit(nodes["line"], 2)
    return {
        "time": np.round(MILLISECONDS * np.stack([time, time], axis=1)[kept], 12).tolist(),
        "line": line.tolist(),
        "velocity": velocity.tolist(),
        "retraction": nodes["retraction"].tolist(),
        "force": nodes["force"][:, :1].tolist(),
        "hub": [float(run.hub_angle[0]), run.hub_speed / MILLISECONDS],
        "hubRadius": tool.hub.radius * MILLIMETRES,
        "wire": tool.bristle.wire_diameter * MILLIMETRES,
        "bar": None if tool.bar is None else [each * MILLIMETRES for each in (*tool.bar.centre, tool.bar.radius)],
        "surface": None if tool.workpart is None else -tool.workpart_depth * MILLIMETRES,
        "contacts": [
            [each.obstacle, *(1e3 * part for part in (each.time, each.duration, *each.impulse))]
            for each in run.contacts
            if each.time <= end
        ],
        "phases": [
            [MILLISECONDS * each.start, each.caption]
            for each in phases(run, STRIKE_SHOWN * (end - run.time[0]))
            if each.start <= end
        ],
    }


def _nodes(interpolation: Interpolation, end: float) -> Array:
    """Return the nodes, s, that make the page's interpolation exact to the digits shown."""
    time = np.unique(interpolation.course(end, 2).time)
    starts, ends, nodes = time[:-1], time[1:], [time]
    for _ in range(ROUNDS):
        tried = starts + TRIED * (ends - starts)
        motion = [interpolation(starts), interpolation(ends, "before"), interpolation(tried)]
        wrong = _differs(MILLISECONDS * (ends - starts), *map(_columns, motion))
        if not wrong.any():
            break
        middles = 0.5 * (starts + ends)[wrong]
        starts, ends = np.concatenate([starts[wrong], middles]), np.concatenate([middles, ends[wrong]])
        nodes.append(middles)
    return np.sort(np.concatenate(nodes))


def _columns(motion: Motion) -> Columns:
    """Return values and slopes of the interpolated quantities; m/s are mm/ms, and the force needs no slope."""
    shape, force = (motion.time.size, -1), motion.normal_force[:, np.newaxis]
    retraction, falling = np.degrees([motion.retraction, -motion.relative_rate / MILLISECONDS])[..., np.newaxis]
    velocity = motion.centre_line_velocity.reshape(shape)
    line = (motion.centre_line * MILLIMETRES).reshape(shape), velocity
    return {"line": line, "retraction": (retraction, falling), "force": (force, np.zeros_like(force))}


def _differs(length: Array, start: Columns, end: Columns, motion: Columns) -> Any:
    """Return for each interval, of a length in ms, whether the page's interpolation at TRIED is visibly wrong."""
    s, h, wrong = TRIED, length[:, np.newaxis], []
    for name, shown in SHOWN.items():
        (p, v), (q, w), (true, velocity) = start[name], end[name], motion[name]
        # Hermite's cubic from values and slopes at both ends, and its slope; of the force a straight line.
        place = q + (1.0 - s) ** 2 * (1.0 + 2.0 * s) * (p - q) + s * (1.0 - s) * h * ((1.0 - s) * v - s * w)
        slope = 6.0 * s * (s - 1.0) * (p - q) / h + (1.0 - s) * (1.0 - 3.0 * s) * v + s * (3.0 * s - 2.0) * w
        place = p + s * (q - p) if name == "force" else place
        wrong.append(np.abs(place - true).max(axis=1) > shown)
        if name == "line":
            speeds = (np.hypot(*each[:, -2:].T) for each in (slope, velocity))
            wrong.append(np.abs(np.subtract(*speeds)) > SPEED_SHOWN)
    return np.any(wrong, axis=0)
