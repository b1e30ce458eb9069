"""The scene: a mechanism as bodies, joints and springs of the engine pymunk, in engine units.

It contains only the effects that are requested. The engine's corrections of position errors are
switched off. Joints are not pulled together (``error_bias`` 1), because a correction would feed
position errors into the velocities. An interval of motion starts from bodies placed exactly on
their joints; the drift off the joints within the interval is smooth in the step, so it vanishes
when the step is extrapolated to zero. For the same reason touching shapes are not pushed apart
(``collision_bias`` 1, ``collision_slop`` above the margin of the shapes).
"""

from __future__ import annotations

import cmath
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pymunk

from bristle_sim.scene.engine import EngineSpace
from bristle_sim.scene.mechanism import Mechanism, State, xy
from bristle_sim.scene.pairs import ContactPair
from bristle_sim.scene.solver import LinkVelocity, WireVelocities

SHAPE_MARGIN = 0.02
"""Length by which the engine's shapes of obstacles are enlarged, over the link's length. The engine
then detects each touch. It corrects no position, because the overlap is within its tolerance."""


@dataclass(frozen=True, slots=True)
class Effects:
    """Springs, damping, gravity and contacts of a scene, in engine units; None, 0 and () leave an
    effect out.

    Attributes:
        stiffness: stiffness of the torsion spring between the hub and the first link of each wire.
        damping: damping of the torsion spring between hub and first link.
        gravity: acceleration of gravity, along -y.
        pairs: pairs of bodies that can touch.
        hinges: (stiffness, damping) of the torsion spring in each joint between two links of a
            wire. The springs are unstressed where all links have the same angle.
    """

    stiffness: float | None = None
    damping: float = 0.0
    gravity: float = 0.0
    pairs: tuple[ContactPair, ...] = ()
    hinges: tuple[tuple[float, float], ...] = ()


class Scene(EngineSpace):
    """A mechanism as bodies, joints and springs of the engine.

    Attributes, besides those of ``EngineSpace``:
        mechanism: the links and the hub's motion.
        effects: springs, damping, gravity and contacts.
        placed: state and drift of the last call of ``place``.
        turned: whole revolutions (rad) that are subtracted from all angles in the engine.
    """

    def __init__(self, mechanism: Mechanism, effects: Effects) -> None:
        """Build the engine's bodies, joints and springs; all links are at angle 0 until placed."""
        self.mechanism = mechanism
        self.effects = effects
        space = pymunk.Space()
        space.iterations = 1  # enough for one joint; the joints of several links are solved for
        space.collision_slop = 10.0 * SHAPE_MARGIN
        space.collision_bias = 1.0
        space.collision_persistence = 1  # steps that the engine keeps a contact that has ended, which a record would read again
        if effects.gravity:
            space.gravity = (0.0, -effects.gravity)
        hub = None
        if mechanism.hub_radius or effects.stiffness is not None:
            hub = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
            hub.angular_velocity = mechanism.hub_speed
            space.add(hub)
        links, joints = _add_links(space, mechanism, hub)
        _add_springs(space, mechanism, effects, hub, links)
        belt = effects.damping if effects.stiffness is not None else 0.0
        hinges = effects.hinges or ((0.0, 0.0),) * (mechanism.wire_links - 1)
        damping = [belt, *(hinge for _, hinge in hinges)]
        make_solver = LinkVelocity if mechanism.single_link else WireVelocities
        solver = make_solver(mechanism, damping, hub, links)
        super().__init__(space, hub, links, joints, solver, jointed=mechanism.jointed)
        self.turned = 0.0
        self.placed: tuple[State | None, float] = (None, 0.0)

    def place(self, state: State, drift: float = 0.0) -> None:
        """Set positions and velocities of all bodies to a state.

        Each body is then moved at its own constant velocity for the time ``drift``, which may be
        negative.
        """
        again = self.placed[0] is state and self.placed[1] == drift
        self.placed = (state, drift)
        if again:
            # Repetitions of one interval all start from one state.
            self.put(None)
            return
        values: list[float] = []
        if self.hub is not None:
            hub_angle = self.mechanism.root_angle(state.time + drift)
            # Rounding of an angle grows with its size, and extrapolation magnifies it.
            self.turned = math.tau * round(hub_angle / math.tau)
            values += (0.0, 0.0, hub_angle - self.turned, 0.0, 0.0, self.mechanism.hub_speed)
        for pose, angle, rate in zip(
            self.mechanism.poses(state), state.angles, state.rates, strict=True
        ):
            velocity = pose.velocity + 1j * rate * pose.to_centre
            place = pose.joint + pose.to_centre + drift * velocity
            turned = angle - self.turned + drift * rate
            values += (place.real, place.imag, turned, velocity.real, velocity.imag, rate)
        self.put(values)

    def state_at(self, time: float, values: Sequence[float]) -> State:
        """Return the state from a list that begins with the links' angles and rates in the engine."""
        links = len(self.links)
        angles = [angle + self.turned for angle in values[:links]]
        return State(time, tuple(angles), tuple(values[links : 2 * links]))


def _add_links(
    space: pymunk.Space, mechanism: Mechanism, hub: pymunk.Body | None
) -> tuple[list[pymunk.Body], list[pymunk.PivotJoint]]:
    """Add every link and its pivot to a space, and return them in order from the root."""
    bodies = []
    joints = []
    for number, link in enumerate(mechanism.links):
        if number % mechanism.wire_links == 0:
            carrier = hub or space.static_body
            lag = number // mechanism.wire_links * mechanism.pitch
            anchor = -1j * cmath.rect(mechanism.hub_radius, -lag)
        body = pymunk.Body(link.mass, link.inertia)
        joint = pymunk.PivotJoint(carrier, body, xy(anchor), xy(-link.centre))
        joint.error_bias = 1.0
        space.add(body, joint)
        bodies.append(body)
        joints.append(joint)
        carrier = body
        anchor = link.corners[-1] - link.centre
    return bodies, joints


def _add_springs(
    space: pymunk.Space,
    mechanism: Mechanism,
    effects: Effects,
    hub: pymunk.Body | None,
    links: list[pymunk.Body],
) -> None:
    """Add the belt of every wire, and a torsion spring at each joint between links.

    The springs must be added after the joints: the engine then damps velocities that the joints
    have corrected already, and the result stays smooth in the step.
    """
    size = mechanism.wire_links
    if hub is not None and effects.stiffness is not None:
        for wire, link in enumerate(links[::size]):
            spring = (wire * mechanism.pitch, effects.stiffness, effects.damping)
            space.add(pymunk.DampedRotarySpring(hub, link, *spring))
    joints = [pair for number, pair in enumerate(itertools.pairwise(links), 1) if number % size]
    hinges = effects.hinges * mechanism.wires
    for (stiffness, damping), (first, second) in zip(hinges, joints, strict=False):
        space.add(pymunk.DampedRotarySpring(first, second, 0.0, stiffness, damping))


MOST_DAMPING = 8.0
"""Longest interval, in time constants of the engine's damping: two time constants for each of the
four steps of the coarsest repetition. In a far longer step damping removes the whole rate, whatever
the length of the step. All repetitions would then agree that the belt does not move, and the error
estimate would miss the error."""


def damped_interval(scene: Scene) -> float:
    """Return the longest interval in which the engine's steps resolve the damping.

    The engine damps the links as free bodies, before the joints correct their velocities. Without
    damping the interval is infinite.
    """
    links = scene.mechanism.links
    belt = scene.effects.damping / links[0].inertia
    joints = zip(scene.effects.hinges, links, links[1:], strict=False)
    rate = max(
        [belt, *(damping * (1.0 / a.inertia + 1.0 / b.inertia) for (_, damping), a, b in joints)]
    )
    return MOST_DAMPING / rate if rate else math.inf


def time_scale(scene: Scene) -> float:
    """Return the time scale of the motion: 1/omega of the fastest bending mode of the straight
    chain, at most 1, in scene units.
    """
    if not (hinges := scene.effects.hinges):
        return 1.0
    wire = scene.mechanism.wire(0)
    links = len(wire.links)
    twists = np.eye(links)[1:] - np.eye(links)[:-1]
    stiffness = twists.T @ np.diag([each for each, _ in hinges]) @ twists
    mass = wire.mass_matrix(np.ones(links, complex))
    return 1.0 / math.sqrt(
        max(1.0, np.abs(np.linalg.eigvals(np.linalg.solve(mass, stiffness))).max())
    )


def motion_scale(scene: Scene, start: State) -> float:
    """Return the scale of a motion's errors: the relative rate that a free bristle reaches, at most
    1, in scene units.

    A bristle of natural frequency w that is released at rest at the angle a reaches the rate a w.
    The scale is 1 for a bristle that does not move and for several links. With an obstacle the
    scale is 1 too, because the bar gives the bristle a rate of the order of the hub's speed.
    """
    mechanism = scene.mechanism
    effects = scene.effects
    link = scene.mechanism.links[0]
    if effects.pairs or not mechanism.single_link:
        return 1.0
    field = mechanism.hub_radius * mechanism.hub_speed**2 + effects.gravity
    stiffness = (effects.stiffness or 0.0) + link.mass * abs(link.centre) * field
    swing = abs(start.angles[0] - mechanism.root_angle(start.time)) * math.sqrt(
        stiffness / link.inertia_about_joint
    )
    return min(max(swing, abs(start.rates[0] - mechanism.hub_speed)), 1.0) or 1.0
