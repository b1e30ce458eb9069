"""The scene: a mechanism as bodies, joints and springs of the engine pymunk, in engine units.

The scene contains only the effects that are requested. The engine's corrections of position errors
are switched off, because they would feed position errors into the velocities. Joints are not pulled
together (``error_bias`` 1). An interval of motion starts from bodies placed exactly on their
joints. The bodies drift off the joints within the interval. This drift is a smooth function of the
step, so extrapolation to zero step length removes it. Touching shapes are not pushed apart
(``collision_bias`` 1, ``collision_slop`` above the margin of the shapes).

Operations done thousands of times per simulation call the engine (Chipmunk) directly: a step
through pymunk's wrappers takes 0.77 us, of which the engine itself takes 0.34 us.
"""

from __future__ import annotations

import cmath
import math
from array import array
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from operator import sub
from typing import Any

import pymunk
from pymunk._chipmunk_cffi import ffi, lib

from bristle_sim.scene.mechanism import Mechanism, State, xy
from bristle_sim.scene.pairs import ClosedPair, ContactPair
from bristle_sim.scene.solver import LinkVelocity, WireVelocities

SHAPE_MARGIN = 0.02
"""Length by which the engine's shapes of obstacles are enlarged, as a fraction of the link's
length, so that the engine detects each touch. The overlap is within ``collision_slop``, so the
engine corrects no position."""

LONGEST_WARM_RATIO = 1e3
"""Largest ratio of a step's length to the length of the previous step at which the engine starts
from the joint impulses of the previous step. The engine multiplies these impulses by the ratio. At
a larger ratio the rounding error of the impulses would be noticeable."""

# number of links up to which a step counts once in ``work``; measured, the solver of the joints
# takes 17, 21, 31 and 60 us for 8, 16, 32 and 64 links
LINKS_OF_A_STEP = 32


@dataclass(frozen=True, slots=True)
class Effects:
    """Springs, damping, gravity and contacts of a scene, in engine units.

    An effect is absent if its value is 0 or ().

    Attributes:
        stiffness: stiffness of the torsion spring (the belt) between the hub and the first link of
            each wire.
        damping: damping of the torsion spring between hub and first link.
        gravity: acceleration of gravity, along -y.
        pairs: pairs of bodies that can touch.
        hinge: stiffness and damping of the torsion spring in each joint between two links of a
            wire. The springs are unstressed if all links have the same angle.
    """

    stiffness: float = 0.0
    damping: float = 0.0
    gravity: float = 0.0
    pairs: tuple[ContactPair, ...] = ()
    hinge: tuple[float, float] = (0.0, 0.0)


class Placer:
    """Sets and reads the positions and velocities of bodies, by one engine call for each body.

    Attributes:
        values: six numbers for each body, as last set or read: x and y of the mass centre, the
            angle, the velocity of the mass centre along x and y, and the angular velocity.
    """

    def __init__(self, bodies: Sequence[pymunk.Body]) -> None:
        """Prepare to set and read ``bodies``; later values are in the order of these bodies."""
        self._bodies = [body._body for body in bodies]
        # The array has room for one more body; otherwise the engine would move it to other memory.
        self.values = array("d", bytes(6 * 8 * (len(bodies) + 1)))
        self._numbers = ffi.new(
            "pmFloatArray *", (0, len(self.values), ffi.from_buffer("double[]", self.values))
        )
        fields = lib.POSITION | lib.ANGLE | lib.VELOCITY | lib.ANGULAR_VELOCITY
        self._data = ffi.new("pmBatchedData *", (ffi.NULL, self._numbers, fields))

    def __call__(self, values: Sequence[float] | None) -> None:
        """Set the bodies' positions and velocities; None sets the stored ``values`` again."""
        if values is not None:
            self.values[: len(values)] = array("d", values)
        self._numbers.num = 0
        put = lib.pmSpaceBodySetIteratorFuncBatched
        data = self._data
        for body in self._bodies:
            put(body, data)

    def keep(self) -> None:
        """Read the bodies' present positions and velocities into ``values``."""
        self._numbers.num = 0
        for body in self._bodies:
            lib.pmSpaceBodyGetIteratorFuncBatched(body, self._data)


class Scene:
    """A mechanism as bodies, joints and springs of the engine, and the steps taken in it.

    After each engine step, ``joint_solver`` corrects the velocities if a wire has several links or
    a sustained contact is closed.

    Attributes:
        mechanism: the links and the hub's motion.
        effects: springs, damping, gravity and contacts.
        space: the pymunk space.
        hub: kinematic body that carries the roots; without a hub, the space's static body.
        links: bodies of the links, in order from the root.
        joints: pivots of the links, in order from the root.
        joint_solver: solver of joints, damping and sustained contacts.
        couples_links: whether ``joint_solver`` solves for the velocities of several links together.
        put: sets positions and velocities of all bodies.
        steps: number of steps taken.
        work: cost of the steps taken. A step costs 1 for up to ``LINKS_OF_A_STEP`` links, 2 for up
            to twice as many links, and so on.
        placed: state and drift of the last call of ``place``.
        turned: multiple of 2 pi (rad) that is subtracted from all angles in the engine.
    """

    def __init__(self, mechanism: Mechanism, effects: Effects) -> None:
        """Build the engine's bodies, joints and springs; all links are at angle 0 until placed."""
        self.mechanism = mechanism
        self.effects = effects
        self.space = space = pymunk.Space()
        space.iterations = 1  # enough for one joint; the joints of several links are solved for
        space.collision_slop = 10.0 * SHAPE_MARGIN
        space.collision_bias = 1.0
        # Number of steps for which the engine stores a contact that has ended. A contact stored for
        # longer would be recorded a second time.
        space.collision_persistence = 1
        if effects.gravity:
            space.gravity = (0.0, -effects.gravity)
        self.hub = hub = space.static_body
        if mechanism.hub_radius or effects.stiffness:
            self.hub = hub = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
            hub.angular_velocity = mechanism.hub_speed
            space.add(hub)
        self.links, self.joints, springs = _add_links(space, mechanism, effects, hub)
        self._dampings = [(spring, spring.damping) for spring in springs if spring.damping]
        bodies = [hub, *self.links]
        self.put = Placer(bodies)
        self._links = [link._body for link in self.links]
        damping = [effects.damping] + [effects.hinge[1]] * (mechanism.wire_links - 1)
        self.joint_solver: Any
        if mechanism.single_link:
            self.joint_solver = LinkVelocity(mechanism, damping, hub, *self.links)
        else:
            self.joint_solver = WireVelocities(mechanism, damping, Placer(bodies))
        space.step(0.0)  # all that was added is in the space from here on
        # The pointer does not own the space. A reference to space._space must not exist longer than
        # the pymunk space. Otherwise the garbage collector, in another thread, may remove bodies,
        # shapes and constraints from the space while the space is being freed.
        bare = ffi.cast("cpSpace *", space._space)
        self._engine_step: Callable[[float], None] = partial(lib.cpSpaceStep, bare)
        self._last_length = math.inf
        self.steps = self.work = 0
        self.turned = 0.0
        self.placed: tuple[State | None, float] = (None, 0.0)
        self._solve: Callable[[float], None] | None = None
        self.keep_closed(())

    def keep_closed(self, contacts: Sequence[ClosedPair]) -> None:
        """Keep these contacts, and no others, closed in all further steps."""
        solving = bool(contacts) or self.mechanism.jointed
        self.couples_links = solving and not self.mechanism.single_link
        if solving is (self._solve is None):
            self._solve = self.joint_solver.solve if solving else None
            for spring, damping in self._dampings:
                spring.damping = 0.0 if solving else damping
        if solving:
            self.joint_solver.set_contacts(contacts)

    def place(self, state: State, drift: float = 0.0) -> None:
        """Set the positions and velocities of all bodies to those of a state.

        Each body is then moved for the time ``drift``, which may be negative, at constant velocity.
        """
        if self.placed[0] is state and self.placed[1] == drift:
            self.put(None)  # repetitions of one interval all start from one state
            return
        self.placed = (state, drift)
        hub_angle = self.mechanism.root_angle(state.time + drift)
        # The rounding error of an angle grows with the angle, and extrapolation amplifies it.
        self.turned = math.tau * round(hub_angle / math.tau)
        values = [0.0, 0.0, hub_angle - self.turned, 0.0, 0.0, self.mechanism.hub_speed]
        for pose, angle, rate in zip(
            self.mechanism.poses(state), state.angles, state.rates, strict=True
        ):
            velocity = pose.velocity + 1j * rate * pose.to_centre
            place = pose.joint + pose.to_centre + drift * velocity
            turned = angle - self.turned + drift * rate
            values += (place.real, place.imag, turned, velocity.real, velocity.imag, rate)
        self.put(values)

    def state_at(self, time: float, values: Sequence[float]) -> State:
        """Return the state at a time from the engine's values.

        ``values`` begins with the angles of all links in the engine, followed by their angular
        velocities.
        """
        links = len(self.links)
        angles = [angle + self.turned for angle in values[:links]]
        return State(time, tuple(angles), tuple(values[links : 2 * links]))

    def step_alone(self, length: float) -> None:
        """Take one engine step, without the correction of velocities by ``joint_solver``.

        The solver of the next step does not start from the joint impulses of this step.
        """
        self.steps += 1
        self._engine_step(length)
        self._last_length = 0.0

    def step(
        self,
        length: float,
        count: int,
        acts: Sequence[Callable[[], None]] = (),
        *,
        symmetric: bool = False,
        middle: list[list[float]] | None = None,
    ) -> list[float]:
        """Take engine steps of equal length from the state of the last call of ``place``.

        Args:
            length: length of a step.
            count: number of steps; even for symmetric steps.
            acts: functions called before each step, which apply the forces of contact springs.
            symmetric: whether the steps are symmetric in time. The bodies must then have been
                placed where they would have been half a step earlier.
            middle: list to which the function appends the angles and angular velocities of all
                links after half of the steps; None if they are not needed.

        Returns:
            One list of the angles of all links, then their angular velocities, then their mean
                angular accelerations in the last step (in the last two steps if ``symmetric``).
        """
        self.steps += count
        self.work += count * math.ceil(len(self._links) / LINKS_OF_A_STEP)
        if length > LONGEST_WARM_RATIO * self._last_length:
            self._forget_impulses(length)
        self._last_length = length
        if symmetric:
            self.joint_solver.begin_symmetric()
        self.joint_solver.impulses = []
        engine_step = self._engine_step
        solve = self._solve
        half = count // 2
        last = 2 if symmetric else 1
        links = self._links
        angle = lib.cpBodyGetAngle
        rate = lib.cpBodyGetAngularVelocity
        for left in range(count, 0, -1):
            if left == half and middle is not None:
                middle.append([*map(angle, links), *map(rate, links)])
            if left == last:
                before = [*map(rate, links)]
            for act in acts:
                act()
            engine_step(length)
            if solve is not None:
                solve(length)
        after = [*map(rate, links)]
        if len(links) == 1:
            # without lists, with which a pass would take a thirtieth longer
            return [angle(links[0]), *after, (after[0] - before[0]) / length]
        angles = [*map(angle, links)]
        if symmetric:
            self.joint_solver.symmetric = False
            angles = [a + 0.5 * length * rate for a, rate in zip(angles, after, strict=True)]
        return [*angles, *after, *[each / (last * length) for each in map(sub, after, before)]]

    def _forget_impulses(self, length: float) -> None:
        """Clear the joint impulses that the engine has stored, before steps of a greater length.

        Otherwise the engine would multiply the impulses by the ratio of the lengths.
        """
        for joint in self.joints:
            joint.max_force = 0.0
        # This step still applies the stored impulses, so the bodies are placed again after it.
        self._engine_step(length)
        self.put(None)
        for joint in self.joints:
            joint.max_force = math.inf

    def recover(self) -> None:
        """Remove numbers that are not finite from the engine after an overflow.

        The joints are replaced by new joints, which have no stored impulses from which a step would
        start. The bodies are placed, which makes their rotations finite. Their positions become
        finite only when they are placed a second time. The first time, the engine adds zero times
        the old rotation to a position, and this product is NaN if the rotation is not finite.
        """
        space = self.space
        springs = [each for each in space.constraints if each not in self.joints]
        space.remove(*space.constraints)
        self.joints = [
            pymunk.PivotJoint(each.a, each.b, each.anchor_a, each.anchor_b) for each in self.joints
        ]
        for joint in self.joints:
            joint.error_bias = 1.0
        space.add(*self.joints, *springs)
        self.put(None)


def _add_links(
    space: pymunk.Space, mechanism: Mechanism, effects: Effects, hub: pymunk.Body
) -> tuple[list[pymunk.Body], list[pymunk.PivotJoint], list[pymunk.DampedRotarySpring]]:
    """Add the links with their pivots and springs to a space.

    The springs must be added after the joints. The engine then damps velocities that the joints
    have already corrected, and the result is a smooth function of the step.

    Returns:
        The bodies, the pivots and the springs, each in order from the root.
    """
    bodies = []
    joints = []
    springs = []
    for number, link in enumerate(mechanism.links):
        wire, place = divmod(number, mechanism.wire_links)
        body = pymunk.Body(link.mass, link.inertia)
        if place == 0:
            carrier = hub
            lag = wire * mechanism.pitch
            anchor = -1j * cmath.rect(mechanism.hub_radius, -lag)
            if effects.stiffness:
                belt = (lag, effects.stiffness, effects.damping)
                springs.append(pymunk.DampedRotarySpring(carrier, body, *belt))
        elif effects.hinge[0]:
            springs.append(pymunk.DampedRotarySpring(carrier, body, 0.0, *effects.hinge))
        joint = pymunk.PivotJoint(carrier, body, xy(anchor), xy(-link.centre))
        joint.error_bias = 1.0
        space.add(body, joint)
        bodies.append(body)
        joints.append(joint)
        carrier = body
        anchor = link.corners[-1] - link.centre
    space.add(*springs)
    return bodies, joints, springs
