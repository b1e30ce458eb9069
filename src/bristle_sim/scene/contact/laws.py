"""Impact laws; each obstacle carries one.

An impact at an instant is resolved at once: scene, state, obstacle in; state after, contact record out. A law that resolves
the contact in time gives a spring instead, which acts in the run's own loop (:mod:`bristle_sim.scene.contact.compliant`).
To add a law, write a subclass of :class:`ContactLaw`, name it in :func:`contact_law` and among the words of ``Contact.law``.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from bristle_sim.contact_space.impulse import ContactSpace, contact_space
from bristle_sim.parameters import Contact
from bristle_sim.scene.mechanism import State, Vector
from bristle_sim.theory.impact import Impact, energetic_impact
from bristle_sim.trajectory import ContactRecord

if TYPE_CHECKING:
    from bristle_sim.scene.build import Scene
    from bristle_sim.scene.contact.obstacles import ClosestApproach, Obstacle
    from bristle_sim.scene.contact.spring import Spring


def energetic_at(obstacle: Obstacle, space: ContactSpace, tangential_compliance: float = 0.0) -> Impact:
    """Return the impact on an obstacle of rigid bodies with energetic restitution, and eta^2 of the contact."""
    coefficients = obstacle.friction, obstacle.restitution, obstacle.restitution_friction
    further = space.stick_compliance, tangential_compliance
    return energetic_impact(space.inverse_mass, space.velocity, *coefficients, *further)


class ContactLaw:
    """The base class of impact laws.

    Attributes:
        name: in contact records.
        at_once: whether its impacts take no time.
    """

    name: ClassVar[str]
    at_once: ClassVar[bool] = True

    def spring(self, scene: Scene, state: State, obstacle: Obstacle) -> Spring | None:
        """Return the spring of a contact that is resolved in time; None if the impact is instantaneous."""
        del scene, state, obstacle
        return None

    def resolve(self, scene: Scene, state: State, obstacle: Obstacle) -> tuple[State, ContactRecord]:
        """Apply an instantaneous impact to the scene; all values are in engine units."""
        raise NotImplementedError

    def _record(
        self,
        obstacle: Obstacle,
        before: State,
        rates: tuple[float, ...],
        outcome: str,
        impulse: Vector,
        velocities: tuple[Vector, Vector],
        impact: Impact | None = None,
    ) -> tuple[State, ContactRecord]:
        """Return the state after an impact, and its record; ``impact`` is None for a law without phases."""
        compressive: Vector | None = None
        works: tuple[Vector | None, Vector | None] = None, None
        if impact is not None:
            compressive = impact.compressive_impulse_normal, impact.compressive_impulse_tangential
            loaded, unloaded = impact.compressive_work, impact.restitutive_work
            works = (float(loaded[0]), float(loaded[1])), (float(unloaded[0]), float(unloaded[1]))
        return State(before.time, before.angles, rates), ContactRecord(
            obstacle=obstacle.name,
            law=self.name,
            outcome=outcome,
            time=before.time,
            duration=0.0,
            impulse=impulse,
            compressive_impulse=compressive,
            compressive_work=works[0],
            restitutive_work=works[1],
            velocity_before=velocities[0],
            velocity_after=velocities[1],
            angles=before.angles,
            rates_before=before.rates,
            rates_after=rates,
            phases=() if impact is None else impact.phases,
        )


def contact_at(scene: Scene, state: State, obstacle: Obstacle) -> tuple[ClosestApproach, ContactSpace]:
    """Place the scene and describe its contact with an obstacle, from the bodies as they are in the engine."""
    scene.place(state)
    poses = scene.mechanism.poses(state)
    touch = obstacle.closest(poses, state.rates)
    joint = poses[obstacle.link].joint
    point = (joint[0] + touch.arm[0], joint[1] + touch.arm[1])
    partner = None if obstacle.partner is None else scene.links[obstacle.partner]
    connected = scene.connected if scene.mechanism.wires == 1 else None
    return touch, contact_space(scene.links[obstacle.link], point, touch.normal, partner, connected=connected)


@dataclass(frozen=True)
class EnergeticLaw(ContactLaw):
    """Stronge's energetic restitution with Coulomb friction, on the contact-space inverse mass of the scene.

    Attributes:
        accuracy: relative, of the velocities before the impact.
        tangential_compliance: eta^2 of the contact.
    """

    accuracy: float = 0.0
    tangential_compliance: float = 0.0
    name = "energetic"

    def resolve(self, scene: Scene, state: State, obstacle: Obstacle) -> tuple[State, ContactRecord]:
        """Change all bodies' velocities at once; positions stay."""
        _, space = contact_at(scene, state, obstacle)
        space = ending_together(space, self.accuracy)
        impact = energetic_at(obstacle, space, self.tangential_compliance)
        impulse = (impact.impulse_normal, impact.impulse_tangential)
        after = (impact.velocity_normal, impact.velocity_tangential)
        space.apply(impulse, after)
        velocities = space.velocity, after
        return self._record(obstacle, state, tuple(scene.rates()), impact.outcome_name, impulse, velocities, impact)


def ending_together(space: ContactSpace, accuracy: float) -> ContactSpace:
    """Return the contact space with the slip at which slip and approach end together, if that is within the accuracy.

    A point with one degree of freedom has v_t/v_n = K_nt/K_nn where it moves by that alone. Slip and approach then end at one
    impulse. With an error of the slip it could end earlier, and the point would stick while it still approaches.
    """
    (normal, coupling), _ = space.inverse_mass.tolist()
    if space.stick_compliance or not normal:
        return space
    approach, slip = space.velocity
    exact = approach * coupling / normal
    near = abs(slip - exact) <= accuracy * math.hypot(approach, slip)
    return dataclasses.replace(space, velocity=(approach, exact)) if near else space


ENERGETIC = EnergeticLaw()  # the law of obstacles for which no other one is named

ENGINE_STEP = 1e-12  # step of an engine impact in scene time units: forces and motion within it are below rounding


@dataclass(frozen=True)
class EngineLaw(ContactLaw):
    """The engine's own contact: Newton's coefficient, friction clamped by the accumulated impulse, iterated.

    ``elasticity`` is taken as the coefficient of restitution. It has no phases and one friction coefficient, and may gain
    energy where bodies are joined in a chain. It serves for comparison. ``iterations`` are those of the engine's solver; 10 is
    its default.
    """

    iterations: int = 10
    name = "engine"

    def resolve(self, scene: Scene, state: State, obstacle: Obstacle) -> tuple[State, ContactRecord]:
        """Take one engine step, so short that only the impact happens in it."""
        touch, _ = contact_at(scene, state, obstacle)
        friction, elasticity = obstacle.friction, obstacle.restitution
        scene.contacts.engage(obstacle, friction=friction, elasticity=elasticity, iterations=self.iterations)
        record = scene.contacts.record(obstacle, slips=False)
        record.begin()
        scene.step(ENGINE_STEP, 1, record.note)
        ((*impulse, _),) = record.read(touch.normal) or [(0.0, 0.0, 0.0)]
        scene.contacts.release()
        after = State(state.time, state.angles, tuple(scene.rates()))
        scene.place(after)
        velocity = obstacle.closest(scene.mechanism.poses(after), after.rates).velocity
        outcome = "rebound" if velocity[0] > 0.0 else "no rebound"
        return self._record(obstacle, state, after.rates, outcome, (impulse[0], impulse[1]), (touch.velocity, velocity))


def contact_law(contact: Contact, accuracy: float, time_unit: float) -> ContactLaw:
    """Return the contact law named by the parameters, for a scene with that unit of time, s."""
    from bristle_sim.scene.contact.compliant import CompliantLaw

    squared = contact.tangential_compliance
    if contact.law == "compliant":
        duration = None if contact.duration is None else contact.duration / time_unit
        return CompliantLaw(duration, accuracy, tangential_compliance=squared)
    return EngineLaw() if contact.law == "engine" else EnergeticLaw(accuracy, squared)
