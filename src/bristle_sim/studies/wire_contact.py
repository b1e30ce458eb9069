"""Where a rigid wire touches bar or workpart, from the tool's parameters and angles, apart from the scene.

Arrays have n instants first; places are from the hub's centre, m, angles in rad.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool


def turned(vector: Sequence[float], angle: Array) -> Array:
    """Return a vector that belongs to angle 0, turned by each angle; shape (n, 2)."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([cos * vector[0] - sin * vector[1], sin * vector[0] + cos * vector[1]], axis=-1)


def right(vectors: Array) -> Array:
    """Turn vectors by a quarter turn to the right: normals into tangents."""
    return np.stack([vectors[..., 1], -vectors[..., 0]], axis=-1)


def cross(first: Array, second: Array) -> Array:
    """Return the moment of the second vector at the first, or of each pair; shape (n,)."""
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])


def levers(normal: Array, point: Array) -> Array:
    """Return the moments about the origin of unit normal and tangential forces at a point, shape (n, 2), m."""
    return np.stack([cross(point, each) for each in (normal, right(normal))], axis=-1)


def corners(tool: Tool, hub_angle: Array, angle: Array) -> Array:
    """Return the corners of the wire's centre line, shape (n, corners, 2), m."""
    root = turned((0.0, -tool.hub.radius), hub_angle)
    return np.stack([root, *(root + turned(corner, angle) for corner in tool.bristle.path)], axis=1)


def nearest(tool: Tool, lines: Array) -> tuple[Array, Array, Array]:
    """Return the piece of each centre line that is nearest to the bar, the fraction along it, and the point there."""
    assert tool.bar is not None
    start, along = lines[:, :-1], np.diff(lines, axis=1)
    fraction = ((np.array(tool.bar.centre) - start) * along).sum(axis=-1) / (along**2).sum(axis=-1)
    fraction = np.clip(fraction, 0.0, 1.0)
    points = start + fraction[..., np.newaxis] * along
    piece = np.linalg.norm(points - np.array(tool.bar.centre), axis=-1).argmin(axis=-1)
    each = np.arange(len(piece))
    return piece, fraction[each, piece], points[each, piece]


def touched(tool: Tool, obstacle: str, lines: Array) -> tuple[Array, Array]:
    """Return the obstacle's normal and the contact point of each centre line, each of shape (n, 2)."""
    if obstacle == "workpart":
        return np.broadcast_to([0.0, 1.0], (len(lines), 2)), lines[:, -1]
    assert tool.bar is not None
    point = nearest(tool, lines)[2]
    away = point - np.array(tool.bar.centre)
    normal = away / np.linalg.norm(away, axis=-1, keepdims=True)
    return normal, point - 0.5 * tool.bristle.wire_diameter * normal
