"""Impact laws, and the response of a contact point to an impulse.

An instantaneous law takes a scene, a state and a pair of link and obstacle, and returns the contact
record, with the angular velocities after the impact. A law that simulates the contact over its
duration (:mod:`bristle_sim.scene.compliant`) returns a spring instead, which acts in the
simulation's loop.

To add a law, write a subclass of :class:`ContactLaw`, let ``contact_law`` in
:mod:`bristle_sim.scene.tool` return it, and add its name to the words of ``Contact.law``.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
import pymunk

from bristle_sim.scene.build import SHAPE_MARGIN, Scene
from bristle_sim.scene.mechanism import Mechanism, State, Vector, xy
from bristle_sim.scene.pairs import ClosestApproach, ContactPair, WorkpartPair, contact_rows
from bristle_sim.theory.impact import energetic_impact
from bristle_sim.theory.impact_phases import Impact, resolve_phases
from bristle_sim.trajectory import ContactRecord

ROUNDING = 64.0 * math.ulp(1.0)
"""Ratio below which a motion of the contact point counts as rounding error, and is set to zero. A
lever is divided by the contact point's distance from the joint. The motion in stick is divided by
the motion that a normal impulse causes."""

CANCELS = 100.0
"""Largest ratio of the changes of the slip velocity, by the normal and by the tangential impulse,
to the slip velocity itself at which the two changes are simply added. At a larger ratio, as of a
heavy link whose contact point sticks, the sum would lose two digits by cancellation. The angular
velocities are then computed from the motion in stick."""

# Length of the step in which the engine resolves an impact, in scene time units. It is so short
# that forces and motion in the step have less effect than rounding error.
ENGINE_STEP = 1e-12
# Half the width and half the depth of the workpart's shape, in link lengths. No mechanism reaches
# the other edges of this shape.
HALF_PLANE = 1e3
# Number of iterations of the engine's solver in the step of an impact; the engine's default.
ENGINE_ITERATIONS = 10


class ContactPoint(NamedTuple):
    """The velocity changes of a contact point and of all links by an impulse at this point.

    Attributes:
        touch: closest approach of link and obstacle.
        inverse_mass: contact-space inverse mass matrix K, row by row, order (normal, tangential).
        response: changes of the links' angular velocities per unit normal impulse, then those per
            unit tangential impulse.
        in_stick: changes of the links' angular velocities per unit normal impulse while the point
            does not slip.
        stick_compliance: change of the normal velocity per unit normal impulse while the point does
            not slip; 0 if the point cannot move.
    """

    touch: ClosestApproach
    inverse_mass: tuple[Vector, Vector]
    response: Sequence[Sequence[float]]
    in_stick: Sequence[float]
    stick_compliance: float


def contact_at(mechanism: Mechanism, state: State, pair: ContactPair) -> ContactPoint:
    """Return the contact point of a pair in a state, and its response to an impulse.

    With the mass matrix M = L L^T and the Jacobian J of the contact point's velocity (rows: normal,
    tangent), K = J M^-1 J^T. The motion in stick is the component of the first column of L^-1 J^T
    that is orthogonal to the second column. This component is found by a QR factorization with the
    largest rows first, which keeps the digits of the small rows of heavy links (Cox and Higham
    1998).
    """
    touch = pair.closest(mechanism.poses(state), state.rates)
    if mechanism.single_link:
        both = 1j * touch.arm * touch.normal.conjugate()
        lever = both.real
        along = -both.imag if abs(both.imag) > ROUNDING * abs(touch.arm) else 0.0
        inertia = mechanism.links[0].inertia_about_joint
        turning = lever / inertia
        rubbing = along / inertia
        rows = ((lever * turning, lever * rubbing), (lever * rubbing, along * rubbing))
        free = 0.0 if along else turning  # without tangential motion every impulse acts as in stick
        return ContactPoint(touch, rows, ((turning,), (rubbing,)), (free,), lever * free)
    turn = np.exp(1j * np.array(state.angles))
    levers = contact_rows(mechanism, turn, [pair], [touch])
    levers[1, abs(levers[1]) <= ROUNDING * np.hypot(*levers)] = 0.0
    to_scaled = np.linalg.inv(np.linalg.cholesky(mechanism.mass_matrix(turn)))
    columns = to_scaled @ levers.T
    stick = columns[:, 0].copy()
    if levers[1].any():
        order = np.argsort(-abs(columns).max(axis=1))
        basis, triangle = np.linalg.qr(columns[order, ::-1])
        stick[order] = basis[:, 1] * triangle[1, 1]
        if np.linalg.norm(stick) <= ROUNDING * np.linalg.norm(columns[:, 0]):
            stick[:] = 0.0  # as for a straight chain, whose tip can move only across the chain
    first, second = (columns.T @ columns).tolist()
    return ContactPoint(
        touch,
        inverse_mass=(tuple(first), tuple(second)),
        response=(columns.T @ to_scaled).tolist(),
        in_stick=(stick @ to_scaled).tolist(),
        stick_compliance=float(stick @ stick),
    )


class ContactLaw(ABC):
    """The base class of impact laws.

    Attributes:
        name: the law's name in contact records.
        instantaneous: whether a contact takes no time.
        finite_duration: whether the user has given the duration of a contact, so that the bodies
            move noticeably during the contact.
    """

    name: ClassVar[str]
    instantaneous: ClassVar[bool] = True
    finite_duration: bool = False

    @abstractmethod
    def resolve(self, scene: Scene, state: State, pair: ContactPair) -> ContactRecord:
        """Return the record of an instantaneous impact, in engine units.

        Args:
            scene: the scene.
            state: the state before the impact.
            pair: the link and the obstacle that touch.
        """


@dataclass(frozen=True)
class EnergeticLaw(ContactLaw):
    """Stronge's instantaneous impact law: energetic restitution and Coulomb friction.

    Attributes:
        accuracy: relative error of the velocities before the impact, and error (rad) of the links'
            directions. ``ending_together`` corrects the slip velocity by at most this error.
        tangential_compliance: tangential compliance eta^2 of the contact, dimensionless.
    """

    accuracy: float = 0.0
    tangential_compliance: float = 0.0
    name = "energetic"

    def resolve(self, scene: Scene, state: State, pair: ContactPair) -> ContactRecord:
        """Return the record of an impact, in which the angular velocities of all links change."""
        point = contact_at(scene.mechanism, state, pair)
        point, before = ending_together(point, self.accuracy)
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
        compression: Any = tuple(map(float, impact.compressive_work))
        restitution: Any = tuple(map(float, impact.restitutive_work))
        changed = zip(state.rates, normal, along, strict=True)
        rates = tuple([rate + push * by_push + rub * by_rub for rate, by_push, by_rub in changed])
        return ContactRecord(
            obstacle=pair.name,
            law=self.name,
            time=state.time,
            duration=0.0,
            angles=state.angles,
            rates_before=state.rates,
            rates_after=rates,
            outcome=impact.outcome_name,
            impulse=impulse,
            compressive_impulse=(
                impact.compressive_impulse_normal,
                impact.compressive_impulse_tangential,
            ),
            compressive_work=compression,
            restitutive_work=restitution,
            velocity_before=before,
            velocity_after=velocity,
            phases=impact.phases,
        )


def impact_at(
    point: ContactPoint, velocity: Vector, pair: ContactPair, tangential_compliance: float = 0.0
) -> Impact:
    """Return the impact of a contact point by Stronge's energetic law.

    ``velocity`` is the (normal, tangential) velocity before the impact, ``tangential_compliance``
    the dimensionless compliance eta^2.
    """
    coefficients = (pair.friction, pair.restitution, pair.restitution_friction)
    stick = point.stick_compliance
    if tangential_compliance == 0.0:
        (k_nn, k_nt), (_, k_tt) = point.inverse_mass
        return resolve_phases(k_nn, k_nt, k_tt, *velocity, *coefficients, stick)
    return energetic_impact(
        point.inverse_mass, velocity, *coefficients, stick, tangential_compliance
    )


def ending_together(point: ContactPoint, accuracy: float) -> tuple[ContactPoint, Vector]:
    """Return a contact point and its velocity, corrected so that slip and approach end together.

    The returned velocity is the (normal, tangential) velocity before the impact. The velocity is
    corrected only for two kinds of contact point, and by no more than its error.

    The first kind has one degree of freedom and can move in one direction only: v_t/v_n =
    K_nt/K_nn, with its slip velocity v_t, its normal velocity v_n and the contact-space inverse
    mass matrix K. Its slip and its approach therefore end at the same impulse. With an error of v_t
    the slip could end earlier, and the point would stick while it still approaches. An error of v_t
    up to ``accuracy``, relative to the speed, is therefore removed from the tangential velocity.

    The second kind belongs to a chain that is straight but for an error of its links' directions.
    Its velocity is corrected in the same way. Its response in stick, which is proportional to the
    square of this error, is set to zero.
    """
    normal, coupling = point.inverse_mass[0]
    approach, slip = point.touch.velocity
    if point.stick_compliance <= accuracy**2 * normal and normal:
        exact = approach * coupling / normal
        if abs(slip - exact) <= accuracy * math.hypot(approach, slip):
            return point._replace(stick_compliance=0.0), (approach, exact)
    return point, (approach, slip)


ENERGETIC = EnergeticLaw()  # the law of all contacts except those with the workpart


@dataclass(frozen=True)
class EngineLaw(ContactLaw):
    """The impact law of the physics engine, for comparison.

    The engine solves iteratively for the impulses. A shape's ``elasticity`` in the engine is
    Newton's coefficient of restitution. The tangential impulse is at most the coefficient of
    friction times the normal impulse. The law has no phases and only one coefficient of friction.
    The law may increase the energy of bodies that are joined in a chain.
    """

    name = "engine"

    def resolve(self, scene: Scene, state: State, pair: ContactPair) -> ContactRecord:
        """Return the record of an impact with the workpart that the engine resolves in a short step.

        The workpart's shape in the engine extends beyond its surface by ``SHAPE_MARGIN``, so that
        the engine detects the touch. The link's shape is not enlarged, so the lever of friction is
        exact. The engine's elasticity and friction are the pair's coefficients.
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
        space.add(part, tip)
        space.on_collision(post_solve=lambda arbiter, *_: impulses.append(arbiter.total_impulse))
        before = space.iterations
        space.iterations = ENGINE_ITERATIONS
        scene.step_alone(ENGINE_STEP)
        space.iterations = before
        space.on_collision()
        space.remove(part, tip)
        rub, push = impulses[-1]
        rates = tuple([body.angular_velocity for body in scene.links])
        after = mechanism.poses(state._replace(rates=rates))
        velocity = pair.closest(after, rates).velocity
        return ContactRecord(
            obstacle=pair.name,
            law=self.name,
            time=state.time,
            duration=0.0,
            angles=state.angles,
            rates_before=state.rates,
            rates_after=rates,
            outcome="rebound" if velocity[0] > 0.0 else "no rebound",
            # The sign of the engine's impulse depends on the order of the shapes. A contact can
            # only push, so the normal impulse must be positive.
            impulse=(push, rub) if push >= 0.0 else (-push, -rub),
            compressive_impulse=None,
            compressive_work=None,
            restitutive_work=None,
            velocity_before=pair.closest(mechanism.poses(state), state.rates).velocity,
            velocity_after=velocity,
        )
