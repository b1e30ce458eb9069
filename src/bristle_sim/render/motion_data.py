"""The motion of a run as plain numbers, from which a page interpolates the same motion as :meth:`Trajectory.at`."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.render.story import phases, story_end
from bristle_sim.render.style import MILLIMETRES, MILLISECONDS
from bristle_sim.trajectory import Interpolation, Motion, Trajectory

ROUNDS, TRIED = 12, 0.4
"""Most times that an interval is halved, and where in it the page's interpolation is tried: where errors do not cancel."""

SHOWN = {"line": 0.001, "speed": 0.01, "retraction": 0.001, "force": 0.0007}
"""Errors of the page's interpolation, a tenth of the last digit that it shows or less: mm, m/s, degrees and N."""

STRIKE_SHOWN = 0.01
"""Part of the run for which an impact at an instant is shown."""

PLAYED, IN_CONTACT = 8000, 0.08
"""Steps of the slider, a millisecond each when it plays, and the least part of them that a contact resolved in time gets."""


def motion_data(run: Trajectory, tool: Tool) -> dict[str, Any]:
    """Return a pass up to the end of its story: times in ms, lengths in mm, speeds in m/s, angles as JSON needs them.

    Between the nodes the page interpolates centre line and retraction by Hermite's cubics, the force linearly; there are as
    many as that takes. Nodes that share an instant are the motion before and after it.
    """
    interpolation, end = Interpolation(run), story_end(run)
    time = np.unique(interpolation.course(end, 2).time)
    starts, ends, added = time[:-1], time[1:], [time]
    for _ in range(ROUNDS):
        page = _between(interpolation(starts), interpolation(ends, "before"))
        wrong = _differs(interpolation(page.time), page)
        middles = 0.5 * (starts + ends)[wrong]
        starts, ends = np.concatenate([starts[wrong], middles]), np.concatenate([middles, ends[wrong]])
        added.append(middles)
        if not wrong.any():
            break
    time = np.sort(np.concatenate(added))
    before, after = interpolation(time, "before"), interpolation(time)
    columns = {name: np.stack([_columns(each)[name] for each in (before, after)], axis=1) for name in _columns(after)}
    double = np.any(
        [np.any(np.abs(np.diff(each, axis=1)) > 1e-9, axis=(1, 2)) for each in columns.values()], axis=0
    ) & (time > time[0])
    kept = np.stack([double, np.ones_like(double)], axis=1)
    bar, speed = tool.bar, run.hub_speed
    shown = [each for each in run.contacts if each.time <= end]
    return {
        # To attoseconds and picometres, so that speeds within a short contact are true, and no more, to keep a page small.
        "time": np.round(MILLISECONDS * np.stack([time, time], axis=1)[kept], 12).tolist(),
        **{name: np.round(each[kept], 9).tolist() for name, each in columns.items()},
        "hub": [float(run.hub_angle[0]), speed / MILLISECONDS],
        "clock": _clock(run, end).tolist(),
        "hubRadius": tool.hub.radius * MILLIMETRES,
        "wire": tool.bristle.wire_diameter * MILLIMETRES,
        "bar": None if bar is None else [each * MILLIMETRES for each in (*bar.centre, bar.radius)],
        "surface": None if tool.workpart is None else -tool.workpart_depth * MILLIMETRES,
        "contacts": [
            [each.obstacle, *(1e3 * part for part in (each.time, each.duration, *each.impulse))] for each in shown
        ],
        "phases": [
            [MILLISECONDS * each.start, each.caption]
            for each in phases(run, STRIKE_SHOWN * (end - run.time[0]))
            if each.start <= end
        ],
    }


def _columns(motion: Motion) -> dict[str, Array]:
    """Return the columns of the nodes, each of shape (n, m); m/s are mm/ms."""
    count = motion.time.size
    angle = np.degrees([motion.retraction, -motion.relative_rate / MILLISECONDS])
    return {
        "line": (motion.centre_line * MILLIMETRES).reshape(count, -1),
        "velocity": motion.centre_line_velocity.reshape(count, -1),
        "retraction": np.asarray(angle.T),
        "force": motion.normal_force[:, np.newaxis],
    }


def _between(start: Motion, end: Motion) -> Motion:
    """Return the motion a part TRIED of the way between nodes as the page has it."""
    s, step = TRIED, end.time - start.time

    def cubic(name: str, slope: str, sign: float = 1.0) -> tuple[Array, Array]:
        """Return Hermite's cubic and its slope."""
        p, v, q, w = (getattr(each, key) for each, key in ((start, name), (start, slope), (end, name), (end, slope)))
        h = step.reshape(-1, *[1] * (p.ndim - 1))
        v, w = sign * h * v, sign * h * w
        place = q + (1.0 - s) ** 2 * (1.0 + 2.0 * s) * (p - q) + s * (1.0 - s) * ((1.0 - s) * v - s * w)
        return place, (6.0 * s * (s - 1.0) * (p - q) + (1.0 - s) * (1.0 - 3.0 * s) * v + s * (3.0 * s - 2.0) * w) / h

    line, velocity = cubic("centre_line", "centre_line_velocity")
    retraction, _ = cubic("retraction", "relative_rate", -1.0)
    return dataclasses.replace(
        start,
        time=start.time + s * step,
        centre_line=line,
        centre_line_velocity=velocity,
        angles=-retraction[:, np.newaxis],
        hub_angle=np.zeros_like(step),
        normal_force=start.normal_force + s * (end.normal_force - start.normal_force),
    )


def _differs(one: Motion, other: Motion) -> Any:
    """Return at which instants two motions differ by what a page would show."""
    differences = {
        "line": MILLIMETRES * np.abs(one.centre_line - other.centre_line).max(axis=(1, 2)),
        "speed": np.abs(one.tip_speed - other.tip_speed),
        "retraction": np.degrees(np.abs(one.retraction - other.retraction)),
        "force": np.abs(one.normal_force - other.normal_force),
    }
    return np.any([found > SHOWN[name] for name, found in differences.items()], axis=0)


def _clock(run: Trajectory, end: float) -> Array:
    """Return steps of the slider and instants, ms, shape (n, 2): contacts resolved in time are shown more slowly."""
    start = float(run.time[0])
    slow = [(each.time, each.time + each.duration) for each in run.contacts if each.history is not None]
    slow = [(first, last) for first, last in slow if last <= end]
    instants = np.unique([start, end, *(each for pair in slow for each in pair)])
    parts = np.diff(instants) / (end - start)
    least = IN_CONTACT / max(1.0, 0.5 * len(slow))
    parts = np.where(np.isin(instants[:-1], [first for first, _ in slow]), np.maximum(parts, least), parts)
    steps = np.concatenate([[0.0], np.cumsum(parts) / parts.sum()]) * PLAYED
    return np.stack([steps, MILLISECONDS * instants], axis=1)
