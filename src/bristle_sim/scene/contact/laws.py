"""Laws of impact, one of which each obstacle carries.

An impact at an instant is resolved at once: scene, state, obstacle in; state after, contact record out. A law that resolves
the contact in time gives a spring instead, which acts in the run's own loop (:mod:`bristle_sim.scene.contact.compliant`).
To add a law, write a class with the methods of :class:`ContactLaw` and name it in :func:`contact_law` there.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

from bristle_sim.contact_space.impulse import ContactSpace, contact_space
from bristle_sim.scene.mechanism import State
from bristle_sim.theory.impact import Impact, energetic_impact
from bristle_sim.trajectory import ContactRecord

if TYPE_CHECKING:
    from bristle_sim.scene.build import Scene
    from bristle_sim.scene.contact.obstacles import ClosestApproach, Obstacle
    from bristle_sim.scene.contact.spring import Spring


@dataclass(frozen=True, slots=True)
class Coefficients:
    """Friction in compression and restitution, and the coefficient of restitution."""

    friction: float
    restitution_friction: float
    restitution: float

    @classmethod
    def of(cls, obstacle: Obstacle) -> Coefficients:
        """Return the coefficients of an obstacle."""
        return cls(obstacle.friction, obstacle.restitution_friction, obstacle.restitution)

    def energetic_impact(self, space: ContactSpace) -> Impact:
        """Return the impact of rigid bodies with energetic restitution."""
        return energetic_impact(
            space.inverse_mass,
            space.velocity,
            self.friction,
            self.restitution,
            self.restitution_friction,
            space.stick_compliance,
        )


class ContactLaw(Protocol):
    """A way through an impact."""

    @property
    def name(self) -> str:
        """What contact records call it."""

    @property
    def at_once(self) -> bool:
        """Whether its impacts take no time."""

    def spring(self, scene: Scene, state: State, obstacle: Obstacle) -> Spring | None:
        """Return the spring of a contact that is resolved in time; None where the impact is one at an instant."""

    def resolve(
        self, scene: Scene, state: State, obstacle: Obstacle, coefficients: Coefficients
    ) -> tuple[State, ContactRecord]:
        """Carry the scene through an impact at an instant; engine units throughout."""


def contact_at(scene: Scene, state: State, obstacle: Obstacle) -> tuple[ClosestApproach, ContactSpace]:
    """Place the scene and describe its contact with an obstacle, from the bodies as they are in the engine."""
    scene.place(state)
    poses = scene.mechanism.poses(state)
    touch = obstacle.closest(poses, state.rates)
    joint = poses[obstacle.link].joint
    point = (joint[0] + touch.arm[0], joint[1] + touch.arm[1])
    partner = None if obstacle.partner is None else scene.links[obstacle.partner]
    return touch, contact_space(
        scene.links[obstacle.link],
        point,
        touch.normal,
        partner,
        connected=scene.connected if scene.mechanism.wires == 1 else None,
    )


@dataclass(frozen=True, slots=True)
class EnergeticLaw:
    """Stronge's energetic restitution with Coulomb friction, on the contact-space inverse mass of the scene.

    Attributes:
        accuracy: relative, of the velocities before the impact.
    """

    accuracy: float = 0.0
    name: str = field(default="energetic", init=False)
    at_once: bool = field(default=True, init=False)

    def spring(self, scene: Scene, state: State, obstacle: Obstacle) -> None:
        """Its impacts take no time."""
        del scene, state, obstacle

    def resolve(
        self, scene: Scene, state: State, obstacle: Obstacle, coefficients: Coefficients
    ) -> tuple[State, ContactRecord]:
        """Change all bodies' velocities at once; positions stay."""
        _, space = contact_at(scene, state, obstacle)
        space = ending_together(space, self.accuracy)
        impact = coefficients.energetic_impact(space)
        impulse = (impact.impulse_normal, impact.impulse_tangential)
        space.apply(impulse, (impact.velocity_normal, impact.velocity_tangential))
        after = State(state.time, state.angles, tuple(scene.rates()))
        return after, ContactRecord(
            obstacle=obstacle.name,
            law=self.name,
            outcome=impact.outcome_name,
            time=state.time,
            duration=0.0,
            impulse=impulse,
            compressive_impulse=(impact.compressive_impulse_normal, impact.compressive_impulse_tangential),
            compressive_work=(float(impact.compressive_work[0]), float(impact.compressive_work[1])),
            restitutive_work=(float(impact.restitutive_work[0]), float(impact.restitutive_work[1])),
            velocity_before=space.velocity,
            velocity_after=(impact.velocity_normal, impact.velocity_tangential),
            angles=state.angles,
            rates_before=state.rates,
            rates_after=after.rates,
            phases=impact.phases,
        )


def ending_together(space: ContactSpace, accuracy: float) -> ContactSpace:
    """Return the contact space with the slip that ends with the approach, if it has that slip within the accuracy.

    A point with one degree of freedom has v_t/v_n = K_nt/K_nn where it moves by that alone. Slip and approach then end at one
    impulse. An error of the slip would let it end before, and the point would stick while it still approaches.
    """
    (normal, coupling), _ = space.inverse_mass.tolist()
    if space.stick_compliance or not normal:
        return space
    approach, slip = space.velocity
    exact = approach * coupling / normal
    near = abs(slip - exact) <= accuracy * math.hypot(approach, slip)
    return dataclasses.replace(space, velocity=(approach, exact)) if near else space


ENERGETIC = EnergeticLaw()
"""The law of obstacles for which no other one is named."""

ENGINE_STEP = 1e-12
"""Step of an engine impact in scene time units: forces and motion within it are below rounding."""


@dataclass(frozen=True, slots=True)
class EngineLaw:
    """The engine's own contact: Newton's coefficient, friction clamped by the accumulated impulse, iterated.

    ``elasticity`` is taken as the coefficient of restitution. It knows no phases, takes one friction coefficient, and
    may gain energy where bodies are joined in a chain; it is here to be compared. ``iterations`` are those of the engine's
    solver; 10 is its default.
    """

    iterations: int = 10
    name: str = field(default="engine", init=False)
    at_once: bool = field(default=True, init=False)

    def spring(self, scene: Scene, state: State, obstacle: Obstacle) -> None:
        """Its impacts take no time."""
        del scene, state, obstacle

    def resolve(
        self, scene: Scene, state: State, obstacle: Obstacle, coefficients: Coefficients
    ) -> tuple[State, ContactRecord]:
        """Take one engine step, so short that nothing but the impact happens in it."""
        touch, _ = contact_at(scene, state, obstacle)
        scene.contacts.engage(
            obstacle,
            friction=coefficients.friction,
            elasticity=coefficients.restitution,
            iterations=self.iterations,
        )
        scene.step(ENGINE_STEP, 1)
        impulse = scene.contacts.totals(obstacle)[:2]
        scene.release()
        after = State(state.time, state.angles, tuple(scene.rates()))
        scene.place(after)
        velocity = obstacle.closest(scene.mechanism.poses(after), after.rates).velocity
        return after, ContactRecord(
            obstacle=obstacle.name,
            law=self.name,
            outcome="rebound" if velocity[0] > 0.0 else "no rebound",
            time=state.time,
            duration=0.0,
            impulse=impulse,
            compressive_impulse=None,
            compressive_work=None,
            restitutive_work=None,
            velocity_before=touch.velocity,
            velocity_after=velocity,
            angles=state.angles,
            rates_before=state.rates,
            rates_after=after.rates,
        )
