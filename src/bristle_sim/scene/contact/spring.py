"""The spring of a contact resolved in time, and its force and friction as a load on the scene.

Normal force over penetration delta is bilinear: k delta while penetration grows, and (k/e*^2)(delta - delta_r) with
delta_r = (1 - e*^2) delta_max while it unloads, so that the spring returns e*^2 of the work it took, whatever the bodies
do. The tangential force is -mu sign(v_t) N in slip; in stick it is what stops the point within each engine step,
-(K_nt N + v_t/h)/K_tt.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from operator import mul
from typing import TYPE_CHECKING, NamedTuple

from bristle_sim.arrays import Array
from bristle_sim.scene.contact.course import ContactCourse
from bristle_sim.scene.contact.laws import Coefficients
from bristle_sim.scene.engine import point_calls, point_reader, pusher
from bristle_sim.scene.mechanism import Pose, Vector
from bristle_sim.trajectory import ContactHistory

if TYPE_CHECKING:
    from bristle_sim.scene.build import Scene
    from bristle_sim.scene.contact.obstacles import Obstacle
    from bristle_sim.scene.integrate.stepping import Stepper

NO_SLIP_TO_STOP = 1e-14
"""K_tt over K_nn below which a tip can only move straight up: its K_tt is rounding, and it has no slip to stop."""


class Expectation(NamedTuple):
    """What is known of a contact before it is integrated.

    Attributes:
        duration: of the contact, were the bodies rigid and free meanwhile.
        longest: longest interval.
        outcome: of the rigid-body law.
        moves: whether the bodies move noticeably meanwhile, as in a contact of a given duration; else the contact is the
            rigid-body limit, and its K is constant.
        stepper: integrator of the intervals in which the spring acts.
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
        coefficients: of friction and restitution.
        expected: what is known of the contact beforehand.
        surface: gap at the first touch, from which the penetration is measured.
        inverse_mass: K in the order normal, tangential, at the first touch or of the interval.
        loading: whether the penetration is the largest so far; else the spring unloads, more steeply.
        deepest: penetration at which unloading began.
        slip: sense of slip, or 0 in stick.
        stick_force: tangential force that stick takes at the last state.
        course: what is recorded of the contact.
    """

    stiffness: float
    coefficients: Coefficients
    expected: Expectation
    surface: float
    inverse_mass: Array
    loading: bool = True
    deepest: float = 0.0
    slip: int = 0
    stick_force: float = 0.0
    course: ContactCourse = field(default_factory=ContactCourse)

    @property
    def friction(self) -> float:
        """Coulomb's mu, of compression or of restitution."""
        return self.coefficients.friction if self.loading else self.coefficients.restitution_friction

    @property
    def residual(self) -> float:
        """Penetration at which the force is back at zero."""
        return 0.0 if self.loading else self.deepest * (1.0 - self.coefficients.restitution**2)

    @property
    def compliance_in_stick(self) -> float:
        """K_tt; 0 where there is no slip to stop."""
        normal, tangential = float(self.inverse_mass[0, 0]), float(self.inverse_mass[1, 1])
        return tangential if tangential > NO_SLIP_TO_STOP * normal else 0.0

    @property
    def present_stiffness(self) -> float:
        """Stiffness now; 0 where nothing comes back."""
        restitution = self.coefficients.restitution
        if self.loading:
            return self.stiffness
        return self.stiffness / restitution**2 if restitution else 0.0

    @property
    def ratio(self) -> float:
        """Tangential over normal force; in stick without inertia and without the force that stops leftover slip."""
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

    def history(self) -> ContactHistory:
        """Return the samples of the contact."""
        return self.course.history(None if self.expected.moves else self.inverse_mass)

    def spare_friction(self, penetration: float, stick_force: float) -> float:
        """Return the force by which friction's limit exceeds the force that stick takes."""
        return self.friction * self.present_stiffness * (penetration - self.residual) - abs(stick_force)


class SpringForce:
    """The force of a contact's spring, with what it adds up to: six numbers.

    They are impulse (normal, tangential), work (the same), and the force that stick takes at the beginning and the end.
    """

    def __init__(self, scene: Scene, obstacle: Obstacle, spring: Spring) -> None:
        """Act between a pair of a scene by a spring."""
        self.spring = spring
        body, link = scene.links[obstacle.link], scene.mechanism.links[obstacle.link]
        self._push = pusher(body)
        self._level, self._read = 0.0, None
        if obstacle.corner is not None:
            x, y = (*link.knees, link.tip)[obstacle.corner]
            self._read = point_calls(body, (x - link.centre[0], y - link.centre[1]))
            # The gap of a corner above the surface is its height and this.
            self._level = obstacle.closest(_at_origin(scene), (0.0,) * len(scene.links)).gap
        self._sense = self._sense_corner if self._read else _sense_anywhere(scene, obstacle)
        self._back = None if obstacle.partner is None else pusher(scene.links[obstacle.partner])

    def begin(self, step: float) -> Callable[[], None]:
        """Reset the sums. Return a callback that pushes for a step, by the phase that the spring is in."""
        spring, sense, push, back = self.spring, self._sense, self._push, self._back
        tangential = spring.compliance_in_stick
        stop = 0.0 if spring.slip or not tangential else 1.0 / tangential
        stiffness, ratio, depth = spring.present_stiffness, spring.ratio, spring.surface - spring.residual
        steps: list[tuple[float, float, float, float]] = []
        self._step, self._steps, self._law = step, steps, (stiffness, depth, ratio, stop)
        note, stop = steps.append, stop / step
        height, read = depth - self._level, self._read

        def act_on_corner() -> None:
            """Push a corner off a surface with the normal +y, and note forces and velocities."""
            place, velocity = place_of(), velocity_of()
            normal = stiffness * (height - place.y)
            along = ratio * normal - stop * velocity.x
            push((along, normal), (place.x, place.y))
            note((normal, along, velocity.y, velocity.x))

        def act() -> None:
            """Push by the law, and note forces and velocities."""
            gap, place, opening, slip, n_x, n_y = sense()
            normal = stiffness * (depth - gap)
            along = ratio * normal - stop * slip
            force = (normal * n_x + along * n_y, normal * n_y - along * n_x)
            push(force, place)
            if back is not None:
                back((-force[0], -force[1]), place)
            note((normal, along, opening, slip))

        if read is None:
            return act
        place_of, velocity_of = read
        return act_on_corner

    def totals(self) -> list[float]:
        """Return the six numbers.

        What stops the point in a step is what the step before has left of its motion, forces of the spring and of inertia
        alike. So the second step applies what stick takes at the beginning, and one more step would apply what it takes
        at the end, both up to powers of the step. In slip these two are 0.
        """
        step = self._step
        normal, along, opening, slip = zip(*self._steps, strict=True)
        sums = [sum(normal), sum(along), sum(map(mul, normal, opening)), sum(map(mul, along, slip))]
        found = [step * each for each in sums]
        stiffness, depth, ratio, stop = self._law
        if not stop:
            return [*found, 0.0, 0.0]
        gap, _, _, leftover, _, _ = self._sense()
        last = ratio * stiffness * (depth - gap) - stop * leftover / step
        return [*found, along[1] if len(along) > 1 else last, last]

    def _sense_corner(self) -> tuple[float, Vector, float, float, float, float]:
        assert self._read is not None
        place, velocity = self._read[0](), self._read[1]()
        return place.y + self._level, (place.x, place.y), velocity.y, velocity.x, 0.0, 1.0


Sense = Callable[[], tuple[float, Vector, float, float, float, float]]
"""Gap, place of contact, normal and tangential velocity, and normal (x, y), from the bodies as they are."""


def _at_origin(scene: Scene) -> list[Pose]:
    """Return poses of links whose corners are all at the origin."""
    still = (0.0, 0.0)
    return [
        Pose(still, still, still, still, still, still, (still,) * len(link.knees)) for link in scene.mechanism.links
    ]


def _sense_anywhere(scene: Scene, obstacle: Obstacle) -> Sense:
    """Return the function for a pair whose contact slides along its links."""
    readers = {}
    for number in (obstacle.link, obstacle.partner):
        if number is not None:
            link, body = scene.mechanism.links[number], scene.links[number]
            corners = [(x - link.centre[0], y - link.centre[1]) for x, y in ((0.0, 0.0), *link.knees, link.tip)]
            readers[number] = body, [point_reader(body, each) for each in corners]

    def sense() -> tuple[float, Vector, float, float, float, float]:
        poses, rates = {}, {}
        for number, (body, corners) in readers.items():
            joint, *knees, tip = [read() for read in corners]
            place, rates[number] = (0.0, 0.0), body.angular_velocity
            poses[number] = Pose(
                joint[:2], place, tip[:2], joint[2:], place, tip[2:], tuple(each[:2] for each in knees)
            )
        touch = obstacle.closest(poses, rates)  # type: ignore[arg-type]
        joint_place = poses[obstacle.link].joint
        point = (joint_place[0] + touch.arm[0], joint_place[1] + touch.arm[1])
        return touch.gap, point, *touch.velocity, *touch.normal

    return sense
