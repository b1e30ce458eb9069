"""The pymunk scene of a mechanism, built once by one function: exactly the effects it is requested, in engine units.

Biases and slop are set on purpose. Joints are not corrected (``error_bias`` 1): an interval of motion starts from bodies
placed exactly on their joints, and the drift within it is smooth in the step, so it vanishes when the step is
extrapolated to zero; a correction would feed position errors into the velocities. Touching shapes are not pushed apart
either (``collision_bias`` 1, slop above the shapes' margin), for the same reason.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import pymunk

from bristle_sim.scene.engine import placer, stepper
from bristle_sim.scene.mechanism import Link, Mechanism, Pose, State
from bristle_sim.scene.obstacles import MARGIN, Obstacle

__all__ = ["Effects", "Scene"]

HOLD_ITERATIONS = 30
"""Solver iterations while a link is held against an obstacle. Root joint and tip contact of a slender rod share a
quarter of their response, so each iteration leaves at most 1/4 of the error: 30 leave less than rounding."""

SOLVED = math.log(1e-17)
"""Iterations in flight leave this share of the joints' error: rounding."""

MOST_ITERATIONS = 40_000
"""Of the engine's solver in a step; a link 1e-3 times as heavy as the next one takes them."""

ITERATIONS_OF_A_STEP = 100
"""Solver iterations that take as long as the rest of an engine step: measured, 35 ns each and 3 to 5 us a step with what
Python does around it."""

WARM, ALONE = 1e3, 2.0
"""Steps up to so many times as long as the one before start from its impulses; the rounding of impulses that are scaled
further would show. A step on its own bears less: the engine scales the impulse that it applies, by s, but not the one that
it remembers, which becomes 1 - s times what it was. Further steps of the same length put that right; one short and one long
step in turn would make it grow without bound."""

_NOWHERE = pymunk.ShapeFilter(categories=0, mask=0)
_EVERYWHERE = pymunk.ShapeFilter()


@dataclass(frozen=True, slots=True)
class Effects:
    """What a scene holds besides its links; None and 0 leave an effect out altogether.

    Engine units: torsion spring and damping between hub and first link, gravity along -y, obstacles of the last link.
    """

    stiffness: float | None = None
    damping: float = 0.0
    gravity: float = 0.0
    obstacles: tuple[Obstacle, ...] = ()


class Scene:
    """A mechanism in a pymunk space.

    Attributes:
        mechanism, effects: what was built.
        space: the pymunk space.
        links: the dynamic bodies, in order from the root; ``joints`` are the pivots they hang on.
        hub: the kinematic body that carries the root, or None.
        steps: engine steps taken so far.
        work: the same, each counted once more for every ``ITERATIONS_OF_A_STEP`` iterations of the solver in it.
        motions: how often bodies have been moved so far, for who must know whether they are where they were left.
        turned: whole turns that the engine's angles leave out, rad.
    """

    def __init__(self, mechanism: Mechanism, effects: Effects) -> None:
        """Build the space; the links hang at angle 0 until placed."""
        self.mechanism = mechanism
        self.effects = effects
        self.steps = self.work = self.motions = 0
        self.turned = 0.0
        self._last_length = math.inf
        # Runs over one interval all start from one state.
        self._placed: tuple[State | None, list[Pose]] = (None, [])
        self.space = pymunk.Space()
        self.space.iterations = _flight_iterations(mechanism.links)
        self.space.collision_slop = 10.0 * MARGIN
        self.space.collision_bias = 1.0
        if effects.gravity:
            self.space.gravity = (0.0, -effects.gravity)
        self.hub = self._add_hub() if mechanism.hub_radius or effects.stiffness is not None else None
        self.links: list[pymunk.Body] = []
        self.joints: list[pymunk.PivotJoint] = []
        for link in mechanism.links:
            self._add_link(link)
        self._shapes: dict[str, list[pymunk.Shape]] = {}
        for obstacle in effects.obstacles:
            self._add_obstacle(obstacle)
        self._step = stepper(self.space)
        self._placers = [placer(body) for body in self.links]

    def _add_hub(self) -> pymunk.Body:
        hub = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        hub.angular_velocity = self.mechanism.hub_speed
        self.space.add(hub)
        return hub

    def _add_link(self, link: Link) -> None:
        body = pymunk.Body(link.mass, link.inertia)
        own = (-link.centre[0], -link.centre[1])
        if self.links:
            carrier, before = self.links[-1], self.mechanism.links[len(self.links) - 1]
            anchor = (before.tip[0] - before.centre[0], before.tip[1] - before.centre[1])
        elif self.hub is not None:
            carrier, anchor = self.hub, (0.0, -self.mechanism.hub_radius)
        else:
            carrier, anchor = self.space.static_body, (0.0, 0.0)
        joint = pymunk.PivotJoint(carrier, body, anchor, own)
        joint.error_bias = 1.0
        self.space.add(body, joint)
        if self.effects.stiffness is not None and carrier is self.hub:
            # After the joint: damping then sees velocities that the joint has settled, not what its warm start left of
            # an earlier step, and stays smooth in the step.
            belt = pymunk.DampedRotarySpring(carrier, body, 0.0, self.effects.stiffness, self.effects.damping)
            self.space.add(belt)
        self.links.append(body)
        self.joints.append(joint)

    def _add_obstacle(self, obstacle: Obstacle) -> None:
        last = self.mechanism.links[-1]
        corners = [(x - last.centre[0], y - last.centre[1]) for x, y in ((0.0, 0.0), *last.knees, last.tip)]
        shapes = obstacle.shapes(self.space, self.links[-1], corners)
        for shape in shapes:
            shape.filter = _NOWHERE
            shape.friction = 1.0
            shape.elasticity = 1.0
        self.space.add(*shapes)
        self._shapes[obstacle.name] = shapes

    def engage(
        self, obstacle: Obstacle, *, friction: float, elasticity: float, iterations: int, piece: int = 0
    ) -> None:
        """Let the engine's own contact act between a straight piece of the last link and an obstacle from now on."""
        shapes = self._shapes[obstacle.name]
        for index, shape in enumerate(shapes):
            # The obstacle's shape, larger than the obstacle, would touch a neighbouring piece before its time.
            shape.filter = _EVERYWHERE if index in (0, 1 + piece) else _NOWHERE
        shapes[0].friction, shapes[0].elasticity = friction, elasticity
        self.space.iterations = iterations

    def release(self, obstacle: Obstacle) -> None:
        """Let the engine ignore the obstacle again."""
        for shape in self._shapes[obstacle.name]:
            shape.filter = _NOWHERE
        self.space.iterations = _flight_iterations(self.mechanism.links)

    def place(self, state: State, drift: float = 0.0) -> None:
        """Put every body exactly where the state says, joints closed, velocities consistent.

        With a ``drift`` the bodies stand where their velocities, without forces, take them in that time.
        """
        self.motions += 1
        if self.hub is not None:
            hub_angle = self.mechanism.hub_angle(state.time + drift)
            # Rounding of an angle grows with its size, and extrapolation magnifies it.
            self.turned = math.tau * round(hub_angle / math.tau)
            self.hub.angle = hub_angle - self.turned
        if state is not self._placed[0]:
            self._placed = (state, self.mechanism.poses(state))
        for put, pose, angle, rate in zip(self._placers, self._placed[1], state.angles, state.rates, strict=True):
            (x, y), (u, v) = pose.centre, pose.centre_velocity
            put(angle - self.turned + drift * rate, (x + drift * u, y + drift * v), (u, v), rate)

    def angles(self) -> list[float]:
        """Angles of the links as they are in the engine, less ``turned``, rad."""
        return [body.angle for body in self.links]

    def rates(self) -> list[float]:
        """Absolute rates of the links as they are in the engine."""
        return [body.angular_velocity for body in self.links]

    def step(self, length: float, count: int, act: Callable[[float], None] | None = None) -> None:
        """Take ``count`` engine steps of one length; ``act`` is called before each of them with the length."""
        if length > (WARM if count > 1 else ALONE) * self._last_length:
            self._start_cold(length)
        self._last_length = length
        advance = self._step
        for _ in range(count):
            if act is not None:
                act(length)
            advance(length)
        self.steps += count
        self.work += count * (1 + self.space.iterations // ITERATIONS_OF_A_STEP)
        self.motions += 1

    def _start_cold(self, length: float) -> None:
        """Have the engine forget the impulses of its last step, which it would scale to the length of the next one."""
        bodies = self.links if self.hub is None else [self.hub, *self.links]
        kept = [(body.position, body.angle, body.velocity, body.angular_velocity) for body in bodies]
        for joint in self.joints:
            joint.max_force = 0.0
        # The first step still applies them, to bodies that are put back; the second leaves those of contacts right.
        for _ in range(2):
            self._step(length)
            for body, (position, angle, velocity, rate) in zip(bodies, kept, strict=True):
                body.position, body.angle, body.velocity, body.angular_velocity = position, angle, velocity, rate
        for joint in self.joints:
            joint.max_force = math.inf

    def drift(self, duration: float) -> None:
        """Move all bodies on (or back) at their velocities, without forces."""
        for body in self.links if self.hub is None else [self.hub, *self.links]:
            body.position += body.velocity * duration
            body.angle += body.angular_velocity * duration

    @property
    def solves_joints(self) -> bool:
        """Whether the engine's iterations suffice to solve the joints in flight."""
        return _flight_iterations(self.mechanism.links) < MOST_ITERATIONS

    def correct_joints(self, *, completely: bool) -> None:
        """Have the engine close the joints at every step, or leave them alone."""
        for joint in self.joints:
            joint.error_bias = 0.0 if completely else 1.0

    def contact_impulse(self) -> tuple[float, float]:
        """(normal, tangential) impulse of the last step on the last link, whatever it touches."""
        total = [0.0, 0.0]

        def add(arbiter: pymunk.Arbiter) -> None:
            # Which way the engine's normal points, and the sign of its impulse, depend on the order of the shapes inside
            # the engine; a contact only pushes, which settles both.
            normal, impulse = arbiter.normal, arbiter.total_impulse
            push = impulse.dot(normal)
            total[0] += abs(push)
            total[1] += math.copysign(1.0, push) * impulse.dot((normal.y, -normal.x))

        self.links[-1].each_arbiter(add)
        return total[0], total[1]


def _flight_iterations(links: Sequence[Link]) -> int:
    """Iterations that solve the joints to rounding.

    One joint is solved exactly at once. Along a link the joints at its ends share all of its response, so that each
    iteration leaves 1/(1 + r) of the error, r being the link's mass over the next one's; errors cross longer chains link
    by link.
    """
    if len(links) == 1:
        return 1
    ratio = min(link.mass / after.mass for link, after in itertools.pairwise(links))
    rounds = 2.0 - SOLVED / math.log1p(ratio) * (len(links) - 1) ** 2
    return math.ceil(min(rounds, MOST_ITERATIONS))
