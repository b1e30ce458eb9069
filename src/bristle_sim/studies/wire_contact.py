"""Where a rigid wire touches bar or workpart, from the tool's parameters and its centre line, apart from the scene.

Points and directions are complex numbers x + i y from the hub's centre, m; arrays have n instants first.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool

Points = NDArray[np.complex128]


def complex_points(points: Any) -> Points:
    """Return points or vectors with their coordinates in the last axis as complex numbers."""
    return np.asarray(points @ np.array([1.0, 1j]))


def wire_lines(tool: Tool, hub_angle: Array, angle: Array) -> Points:
    """Return root, knee and tip of the wire's centre line, shape (n, corners); angles in rad."""
    path = complex_points(np.array([(0.0, 0.0), *tool.bristle.path]))
    return np.asarray(
        -1j * tool.hub.radius * np.exp(1j * hub_angle)[:, np.newaxis] + np.outer(np.exp(1j * angle), path)
    )


def levers(normal: Points, point: Points) -> Array:
    """Return the moments about the origin of unit normal and tangential forces at a point, shape (n, 2), m."""
    arm = np.conj(point) * normal
    return np.stack([arm.imag, -arm.real], axis=-1)


def nearest(tool: Tool, lines: Points) -> tuple[Array, Array, Points]:
    """Return the piece of each centre line, shape (n, corners), nearest to the bar, the fraction along it, and the point."""
    assert tool.bar is not None
    centre, start, along = complex(*tool.bar.centre), lines[:, :-1], np.diff(lines, axis=1)
    fraction = np.clip((np.conj(along) * (centre - start)).real / abs(along) ** 2, 0.0, 1.0)
    points = start + fraction * along
    piece, each = abs(points - centre).argmin(axis=-1), np.arange(len(lines))
    return piece, fraction[each, piece], points[each, piece]


def touched(tool: Tool, obstacle: str, lines: Points) -> tuple[Points, Points]:
    """Return the obstacle's normal and the contact point of each centre line, each of shape (n,)."""
    if obstacle == "workpart":
        return np.full(len(lines), 1j), lines[:, -1]
    assert tool.bar is not None
    point = nearest(tool, lines)[2]
    away = point - complex(*tool.bar.centre)
    normal = away / abs(away)
    return normal, point - 0.5 * tool.bristle.wire_diameter * normal
