"""Points where two shapes touch: read at the end of a step, and followed back to the instant of touch within it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from operator import attrgetter
from typing import NamedTuple

import pymunk

from bristle_sim.contact_space.contact_pair import ContactPair, LocatedImpact
from bristle_sim.contact_space.jacobian import Vector
from bristle_sim.contact_space.step_motion import StepMotion
from bristle_sim.theory.impact import Impact

HALVINGS = 4
"""A touch is looked for so often, each time half as long ago, until the shapes overlap half of that time later."""

FARTHER = 1.5
"""A touch is at most this many times as long ago as it seems at the end of the step."""

ENTRIES = attrgetter(*(each.name for each in fields(Impact)))
"""All entries of an impact's record."""


class Overlap(NamedTuple):
    """World coordinates of a contact, unit vector towards the first body, and overlap."""

    point: Vector
    normal: Vector
    depth: float

    def ahead(self, later: Overlap, factor: float) -> Overlap:
        """Extrapolate from this overlap over a later one."""
        (x, y), (u, v) = self.point, later.point
        normal = pymunk.Vec2d(*self.normal).interpolate_to(later.normal, factor).normalized()
        return Overlap((x + factor * (u - x), y + factor * (v - y)), (normal.x, normal.y), 0.0)


def overlaps(first: pymunk.Shape, second: pymunk.Shape) -> list[Overlap]:
    """Return the overlaps of two shapes where they were when their bounding boxes were last taken."""
    try:
        found = first.shapes_collide(second)
    except AssertionError:  # pymunk's answer for shapes apart
        return []
    x, y = found.normal
    ends = [(each.point_a, each.point_b) for each in found.points]
    # The distance that pymunk gives has the sign of one order of the shapes only.
    return [Overlap(((a.x + b.x) / 2, (a.y + b.y) / 2), (-x, -y), (a.x - b.x) * x + (a.y - b.y) * y) for a, b in ends]


@dataclass(slots=True, eq=False)
class TouchingPoint:
    """A point where two shapes touch, during one step.

    Attributes:
        pair: the pair of the shapes.
        shapes, bodies: the first body is dynamic.
        surface_velocity: of the second body's surface less that of the first, as conveyors have it.
        overlap: where they touch, at the end of the step or at the instant of touch; its depth is that at the end.
        drift: speed at which the overlap grew during the step.
        time: of the touch, before the end of the step.
        approach: speed at which the bodies approach at that instant.
        speed: largest speed of the two bodies here so far, to which ``approach`` is rounded.
        impacts: how many there were.
    """

    pair: ContactPair
    shapes: tuple[pymunk.Shape, pymunk.Shape]
    bodies: tuple[pymunk.Body, pymunk.Body]
    surface_velocity: Vector
    overlap: Overlap
    drift: float = 0.0
    time: float = 0.0
    approach: float = 0.0
    speed: float = 0.0
    impacts: int = 0

    def measure(self, motion: StepMotion, since: float, latest: float) -> None:
        """Take approach and time of the touch from the velocities as they are.

        ``since``: time before the end of the step at which velocities changed; ``latest``: the touch is not before that.
        """
        point, (x, y), depth = self.overlap
        growth, gain = self.surface_velocity[0] * x + self.surface_velocity[1] * y, 0.0
        for sign, body in ((-1.0, self.bodies[0]), (1.0, self.bodies[1])):
            (u, v, turn), (p, q, turning), centre = motion.state(body)
            arm_x, arm_y = point[0] - centre[0], point[1] - centre[1]
            u, v = u - turn * arm_y, v + turn * arm_x
            growth += sign * (u * x + v * y)
            gain += sign * ((p - turning * arm_y) * x + (q + turning * arm_x) * y)
            self.speed = max(self.speed, math.hypot(u, v))
        drift = growth - gain
        depth += since * (drift - self.drift)
        self.overlap, self.drift = Overlap(point, (x, y), depth), drift
        self.time = min(max(depth, 0.0) / drift if drift > 0.0 else math.inf if depth > 0.0 else 0.0, latest)
        self.approach = growth - motion.steps(self.time) * gain

    def go_back(self, motion: StepMotion, bodies: Sequence[pymunk.Body], latest: float) -> None:
        """Move the bodies that take part back to the touch, and take its place from the shapes on their way there."""
        time = self.time
        for _ in range(HALVINGS if time else 0):
            after = self._look()
            motion.drift(bodies, -0.5 * time)
            half = self._look()
            if after and half and half.depth > 0.0:
                growth = after.depth - half.depth
                touch = 0.5 * time * after.depth / growth if growth > 0.0 else math.inf
                self.time = min(touch, FARTHER * time, latest)
                place = after.ahead(half, 2.0 * self.time / time)
                self.overlap, self.drift = place._replace(depth=after.depth), 2.0 * growth / time
                motion.drift(bodies, 0.5 * time - self.time)
                return
            motion.drift(bodies, 0.5 * time)
            time *= 0.5
        self.time = 0.0

    def _look(self) -> Overlap | None:
        """Return the overlap of the shapes where their bodies are now, the nearest to the one known; None if there is none."""
        for each in self.shapes:
            each.cache_bb()
        found = overlaps(*self.shapes)
        return min(found, key=lambda each: math.dist(each.point, self.overlap.point), default=None)

    def located(self, impact: Impact, end: float) -> LocatedImpact:
        """Return the record of an impact here; ``end``: of the step."""
        point, normal, _ = self.overlap
        entries = (*ENTRIES(impact), end - self.time, point, normal, self.bodies)
        return LocatedImpact(*entries)


Shapes = frozenset[pymunk.Shape]
Contacts = dict[Shapes, list[TouchingPoint]]
"""Touching points by the two shapes."""


def read_contact(arbiter: pymunk.Arbiter, pair: ContactPair, slide: Vector | None = None) -> list[TouchingPoint]:
    """Return the points of a contact; ``slide``: surface velocity of its second shape less the first's, if known better."""
    shapes = first, second = arbiter.shapes
    slide = slide or arbiter.surface_velocity
    if first.body is None or first.body.body_type != pymunk.Body.DYNAMIC:
        shapes = second, first
        slide = (-slide[0], -slide[1])
    bodies = arbiter.bodies if shapes[0] is first else arbiter.bodies[::-1]
    return [TouchingPoint(pair, shapes, bodies, (slide[0], slide[1]), each) for each in overlaps(*shapes)]
