"""Impact laws.

An instantaneous law takes a scene, a state and a pair of bodies, and returns the state after the
impact and the contact record. A law that simulates the contact over its duration
(:mod:`bristle_sim.scene.compliant`) returns a spring instead, which acts in the simulation's loop.

To add a law, write a subclass of :class:`ContactLaw`, let ``contact_law`` in
:mod:`bristle_sim.scene.tool` return it, and add its name to the words of ``Contact.law``.
"""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pymunk

from bristle_sim.contact_space.impulse import ContactSpace, contact_space
from bristle_sim.scene.build import SHAPE_MARGIN, Scene
from bristle_sim.scene.mechanism import Pose, State, Vector, cross, xy
from bristle_sim.scene.pairs import BarPair, ClosestApproach, ContactPair, WorkpartPair, components
from bristle_sim.theory.impact import energetic_impact
from bristle_sim.trajectory import ContactRecord

# lever of a direction about the joint, over the distance from joint to contact point, below which
# it is rounding error: the point cannot move in this direction
LEVER_ROUNDING = 64.0 * math.ulp(1.0)


class ContactLaw(ABC):
    """The base class of impact laws.

    Attributes:
        name: the law's name in contact records.
        instantaneous: whether its impacts take no time.
    """

    name: ClassVar[str]
    instantaneous: ClassVar[bool] = True

    def known_to(self, error: float) -> ContactLaw:
        """Return the law adapted to the relative error of the velocities before the impact.

        The base class returns the law unchanged.
        """
        del error
        return self

    @abstractmethod
    def resolve(self, scene: Scene, state: State, pair: ContactPair) -> tuple[State, ContactRecord]:
        """Apply an instantaneous impact to the scene.

        Returns:
            The state after the impact and the contact record, in engine units.
        """

    def _after(
        self, scene: Scene, pair: ContactPair, before: State, **entries: Any
    ) -> tuple[State, ContactRecord]:
        """Return the state after an impact, and the contact record.

        The impact must already have changed the rates in the scene. ``entries`` are the entries of
        the record that depend on the law.
        """
        after = State(before.time, before.angles, tuple(scene.rates()))
        missing = dict.fromkeys(("compressive_impulse", "compressive_work", "restitutive_work"))
        return after, ContactRecord(
            obstacle=pair.name,
            law=self.name,
            time=before.time,
            duration=0.0,
            angles=before.angles,
            rates_before=before.rates,
            rates_after=after.rates,
            **{**missing, **entries},
        )


def contact_at(
    scene: Scene, state: State, pair: ContactPair
) -> tuple[ClosestApproach, ContactSpace]:
    """Place the scene's bodies at a state, and describe the contact of a pair.

    Returns:
        The closest approach of the two bodies, and the contact space: inverse mass matrix and
        velocity at the contact point.
    """
    scene.place(state)
    poses = scene.mechanism.poses(state)
    touch = pair.closest(poses, state.rates)
    if scene.mechanism.single_link:
        return touch, _of_single_link(scene, poses[0], touch)
    point = poses[pair.link].joint + touch.arm
    partner = None if pair.partner is None else scene.links[pair.partner]
    connected = scene.connected if scene.mechanism.wires == 1 else None
    return touch, contact_space(
        scene.links[pair.link], xy(point), xy(touch.normal), partner, connected=connected
    )


def _of_single_link(scene: Scene, pose: Pose, touch: ClosestApproach) -> ContactSpace:
    """Return the contact space of a link that turns about its joint.

    A unit impulse changes the angular velocity by l/I, with the lever l of its direction and the
    moment of inertia I about the joint. It changes the contact velocities by their levers times
    this amount. A contact point that sticks cannot move, unless it moves along the normal alone.
    """
    normal = cross(touch.arm, touch.normal)
    along = cross(touch.arm, touch.tangent)
    if abs(along) <= LEVER_ROUNDING * abs(touch.arm):
        along = 0.0
    levers = np.array([normal, along])
    turning = levers / scene.mechanism.links[0].inertia_about_joint
    response = np.outer((*xy(1j * (pose.centre - pose.joint)), 1.0), turning)
    return ContactSpace(
        inverse_mass=np.outer(levers, turning),
        velocity=touch.velocity,
        bodies=tuple(scene.links),
        response=response,
        in_stick=np.zeros(3) if along else response[:, 0],
        stick_compliance=0.0 if along else normal * float(turning[0]),
    )


@dataclass(frozen=True)
class EnergeticLaw(ContactLaw):
    """The instantaneous law of Stronge's energetic restitution with Coulomb friction.

    Attributes:
        accuracy: relative accuracy of the velocities before the impact.
        tangential_compliance: tangential compliance eta^2 of the contact, dimensionless.
    """

    accuracy: float = 0.0
    tangential_compliance: float = 0.0
    name = "energetic"

    def known_to(self, error: float) -> EnergeticLaw:
        """Return the law with the relative error of the velocities as its accuracy, if the error is
        smaller than the present accuracy.
        """
        return dataclasses.replace(self, accuracy=error) if error < self.accuracy else self

    def resolve(self, scene: Scene, state: State, pair: ContactPair) -> tuple[State, ContactRecord]:
        """Apply the impact to the velocities of all bodies in the scene.

        Returns:
            The state after the impact and the contact record, in engine units.
        """
        _, space = contact_at(scene, state, pair)
        space = ending_together(space, self.accuracy)
        impact = energetic_impact(
            space.inverse_mass,
            space.velocity,
            pair.friction,
            pair.restitution,
            pair.restitution_friction,
            space.stick_compliance,
            self.tangential_compliance,
        )
        impulse = (impact.impulse_normal, impact.impulse_tangential)
        velocity = (impact.velocity_normal, impact.velocity_tangential)
        space.apply(impulse, velocity)
        return self._after(
            scene,
            pair,
            state,
            outcome=impact.outcome_name,
            impulse=impulse,
            compressive_impulse=(
                impact.compressive_impulse_normal,
                impact.compressive_impulse_tangential,
            ),
            compressive_work=tuple(map(float, impact.compressive_work)),
            restitutive_work=tuple(map(float, impact.restitutive_work)),
            velocity_before=space.velocity,
            velocity_after=velocity,
            phases=impact.phases,
        )


def ending_together(space: ContactSpace, accuracy: float) -> ContactSpace:
    """Return the contact space with the slip velocity corrected so that slip and approach end
    together, if they do so within the accuracy.

    A contact point that has one degree of freedom moves such that v_t/v_n = K_nt/K_nn, with its
    slip velocity v_t, its normal velocity v_n and the contact-space inverse mass matrix K. Its slip
    and its approach end at the same impulse. If an error of v_t let the slip end earlier, the point
    would stick while it still approaches.
    """
    (normal, coupling), _ = space.inverse_mass.tolist()
    if space.stick_compliance or not normal:
        return space
    approach, slip = space.velocity
    exact = approach * coupling / normal
    near = abs(slip - exact) <= accuracy * math.hypot(approach, slip)
    return dataclasses.replace(space, velocity=(approach, exact)) if near else space


ENERGETIC = EnergeticLaw()  # the law of all contacts except those with the workpart

# length of the step in which the engine resolves an impact, scene time units; so short that the
# effect of forces and motion in it is less than rounding error
ENGINE_STEP = 1e-12
# half width and half depth of the workpart's shape, in link lengths: beyond any mechanism's reach
HALF_PLANE = 1e3
ENGINE_ITERATIONS = 10  # iterations of the engine's solver in this step, the engine's default


@dataclass(frozen=True)
class EngineLaw(ContactLaw):
    """The impact law of the physics engine, for comparison.

    The engine iterates with Newton's coefficient of restitution, which is its ``elasticity``, and
    limits the tangential impulse to the coefficient of friction times the accumulated normal
    impulse. The law has no phases and only one coefficient of friction. It may increase the energy
    of bodies that are joined in a chain.
    """

    name = "engine"

    def resolve(self, scene: Scene, state: State, pair: ContactPair) -> tuple[State, ContactRecord]:
        """Let the engine resolve the impact, in a step so short that nothing else happens in it.

        Returns:
            The state after the impact and the contact record, in engine units.
        """
        scene.place(state)
        mechanism = scene.mechanism
        touch = pair.closest(mechanism.poses(state), state.rates)
        impulse = engine_impact(scene, pair, touch)
        after = state._replace(rates=tuple(scene.rates()))
        velocity = pair.closest(mechanism.poses(after), after.rates).velocity
        return self._after(
            scene,
            pair,
            state,
            outcome="rebound" if velocity[0] > 0.0 else "no rebound",
            impulse=impulse,
            velocity_before=touch.velocity,
            velocity_after=velocity,
        )


def engine_impact(scene: Scene, pair: ContactPair, touch: ClosestApproach) -> Vector:
    """Let the engine resolve an impact in one short step.

    The scene must have been placed at the state of the impact. The obstacle's shape is larger than
    the obstacle by ``SHAPE_MARGIN``; the link is not enlarged, so the lever of friction is exact.
    The engine uses the pair's coefficients of restitution and friction as elasticity and friction.

    Returns:
        The normal and the tangential impulse on the link, in engine units.
    """
    space = scene.engine.space
    body = scene.links[pair.link]
    link = scene.mechanism.links[pair.link]
    corners = [xy(corner - link.centre) for corner in link.corners]
    obstacle: pymunk.Shape
    touching: pymunk.Shape
    if isinstance(pair, BarPair):
        obstacle = pymunk.Circle(space.static_body, pair.radius + SHAPE_MARGIN, xy(pair.centre))
        start, end = corners[touch.piece : touch.piece + 2]
        touching = pymunk.Segment(body, start, end, pair.wire_radius)
    else:
        assert isinstance(pair, WorkpartPair), (
            "the engine's own contacts are those of a link with a fixed obstacle"
        )
        middle = -pair.depth - HALF_PLANE
        face = ((-HALF_PLANE, middle), (HALF_PLANE, middle))
        obstacle = pymunk.Segment(space.static_body, *face, HALF_PLANE + SHAPE_MARGIN)
        touching = pymunk.Circle(body, 0.0, corners[pair.corner])
    for shape in (obstacle, touching):
        shape.friction = shape.elasticity = 1.0
    obstacle.friction = pair.friction
    obstacle.elasticity = pair.restitution
    impulses: list[pymunk.Vec2d] = []

    def note(arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        del space, data
        impulses.append(arbiter.total_impulse)

    space.add(obstacle, touching)
    space.on_collision(post_solve=note)
    before = space.iterations
    space.iterations = ENGINE_ITERATIONS
    scene.engine.step_alone(ENGINE_STEP)
    space.iterations = before
    space.on_collision()
    space.remove(obstacle, touching)
    if not impulses:
        return (0.0, 0.0)
    push, rub = components(complex(*impulses[0]), touch.normal)
    # The sign of the engine's impulse depends on the order of the shapes; a contact only pushes.
    return (push, rub) if push >= 0.0 else (-push, -rub)
