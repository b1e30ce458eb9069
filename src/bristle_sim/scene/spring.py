"""A contact with springs and friction, simulated over its duration: phase, forces and record.

The force law is that of :mod:`bristle_sim.theory.contact_spring`. The shorter the contact, the
closer its outcome is to the outcome of the impact law with the same tangential compliance eta^2
(:mod:`bristle_sim.theory.impact_compliance`).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from pymunk._chipmunk_cffi import ffi, lib

from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact import ActiveContact, Outcome
from bristle_sim.scene.extrapolation import Extrapolation, SpringForce
from bristle_sim.scene.impacts import contact_at
from bristle_sim.scene.mechanism import State, Vector, xy
from bristle_sim.scene.pairs import Closest, WorkpartPair
from bristle_sim.theory.contact_spring import ContactSpring
from bristle_sim.trajectory import ContactHistory, ContactRecord

LEAST_PHASE = 1e-6
"""Least normal impulse of a phase that the record names, as a fraction of the normal impulse of the
contact. Stick always ends in a short slip, which is not named: just before separation the force is
too small to keep the contact point from slipping."""

NO_SLIP_TO_STOP = 1e-14
"""Least ratio K_tt/K_nn of tangential to normal inverse mass. A smaller K_tt is rounding error: the
tip moves along the normal and has no slip to stop."""

NO_GRIP = 0.1
"""Least angle (rad) between a link and the direction in which its tangential inverse mass K_tt is
0, divided by the contact's duration in scene units. At a smaller angle the tip cannot stick: K_tt
changes by more than its own value in one interval, and no force within the friction cone stops the
slip."""

MOST_TURN = 1e-3
"""Upper bound (rad) of the angle that follows from ``NO_GRIP`` and the contact's duration."""

# Largest distance of a tangential force from the edge of the friction cone, as a fraction of the
# friction limit, at which the force counts as on the edge.
EDGE_ROUNDING = 1e-9

SHORTEST_SWING = 1e-3
"""Shortest half period of a tangential spring's oscillation that is simulated, as a fraction of the
contact's duration. At the deepest point the force oscillates between the friction of compression
and the friction of restitution. Faster oscillations are replaced by their mean, the phase "slip at
rest". The deepest penetration then has a relative error of less than a tenth of this fraction."""


class SpringPhase(NamedTuple):
    """A phase of a contact with springs.

    Attributes:
        loading: whether the normal spring is being loaded (compression).
        slip: sense of slip, 1 or -1; 0 in stick.
        impulse: normal impulse of the contact up to the beginning of the phase.
    """

    loading: bool
    slip: int
    impulse: float


@dataclass(slots=True, eq=False, kw_only=True)
class SpringContact(ActiveContact):
    """A contact with springs in its present phase; it is simulated over its duration.

    The contact has a normal spring with energetic restitution, and Coulomb friction. If it is
    compliant along the surface, it also has a tangential spring.

    Attributes:
        law: force law of the springs in the present phase, in engine units.
        duration: predicted duration of the contact.
        predicted: outcome that the impact law predicts.
        stepper: integrator of the contact.
        surface: gap at the first touch. The penetration is this gap minus the present gap.
        inverse_mass: contact-space inverse mass matrix K, row by row. The matrix at the first touch
            is kept until ``follow_bodies`` updates it.
        slip: sense of slip, 1 or -1; 0 in stick.
        at_rest: whether the phase is "slip at rest": the contact point slips at its greatest depth,
            with zero normal velocity. The friction force is between the friction of compression and
            that of restitution.
        stick_force: tangential force in stick, or in slip at rest, at the last state.
        foot: position along the surface at which the tangential spring is attached.
        phases: the phases so far.
        rows: the samples: time, normal and tangential force, penetration, normal and tangential
            velocity. Two samples at the same time are the end of a phase and the start of the next.
        compression: impulse and work up to the end of compression; None until compression ends.
        stopped_at: state, impulse, work, number of samples and number of phases at the instant at
            which the rigid-body law predicts a jam; None before this instant.
    """

    pair: WorkpartPair
    law: ContactSpring
    duration: float
    predicted: str
    stepper: Extrapolation
    surface: float
    inverse_mass: tuple[Vector, Vector]
    start: State
    slip: int = 0
    at_rest: bool = False
    stick_force: float = 0.0
    foot: float = 0.0
    phases: list[SpringPhase] = field(default_factory=list)
    rows: list[tuple[float, ...]] = field(default_factory=list)
    compression: tuple[Vector, Vector] | None = None
    stopped_at: tuple[State, Vector, Vector, int, int] | None = None

    def follow_bodies(self, scene: Scene, state: State) -> None:
        """Update the inverse mass matrix in stick and in slip at rest, where the forces need it."""
        if self.at_rest or not self.slip:
            self.inverse_mass = contact_at(scene.mechanism, state, self.pair).inverse_mass

    def sample(self, closest: Closest, state: State) -> float:
        """Record a sample of forces and motion at a state; return the normal force."""
        touch = closest(self.pair, state)
        penetration = self.surface - touch.gap
        self.force, self.tangential = self.forces(penetration)
        motion = (penetration, *touch.velocity)
        self.rows.append((state.time, self.force, self.tangential, *motion))
        return self.force

    def begin_phase(self) -> None:
        """Record that a phase begins."""
        self.phases.append(SpringPhase(self.law.loading, self.slip, self.impulse[0]))

    def unload(self, penetration: float) -> None:
        """End compression: the normal spring unloads from the given penetration on."""
        self.compression = (self.impulse, self.work)
        self.law = replace(self.law, deepest=penetration)

    def phase_names(self, *, jams: bool) -> tuple[str, ...]:
        """Return the names of the phases in order, without those that are too short.

        A phase is too short if its normal impulse is below the fraction ``LEAST_PHASE`` of the
        contact's normal impulse. If the contact jams, its last phase is always named.
        """
        ends = [*(phase.impulse for phase in self.phases[1:]), self.impulse[0]]
        names: list[str] = []
        first = 0
        for phase, end in zip(self.phases, ends, strict=True):
            long = end - phase.impulse >= LEAST_PHASE * self.impulse[0]
            if long or (jams and phase is self.phases[-1]):
                first = first or phase.slip
                motion = "reverse slip" if phase.slip == -first else "slip"
                loading = "compression" if phase.loading else "restitution"
                names.append(f"{loading} {motion if phase.slip else 'stick'}")
        return tuple(name for name, _ in itertools.groupby(names))

    def record(self, closest: Closest, last: State, outcome: str) -> ContactRecord | None:
        """Return the contact record, with phases and history; None for a contact of zero duration.

        Args:
            closest: function that returns the closest approach of a pair in a state.
            last: state at which the contact ends.
            outcome: outcome that the record states.
        """
        sustained = ActiveContact.record(self, closest, last, outcome)
        if sustained is None:
            return None
        impulse, work = self.compression or (self.impulse, self.work)
        return replace(
            sustained,
            law="compliant",
            compressive_impulse=impulse,
            compressive_work=work,
            restitutive_work=(self.work[0] - work[0], self.work[1] - work[1]),
            velocity_before=closest(self.pair, self.start).velocity,
            velocity_after=closest(self.pair, last).velocity,
            phases=self.phase_names(jams=outcome == Outcome.JAM),
            history=ContactHistory(*np.ascontiguousarray(np.array(self.rows).T)),
        )

    @property
    def jams(self) -> bool:
        """Whether the impact law predicts a jam that the contact has not reached yet."""
        return self.predicted == Outcome.JAM and self.law.loading and self.stopped_at is None

    @property
    def elastic(self) -> bool:
        """Whether there is a tangential spring."""
        return self.law.compliance > 0.0

    @property
    def compliance_in_stick(self) -> float:
        """Tangential inverse mass K_tt of the contact point in stick.

        The value is 0 if friction cannot stop the slip, so that the contact point cannot stick.
        """
        (normal, _), (_, tangential) = self.inverse_mass
        least = max(NO_SLIP_TO_STOP, min(NO_GRIP * self.duration, MOST_TURN) ** 2)
        return tangential if tangential > least * normal else 0.0

    def forces(self, penetration: float) -> Vector:
        """Return the (normal, tangential) force at a penetration.

        The tangential force in stick is reduced to the friction limit if it exceeds that limit.
        """
        law = self.law
        normal = max(law.normal_force(penetration), 0.0)
        friction = law.coefficient
        if self.at_rest:
            friction = max(law.friction, law.restitution_friction)
        elif self.slip:
            return normal, -friction * self.slip * normal
        limit = friction * normal
        return normal, min(max(self.stick_force, -limit), limit)

    def spare_friction(self, penetration: float, stick_force: float) -> float:
        """Return the friction limit at a penetration minus the magnitude of ``stick_force``.

        The difference is negative if the contact point cannot stick.
        """
        return self.law.coefficient * self.law.normal_force(penetration) - abs(stick_force)

    def rest_margins(self, penetration: float, force: float) -> Vector:
        """Return the margins of the tangential force to its two limits in the phase "slip at rest".

        Returns:
            The margin to the friction of restitution, at which the contact point begins to rise.
            The margin to the friction of compression, at which it begins to move deeper.
        """
        law = self.law
        normal = law.normal_force(penetration)
        friction = -self.slip * force
        sense = math.copysign(1.0, law.restitution_friction - law.friction)
        to_part = sense * (law.restitution_friction * normal - friction)
        to_press = sense * (friction - law.friction * normal)
        return to_part, to_press

    @property
    def least_slip_at_rest(self) -> float:
        """Least slip velocity in the phase "slip at rest"; 0 without a tangential spring.

        At a smaller slip velocity the tangential spring oscillates slowly enough to be simulated.
        """
        law = self.law
        rise = law.compliance * abs(law.restitution_friction - law.friction) * (law.deepest or 0.0)
        return rise / (SHORTEST_SWING * self.duration)

    def off_balance(self, velocity: Vector) -> float:
        """Return v_t + eta^2 v_n K_nt/K_tt for the (normal, tangential) velocity (v_n, v_t).

        During loading the result is proportional to the time derivative of the tangential
        acceleration that the contact forces cause. K is the inverse mass matrix, eta^2 the
        tangential compliance.
        """
        coupling, along = map(float, self.inverse_mass[1])
        return velocity[1] + self.law.compliance * velocity[0] * coupling / along

    def set_foot(self, penetration: float, place: float) -> bool:
        """Attach the tangential spring to the surface so that its force does not jump.

        The force is limited to the friction limit. Return whether the force is at this limit.

        Args:
            penetration: present penetration.
            place: x coordinate of the contact point.
        """
        limit = max(self.spare_friction(penetration, 0.0), 0.0)
        force = min(max(self.stick_force, -limit), limit)
        self.stick_force = force
        self.foot = self.law.foot(place, force)
        return abs(force) >= limit * (1.0 - EDGE_ROUNDING)


def spring_forces(scene: Scene, springs: Sequence[SpringContact]) -> list[SpringForce]:
    """Return the functions with which an integrator applies the forces of contacts with springs."""
    return [_spring_force(scene, spring) for spring in springs]


def _spring_force(scene: Scene, spring: SpringContact) -> SpringForce:
    """Return the function that begins the force of a contact in its present phase.

    In stick without a tangential spring, the tangential force in a step of length h cancels the
    slip velocity v_t of the previous step. This force is -(K_nt N + v_t/h)/K_tt, with the normal
    force N and the contact-space inverse mass matrix K. In the phase "slip at rest" the tangential
    force cancels the normal velocity v_n instead, and is -(K_nn N + v_n/h)/K_nt. The force in the
    second step stands for the force at the interval's beginning. The force that a step after the
    interval would have stands for the force at the interval's end. The errors of both are power
    series in h, so extrapolation removes them.
    """
    pair = spring.pair
    law = spring.law
    link = scene.mechanism.links[pair.link]
    body = scene.links[pair.link]._body
    corner = ffi.new("cpVect *", xy(link.corners[pair.corner] - link.centre))[0]
    push = partial(lib.cpBodyApplyForceAtWorldPoint, body)
    place_of = partial(lib.cpBodyLocalToWorld, body, corner)
    velocity_of = partial(lib.cpBodyGetVelocityAtLocalPoint, body, corner)
    stiffness = law.stiffness * law.steepness
    height = spring.surface - law.residual - pair.depth - pair.dent
    foot = spring.foot
    friction = -law.coefficient * spring.slip
    rigidity = law.stiffness / law.compliance if spring.elastic and not spring.slip else 0.0

    def begin(step: float) -> tuple[Callable[[], None], Callable[[], list[float]]]:
        ratio = friction
        stop_slip = stop_normal = 0.0
        normal_gain, coupling = spring.inverse_mass[0]
        if spring.at_rest:
            ratio = -normal_gain / coupling
            stop_normal = 1.0 / (coupling * step)
        elif not (spring.slip or rigidity) and (tangential := spring.compliance_in_stick):
            ratio = -coupling / tangential
            stop_slip = 1.0 / (tangential * step)
        pushes = loss = heat = 0.0
        rubs: list[float] = []

        def act() -> None:
            nonlocal pushes, loss, heat
            place = place_of()
            velocity = velocity_of()
            x = place.x
            y = place.y
            u = velocity.x
            v = velocity.y
            normal = stiffness * (height - y)
            along = ratio * normal - stop_slip * u - stop_normal * v - rigidity * (x - foot)
            push((along, normal), place)
            pushes += normal
            loss += normal * v
            heat += along * u
            rubs.append(along)

        def read() -> list[float]:
            place = place_of()
            velocity = velocity_of()
            normal = stiffness * (height - place.y)
            along = ratio * normal - stop_slip * velocity.x - stop_normal * velocity.y
            along -= rigidity * (place.x - foot)
            impulse = (step * pushes, step * sum(rubs))
            return [normal, along, *impulse, step * loss, step * heat, [*rubs, along][1]]

        return act, read

    return begin
