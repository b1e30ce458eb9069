"""Contacts of a step are divided into those at rest, which the engine keeps, and impacts, which a law resolves."""

from __future__ import annotations

import pymunk

from bristle_sim.contact_space.engine_calls import approach_reader, contact_tuner
from bristle_sim.contact_space.jacobian import Vector, joined
from bristle_sim.contact_space.sequence import ROUNDING
from bristle_sim.contact_space.step_motion import StepMotion

STEPS_OF_GRAVITY = 2.0
"""An approach that gravity makes up in this number of steps is rest: one step passes before the engine finds a contact that
forms, and a bounce that is over in less than two cannot be resolved."""

OUT_OF_REACH = 1e100
"""A surface velocity apart, at which the engine's contact has no impulse to give."""


class RestFilter:
    """Keeps the engine from responding to contacts that approach faster than at rest.

    Attributes:
        space: the space.
        resting_speed: slower approach is rest.
        skipped: contacts of this step that the engine was kept from, with their shapes and surface velocity.
        jammed: contacts that jammed in the last step; they are left to the engine while they last.
        still_jammed: those of them that were met in this step.
        motion: of the bodies of skipped contacts, and of those joined to them.
        active: whether a step is being taken.
        resting: approach at rest in this step; None before its first contact.
    """

    def __init__(self, space: pymunk.Space, resting_speed: float) -> None:
        """Nothing has touched yet."""
        self.space = space
        self.resting_speed = resting_speed
        self.skipped: dict[frozenset[pymunk.Shape], tuple[tuple[pymunk.Shape, pymunk.Shape], Vector]] = {}
        self.jammed: set[frozenset[pymunk.Shape]] = set()
        self.still_jammed: set[frozenset[pymunk.Shape]] = set()
        self.motion = StepMotion()
        self.active = False
        self.resting: float | None = None
        self._approach_of, self._tune = approach_reader(space), contact_tuner(space)

    def begin(self, resting_speed: float) -> None:
        """Begin a step."""
        self.resting_speed, self.active, self.resting = resting_speed, True, None

    def end(self) -> None:
        """End a step: contacts that jammed and were not met again are over."""
        self.active = False
        if self.jammed:
            self.jammed, self.still_jammed = self.still_jammed, set()

    def resting_approach(self) -> float:
        """Return the largest approach that counts as rest in the last step."""
        return max(self.resting_speed, STEPS_OF_GRAVITY * self.space.gravity.length * self.space.current_time_step)

    def divide(self, friction: float, arbiter: pymunk.Arbiter) -> None:
        """Leave a contact at rest to the engine, with this friction and no restitution; keep the engine from an impact."""
        if not self.active:
            return
        if self.resting is None:
            self.resting = self.resting_approach()
        approach, speeds = self._approach_of(arbiter)
        # Contacts at rest are many; their shapes are not even looked up.
        if (approach <= self.resting or approach <= ROUNDING * speeds) and not self.jammed:
            self._tune(arbiter, friction)
            return
        shapes = arbiter.shapes
        jams = frozenset(shapes) in self.jammed
        if jams:
            self.still_jammed.add(frozenset(shapes))
        if jams or approach <= self.resting or approach <= ROUNDING * speeds:
            self._tune(arbiter, friction)
            return
        # The engine keeps the contact and wakes its bodies, but takes it to fly apart, and to have no overlap to reduce.
        for each in shapes:
            if each.body is not None:
                self.motion.note(joined([each.body]))
        normal, slide = arbiter.normal, arbiter.surface_velocity
        self.skipped[frozenset(shapes)] = (shapes, (slide.x, slide.y))
        self._tune(arbiter, 0.0)
        found = arbiter.contact_point_set
        for point in found.points:
            point.point_b = point.point_a
        arbiter.contact_point_set = found
        arbiter.surface_velocity = (OUT_OF_REACH * normal.x, OUT_OF_REACH * normal.y)

    def surface_velocity(self, shapes: tuple[pymunk.Shape, pymunk.Shape]) -> Vector | None:
        """Return the surface velocity that a skipped contact had, of the second shape less the first; None for others."""
        if frozenset(shapes) not in self.skipped:
            return None
        (first, _), (x, y) = self.skipped[frozenset(shapes)]
        return (x, y) if first is shapes[0] else (-x, -y)
