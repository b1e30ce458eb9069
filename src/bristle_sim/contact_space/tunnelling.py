"""A warning if shapes pass through each other within one step.

The engine looks for contacts only at the ends of steps. The engine separates two shapes in the
direction of least overlap. This is the right direction only while their centres have not passed
each other. With the least widths a and b of the shapes and the approach speed v, a step of length h
is short enough if v h <= (a + b)/2. A dynamic body that moves farther is followed along the
straight line of its next step. The body passes through a shape on this line if it does not touch
the shape at the beginning and is beside or beyond the shape at the end. Other shapes are treated as
at rest; rotation is neglected.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Collection
from typing import Any

import numpy as np
import pymunk
from pymunk.batch import BodyFields, Buffer, get_space_bodies

UNWATCHED_STEPS = 16
"""Number of steps from one reading of all speeds to the next while no body is fast.

A reading takes 5 us; a step without contacts takes 1 us."""

Types = tuple[int, int]


class TunnellingWatch:
    """Warns once if a body passes through a shape with which it should collide.

    Only a fast body, which moves in a step by more than the width of the narrowest shape, can pass
    through a shape. To save time, the speeds of all bodies are read only in every sixteenth step.
    The speeds are read in every step while a body is fast, and in the step after the number of
    shapes has changed. The least widths of the shapes are computed when their number changes.

    Attributes:
        warned: whether the warning has been given. Speeds are not read after the warning.
    """

    def __init__(self) -> None:
        self.warned = False
        self._unwatched = 0
        self._shapes = -1
        self._least_extent = 0.0

    def watch(self, space: pymunk.Space, pairs: Collection[Types], duration: float) -> None:
        """Warn if a body will pass through a shape in the next step.

        Args:
            space: the space.
            pairs: pairs of collision types whose shapes should collide.
            duration: duration of the step.
        """
        if len(space._shapes) != self._shapes:
            self._shapes = len(space._shapes)
            types = {kind for pair in pairs for kind in pair}
            self._least_extent = min(
                (least_extent(s) for s in space.shapes if s.collision_type in types),
                default=math.inf,
            )
        elif self._unwatched:
            self._unwatched -= 1
            return
        velocities = Buffer()
        get_space_bodies(space, BodyFields.VELOCITY, velocities)
        speeds = np.abs(np.frombuffer(velocities.float_buf()))
        # A speed is at most the square root of two times its larger component.
        if math.sqrt(2.0) * float(speeds.max(initial=0.0)) * duration <= self._least_extent:
            self._unwatched = UNWATCHED_STEPS - 1
            return
        for body in space.bodies:
            fast = body.velocity.length * duration > self._least_extent
            if fast and body.body_type == pymunk.Body.DYNAMIC and not self.warned:
                self._follow(space, pairs, body, duration)

    def _follow(
        self, space: pymunk.Space, pairs: Collection[Types], body: pymunk.Body, duration: float
    ) -> None:
        """Warn if ``body`` will pass through a shape in the next step."""
        speed = body.velocity.length
        for shape in body.shapes:
            extent = least_extent(shape)
            start = shape.cache_bb().center()
            end = start + body.velocity * duration
            for hit in space.segment_query(start, end, 0.5 * extent, shape.filter):
                other: Any = hit.shape
                types = (shape.collision_type, other.collision_type)
                if types not in pairs and types[::-1] not in pairs:
                    continue
                if other.body is body or shape.sensor or other.sensor:
                    continue
                longest = 0.5 * (extent + least_extent(other)) / speed
                before = other.point_query(start)
                after = other.point_query(end)
                beyond = after.distance > 0.5 * extent or after.gradient.dot(hit.normal) < 0.0
                if before.distance > 0.5 * extent and beyond and duration > longest:
                    self.warned = True
                    warnings.warn(
                        f"duration = {duration:g}: a body at the speed {speed:g} moves by {speed * duration:g} in a step and"
                        f" passes a shape without a contact; take steps of at most {longest:.3g}",
                        RuntimeWarning,
                        stacklevel=4,
                    )
                    return


def least_extent(shape: pymunk.Shape) -> float:
    """Return the least width of a shape over all directions."""
    if not isinstance(shape, pymunk.Poly):
        return 2.0 * shape.radius  # type: ignore[no-any-return]
    corners = np.array(shape.get_vertices())
    edges = np.roll(corners, -1, axis=0) - corners
    normals = np.stack([edges[:, 1], -edges[:, 0]]) / np.hypot(*edges.T)
    # The least width of a convex polygon is that across one of its edges.
    return float(np.ptp(corners @ normals, axis=0).min()) + 2.0 * shape.radius
