"""The spring of a contact resolved in time, and its force and friction as a load on the scene.

Normal force over penetration delta is bilinear: k delta while penetration grows, and (k/e*^2)(delta - delta_r) with delta_r =
(1 - e*^2) delta_max while it unloads, so that the spring returns e*^2 of the work it took, whatever the bodies do. The
tangential force is -mu sign(v_t) N in slip; in stick it is the force that stops the point within each engine step, -(K_nt N +
v_t/h)/K_tt.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from operator import mul
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.scene.contact.obstacles import ClosestApproach, Obstacle, WorkpartObstacle
from bristle_sim.scene.contact.samples import filled
from bristle_sim.scene.engine import point_calls, pusher
from bristle_sim.scene.mechanism import State, Vector
from bristle_sim.trajectory import ContactHistory

if TYPE_CHECKING:
    from bristle_sim.scene.build import Scene
    from bristle_sim.scene.contact.rigid import RigidContacts
    from bristle_sim.scene.contact.sustained import Sustained
    from bristle_sim.scene.integrate.extrapolation import Stepper

NO_SLIP_TO_STOP = 1e-14
"""Ratio K_tt/K_nn below which K_tt is only rounding: the tip moves along the normal and has no slip to stop."""

LEAST_PHASE = 1e-6
"""A phase of less than this fraction of the normal impulse is not named. Close to separation the force is too small to keep a
point from moving with its bodies, so stick always ends in slip; this has no effect in the limit of short contacts."""


class SpringPhase(NamedTuple):
    """A phase of the contact: whether the spring loads, the sense of slip, and the normal impulse before the phase."""

    loading: bool
    slip: int
    impulse: float


@dataclass(slots=True)
class ContactCourse:
    """The record of one contact while it lasts.

    Attributes:
        rows: time, normal and tangential force, penetration, normal and tangential velocity at each sample; two samples at one
            time are the end of a phase and the start of the next.
        compression: impulse (normal, tangential) and work (the same) up to the end of compression; None before.
        stopped: where the rigid-body law jams: the state, the sums, and the numbers of rows and phases there.
    """

    phases: list[SpringPhase] = field(default_factory=list)
    rows: list[tuple[float, ...]] = field(default_factory=list)
    compression: tuple[float, ...] | None = None
    stopped: tuple[State, tuple[float, ...], int, int] | None = None

    @property
    def approach(self) -> float:
        """Speed of approach at the first touch."""
        return abs(self.rows[0][4])

    def let_go(self) -> None:
        """Set the last force to zero: a spring does not pull, and a separated point is not pushed."""
        time, _, _, *motion = self.rows[-1]
        self.rows[-1] = (time, 0.0, 0.0, *motion)

    def phase_names(self, impulse: float, *, jams: bool) -> tuple[str, ...]:
        """Return the names of the phases in order, without those too short to matter; a jam's last phase always counts."""
        ends = [*(phase.impulse for phase in self.phases[1:]), impulse]
        names: list[str] = []
        first = 0
        for phase, end in zip(self.phases, ends, strict=True):
            if end - phase.impulse >= LEAST_PHASE * impulse or (jams and phase is self.phases[-1]):
                first = first or phase.slip
                motion = "stick" if not phase.slip else "slip" if phase.slip == first else "reverse slip"
                names.append(f"{'compression' if phase.loading else 'restitution'} {motion}")
        return tuple(name for name, _ in itertools.groupby(names))


class Expectation(NamedTuple):
    """What the impact law predicts of a contact (duration, outcome), and how it is integrated (longest interval, stepper).

    In a contact of given duration the bodies move noticeably (``moves``); otherwise it is the rigid-body limit with constant K.
    """

    duration: float
    longest: float
    outcome: str
    moves: bool
    stepper: Stepper


@dataclass(slots=True, eq=False)
class Spring:
    """Normal spring with energetic restitution, and Coulomb friction.

    Attributes:
        stiffness: in compression, engine units.
        obstacle: that is touched, with its coefficients.
        surface: gap at the first touch, from which the penetration is measured.
        inverse_mass: K at the first touch or of the interval.
        loading: whether the penetration is the largest so far; else the spring unloads, more steeply.
        deepest: penetration at which unloading began.
        slip: sense of slip, or 0 in stick.
        stick_force: tangential force in stick at the last state.
    """

    stiffness: float
    obstacle: Obstacle
    expected: Expectation
    surface: float
    inverse_mass: Array
    loading: bool = True
    deepest: float = 0.0
    slip: int = 0
    stick_force: float = 0.0
    course: ContactCourse = field(default_factory=ContactCourse)
    elastic: ClassVar[bool] = False

    def history(self) -> ContactHistory:
        """Return the samples, with others between them in the rigid-body limit of a contact that is rigid along the surface."""
        rows = np.array(self.course.rows)
        every = rows if self.expected.moves or self.elastic else filled(rows, self.inverse_mass)
        return ContactHistory(*np.ascontiguousarray(every.T))

    def force(self, scene: Scene, obstacle: Obstacle) -> SpringForce:
        """Return the spring's force as a load."""
        return SpringForce(scene, obstacle, self)

    def foot_speed(self, velocity: Vector) -> float:
        """Return the velocity of the point that slips on the surface: here the contact point itself."""
        return velocity[1]

    def settle(self, touch: ClosestApproach, place: float, error: float) -> None:
        """Decide between stick and slip from here on, for a spring that also acts along the surface."""
        raise NotImplementedError

    @property
    def friction(self) -> float:
        """Coulomb's mu, of compression or of restitution."""
        return self.obstacle.friction if self.loading else self.obstacle.restitution_friction

    @property
    def residual(self) -> float:
        """Penetration at which the force is back at zero."""
        return 0.0 if self.loading else self.deepest * (1.0 - self.obstacle.restitution**2)

    @property
    def compliance_in_stick(self) -> float:
        """K_tt; 0 where there is no slip to stop."""
        normal, tangential = float(self.inverse_mass[0, 0]), float(self.inverse_mass[1, 1])
        return tangential if tangential > NO_SLIP_TO_STOP * normal else 0.0

    @property
    def present_stiffness(self) -> float:
        """Stiffness in the present phase; 0 in unloading without restitution."""
        restitution = self.obstacle.restitution
        if self.loading:
            return self.stiffness
        return self.stiffness / restitution**2 if restitution else 0.0

    @property
    def ratio(self) -> float:
        """Tangential over normal force; in stick without the forces of inertia and of stopping the remaining slip."""
        if not self.slip and (tangential := self.compliance_in_stick):
            return -float(self.inverse_mass[0, 1]) / tangential
        return -self.friction * self.slip

    def unload(self, penetration: float) -> None:
        """Begin unloading at the end of compression."""
        self.loading, self.deepest = False, penetration

    def forces(self, penetration: float) -> Vector:
        """Return (normal, tangential) force at a penetration, within the friction cone."""
        normal = max(self.present_stiffness * (penetration - self.residual), 0.0)
        if self.slip:
            return normal, -self.friction * self.slip * normal
        return normal, math.copysign(min(abs(self.stick_force), self.friction * normal), self.stick_force)

    def spare_friction(self, penetration: float, stick_force: float) -> float:
        """Return the margin of the force in stick to the limit of friction."""
        return self.friction * self.present_stiffness * (penetration - self.residual) - abs(stick_force)


class SpringForce:
    """The force of a contact's spring on a corner of a link, and its sums: six numbers.

    They are impulse (normal, tangential), work (the same), and the force in stick at the beginning and the end.
    """

    def __init__(self, scene: Scene, obstacle: Obstacle, spring: Spring) -> None:
        assert isinstance(obstacle, WorkpartObstacle), "only a corner on a plane has a spring"
        body, link = scene.links[obstacle.link], scene.mechanism.links[obstacle.link]
        x, y = (*link.knees, link.tip)[obstacle.corner]
        self.spring, self._push, self._level = spring, pusher(body), obstacle.depth + obstacle.dent
        self._step, self._steps = 0.0, list[tuple[float, float, float, float]]()
        self._place, self._velocity = point_calls(body, (x - link.centre[0], y - link.centre[1]))

    def begin(self, step: float) -> Callable[[], None]:
        """Reset the sums. Return a callback that pushes for a step, by the phase that the spring is in."""
        spring, push, place_of, velocity_of = self.spring, self._push, self._place, self._velocity
        tangential = spring.compliance_in_stick
        stop = 0.0 if spring.slip or not tangential else 1.0 / (tangential * step)
        stiffness, ratio = spring.present_stiffness, spring.ratio
        height = spring.surface - spring.residual - self._level
        steps: list[tuple[float, float, float, float]] = []
        note = steps.append
        self._step, self._steps, self._law = step, steps, (stiffness, height, ratio, stop)

        def act() -> None:
            """Apply the force for a step, and record forces and velocities."""
            place, velocity = place_of(), velocity_of()
            normal = stiffness * (height - place.y)
            along = ratio * normal - stop * velocity.x
            push((along, normal), (place.x, place.y))
            note((normal, along, velocity.y, velocity.x))

        return act

    def totals(self) -> list[float]:
        """Return the six numbers.

        The force that stops the point in a step undoes the rest of its motion from the step before, due to forces of the
        spring and of inertia alike. So the second step applies the force of stick at the beginning, and one more step would
        apply that at the end, both up to powers of the step. In slip these two are 0.
        """
        stiffness, height, ratio, stop = self._law
        if not stop:
            return [*self._sums(), 0.0, 0.0]
        last = ratio * stiffness * (height - self._place().y) - stop * self._velocity().x
        return [*self._sums(), self._steps[1][1] if len(self._steps) > 1 else last, last]

    def _sums(self) -> list[float]:
        normal, along, opening, slip = zip(*self._steps, strict=True)
        sums = [sum(normal), sum(along), sum(map(mul, normal, opening)), sum(map(mul, along, slip))]
        return [self._step * each for each in sums]


class ContactLoad:
    """Springs, and rigid contacts that act together with them.

    The totals are those of the rigid contacts, ``rigid.TOTALS`` each, then those of the springs, six each.
    """

    symmetric = False  # springs do not act alike forwards and backwards in time

    def __init__(self, scene: Scene, rigid: RigidContacts | None, springs: Sequence[Sustained]) -> None:
        self._rigid = rigid
        forces = [each.spring.force(scene, each.obstacle) for each in springs if each.spring is not None]
        self._parts: list[RigidContacts | SpringForce] = [*([] if rigid is None else [rigid]), *forces]

    def begin(self, step: float) -> Callable[[], None]:
        """Reset the sums. Return a callback to run before each step."""
        first, *others = [each.begin(step) for each in self._parts]

        def act() -> None:
            """Apply the forces of all contacts."""
            first()
            for each in others:
                each()

        return act if others else first

    def totals(self) -> list[float]:
        """Return the sums, with the last step."""
        return [number for each in self._parts for number in each.totals()]

    def fails(self, totals: Sequence[float]) -> bool:
        """Return whether a rigid contact would have to pull."""
        return self._rigid is not None and self._rigid.fails(totals)
