"""Impact laws.

An instantaneous law takes a scene, a state and a pair of bodies, and returns the state after the
impact and the contact record. A law that simulates the contact over its duration
(:mod:`bristle_sim.scene.compliant`) returns a spring instead, which acts in the simulation's loop.

To add a law, write a subclass of :class:`ContactLaw`, let ``contact_law`` in
:mod:`bristle_sim.scene.tool` return it, and add its name to the words of ``Contact.law``.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import pymunk

from bristle_sim.scene.build import SHAPE_MARGIN, Scene
from bristle_sim.scene.contact_point import ContactPoint, contact_at
from bristle_sim.scene.mechanism import State, Vector, xy
from bristle_sim.scene.pairs import ContactPair, WorkpartPair
from bristle_sim.theory.impact import energetic_impact
from bristle_sim.theory.impact_phases import Impact, resolve_phases
from bristle_sim.trajectory import ContactRecord

CANCELS = 100.0
"""Ratio of the two terms of the change of v_t to v_t itself, above which the rates are computed
from the motion of the contact point: two digits have cancelled there, as where a heavy link leaves
a sticking contact point hardly any compliance."""


class ContactLaw(ABC):
    """The base class of impact laws.

    Attributes:
        name: the law's name in contact records.
        instantaneous: whether its impacts take no time.
        finite_duration: whether the user has given the duration of its contacts, so that the bodies
            move noticeably in it.
    """

    name: ClassVar[str]
    instantaneous: ClassVar[bool] = True
    finite_duration: bool = False

    @abstractmethod
    def resolve(self, scene: Scene, state: State, pair: ContactPair) -> tuple[State, ContactRecord]:
        """Apply an instantaneous impact to the scene.

        Returns:
            The state after the impact and the contact record, in engine units.
        """

    def _after(
        self, pair: ContactPair, before: State, rates: tuple[float, ...], **entries: Any
    ) -> tuple[State, ContactRecord]:
        """Return the state after an impact, with its new rates, and the contact record.

        ``entries`` are the entries of the record that depend on the law.
        """
        after = State(before.time, before.angles, rates)
        return after, ContactRecord(
            obstacle=pair.name,
            law=self.name,
            time=before.time,
            duration=0.0,
            angles=before.angles,
            rates_before=before.rates,
            rates_after=after.rates,
            **entries,
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

    def resolve(self, scene: Scene, state: State, pair: ContactPair) -> tuple[State, ContactRecord]:
        """Apply the impact to the rates of all links.

        Returns:
            The state after the impact and the contact record, in engine units.
        """
        point = contact_at(scene.mechanism, state, pair)
        before = ending_together(point, self.accuracy)
        impact = impact_at(point, before, pair, self.tangential_compliance)
        impulse = (impact.impulse_normal, impact.impulse_tangential)
        velocity = (impact.velocity_normal, impact.velocity_tangential)
        push, rub = impulse
        normal, along = point.response
        coupling, tangential = point.inverse_mass[1]
        parts = abs(coupling * push) + abs(tangential * rub)
        if point.stick_compliance and parts > CANCELS * (abs(before[1]) + abs(velocity[1])):
            normal = point.in_stick
            rub = (velocity[1] - before[1]) / tangential
        return self._after(
            pair,
            state,
            tuple(
                [a + push * b + rub * c for a, b, c in zip(state.rates, normal, along, strict=True)]
            ),
            outcome=impact.outcome_name,
            impulse=impulse,
            compressive_impulse=(
                impact.compressive_impulse_normal,
                impact.compressive_impulse_tangential,
            ),
            compressive_work=tuple(map(float, impact.compressive_work)),
            restitutive_work=tuple(map(float, impact.restitutive_work)),
            velocity_before=before,
            velocity_after=velocity,
            phases=impact.phases,
        )


def impact_at(
    point: ContactPoint, velocity: Vector, pair: ContactPair, tangential_compliance: float = 0.0
) -> Impact:
    """Return the energetic impact of a contact point at a velocity."""
    coefficients = (pair.friction, pair.restitution, pair.restitution_friction)
    stick = point.stick_compliance
    if tangential_compliance == 0.0:
        (k_nn, k_nt), (_, k_tt) = point.inverse_mass
        return resolve_phases(k_nn, k_nt, k_tt, *velocity, *coefficients, stick)
    return energetic_impact(
        point.inverse_mass, velocity, *coefficients, stick, tangential_compliance
    )


def ending_together(point: ContactPoint, accuracy: float) -> Vector:
    """Return the velocity of a contact point before an impact.

    If slip and approach end together within the accuracy, the slip velocity is corrected so that
    they do so exactly.

    A contact point that has one degree of freedom moves such that v_t/v_n = K_nt/K_nn, with its
    slip velocity v_t, its normal velocity v_n and the contact-space inverse mass matrix K. Its slip
    and its approach end at the same impulse. If an error of v_t let the slip end earlier, the point
    would stick while it still approaches.
    """
    normal, coupling = point.inverse_mass[0]
    approach, slip = point.touch.velocity
    if point.stick_compliance or not normal:
        return approach, slip
    exact = approach * coupling / normal
    near = abs(slip - exact) <= accuracy * math.hypot(approach, slip)
    return approach, exact if near else slip


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
        """Let the engine resolve an impact with the workpart, in a step so short that nothing else
        happens in it.

        The workpart's shape is larger than the workpart by ``SHAPE_MARGIN``; the link is not
        enlarged, so the lever of friction is exact. The engine uses the pair's coefficients of
        restitution and friction as elasticity and friction.

        Returns:
            The state after the impact and the contact record, in engine units.
        """
        assert isinstance(pair, WorkpartPair), "the bar has the energetic law"
        scene.place(state)
        mechanism = scene.mechanism
        space = scene.space
        link = mechanism.links[pair.link]
        middle = -pair.depth - HALF_PLANE
        face = ((-HALF_PLANE, middle), (HALF_PLANE, middle))
        part = pymunk.Segment(space.static_body, *face, HALF_PLANE + SHAPE_MARGIN)
        tip = pymunk.Circle(
            scene.links[pair.link], 0.0, xy(link.corners[pair.corner] - link.centre)
        )
        tip.friction = tip.elasticity = 1.0
        part.friction = pair.friction
        part.elasticity = pair.restitution
        impulses = [(0.0, 0.0)]

        def note(arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
            del space, data
            impulses.append(arbiter.total_impulse)

        space.add(part, tip)
        space.on_collision(post_solve=note)
        before = space.iterations
        space.iterations = ENGINE_ITERATIONS
        scene.step_alone(ENGINE_STEP)
        space.iterations = before
        space.on_collision()
        space.remove(part, tip)
        rub, push = impulses[-1]
        rates = tuple(scene.rates())
        after = mechanism.poses(state._replace(rates=rates))
        velocity = pair.closest(after, rates).velocity
        return self._after(
            pair,
            state,
            rates,
            outcome="rebound" if velocity[0] > 0.0 else "no rebound",
            # The sign of the engine's impulse depends on the order of the shapes; a contact only
            # pushes.
            impulse=(push, rub) if push >= 0.0 else (-push, -rub),
            compressive_impulse=None,
            compressive_work=None,
            restitutive_work=None,
            velocity_before=pair.closest(mechanism.poses(state), state.rates).velocity,
            velocity_after=velocity,
        )
