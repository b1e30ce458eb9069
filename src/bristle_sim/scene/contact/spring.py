"""The contact spring of the compliant law, its forces as a load on the scene, and the time that a contact on it lasts."""

from __future__ import annotations

import math
from collections.abc import Callable
from operator import mul
from typing import NamedTuple

from bristle_sim.arrays import Array
from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact.laws import Coefficients
from bristle_sim.scene.contact.obstacles import ClosestApproach
from bristle_sim.scene.engine import point_reader, pusher
from bristle_sim.scene.mechanism import Vector
from bristle_sim.theory.impact import Impact


class Plane(NamedTuple):
    """The plane of contact: unit vectors, and the height of the plane along its normal."""

    normal: Vector
    tangent: Vector
    height: float

    def penetration(self, tip: Vector) -> float:
        """Return the depth of a tip below the plane."""
        return self.height - tip[0] * self.normal[0] - tip[1] * self.normal[1]

    def components(self, velocity: Vector) -> Vector:
        """Return the (normal, tangential) components of a velocity."""
        return (
            velocity[0] * self.normal[0] + velocity[1] * self.normal[1],
            velocity[0] * self.tangent[0] + velocity[1] * self.tangent[1],
        )


class Spring:
    """Normal spring and Coulomb friction between the last link's tip and a plane, in the phase the contact is in.

    Attributes:
        plane: of contact.
        stiffness: of the spring in compression, engine units.
        coefficients: of friction and restitution.
        inverse_mass: K at the first touch.
        coupling, tangential: K_nt and K_tt where stick is computed.
        loading: whether the penetration is the largest so far; else the spring unloads, more steeply.
        peak, residual: penetration at which unloading began, and the one at which its force ends.
        slip: direction of slip, or 0 in stick.
    """

    def __init__(
        self,
        plane: Plane,
        slip_velocity: float,
        inverse_mass: Array,
        stiffness: float,
        coefficients: Coefficients,
    ) -> None:
        """Build the spring of a tip that touches the plane now, with the K of the contact."""
        self.plane = plane
        self.inverse_mass = inverse_mass
        self.follow(inverse_mass)
        self.stiffness = stiffness
        self.coefficients = coefficients
        self.loading = True
        self.peak = self.residual = 0.0
        self.slip = math.copysign(1.0, slip_velocity) if slip_velocity else 0.0

    def follow(self, inverse_mass: Array) -> None:
        """Compute stick with the K of the bodies as they stand now: they turn while the contact lasts."""
        (normal, self.coupling), (_, tangential) = inverse_mass.tolist()
        # A tip that moves straight up alone has a K_tt of rounding, and no slip to stop.
        self.tangential = tangential if tangential > 1e-14 * normal else 0.0

    @property
    def friction(self) -> float:
        """mu of the phase the contact is in."""
        return self.coefficients.friction if self.loading else self.coefficients.restitution_friction

    @property
    def stop(self) -> float:
        """Tangential impulse per unit of slip velocity that stops the point within a step of stick, 1/K_tt; 0 in slip."""
        return 0.0 if self.slip or not self.tangential else 1.0 / self.tangential

    def unload(self, tip: Vector) -> None:
        """Begin unloading: compression has ended with the tip here."""
        self.loading = False
        self.peak = self.plane.penetration(tip)
        self.residual = self.peak * (1.0 - self.coefficients.restitution**2)

    def line(self) -> tuple[float, float, float]:
        """Return the spring's present stiffness, depth at which its force ends, and tangential over normal force.

        Past that depth the spring would pull, so that the end of the contact is a clean root. In stick the ratio leaves
        out inertia, and what stops leftover slip.
        """
        ratio = -self.friction * self.slip
        if not self.slip and self.tangential:
            ratio = -self.coupling / self.tangential
        if self.loading:
            return self.stiffness, 0.0, ratio
        restitution = self.coefficients.restitution
        return (self.stiffness / restitution**2 if restitution else 0.0), self.residual, ratio

    def forces(self, depth: float) -> Vector:
        """Return (normal, tangential) force at a penetration."""
        stiffness, end, ratio = self.line()
        normal = stiffness * (depth - end)
        return normal, ratio * normal


class SpringLoad:
    """The forces of a spring as a load on the last link's tip, with what they add up to.

    Attributes:
        spring: whose law acts.
    """

    symmetric = False

    def __init__(
        self,
        scene: Scene,
        touch: ClosestApproach,
        inverse_mass: Array,
        stiffness: float,
        coefficients: Coefficients,
    ) -> None:
        """Build the load of a scene whose last link's tip is at the point of touch now, on a plane through that point."""
        link = scene.mechanism.links[-1]
        body, point = scene.links[-1], (link.tip[0] - link.centre[0], link.tip[1] - link.centre[1])
        self._tip, self._push = point_reader(body, point), pusher(body)
        x, y, _, _ = self._tip()
        plane = Plane(touch.normal, touch.tangent, x * touch.normal[0] + y * touch.normal[1])
        self.spring = Spring(plane, touch.velocity[1], inverse_mass, stiffness, coefficients)

    def begin(self, step: float) -> Callable[[], None]:
        """Forget what was added up; return what pushes on the tip for a step, by the law that acts until something turns."""
        plane, stop = self.spring.plane, self.spring.stop
        (n_x, n_y), (t_x, t_y) = plane.normal, plane.tangent
        stiffness, end, ratio = self.spring.line()
        height, tip, push = plane.height - end, self._tip, self._push
        steps: list[tuple[float, float, float, float]] = []
        note = steps.append

        def act() -> None:
            """Push on the tip by the law, and note forces and velocities."""
            x, y, u, v = tip()
            slip = u * t_x + v * t_y
            normal = stiffness * (height - x * n_x - y * n_y)
            tangential = ratio * normal
            if stop:
                tangential -= stop * slip / step
            push((normal * n_x + tangential * t_x, normal * n_y + tangential * t_y), (x, y))
            note((normal, tangential, u * n_x + v * n_y, slip))

        self._step, self._steps, self._law = step, steps, (stiffness, height, ratio, stop)
        return act

    def totals(self) -> list[float]:
        """Return impulse (normal, tangential), work (the same), and the force that stick takes at the beginning and the end.

        What stops the point in a step is what the step before has left of its motion, forces of the spring and of inertia
        alike. So the second step applies what stick takes at the beginning, and one more step would apply what it takes
        at the end, both up to powers of the step. In slip these two are 0.
        """
        step = self._step
        normal, tangential, opening, slip = zip(*self._steps, strict=True)
        sums = [sum(normal), sum(tangential), sum(map(mul, normal, opening)), sum(map(mul, tangential, slip))]
        found = [step * each for each in sums]
        stiffness, height, ratio, stop = self._law
        if not stop:
            return [*found, 0.0, 0.0]
        (n_x, n_y), (t_x, t_y) = self.spring.plane.normal, self.spring.plane.tangent
        x, y, u, v = self._tip()
        last = ratio * stiffness * (height - x * n_x - y * n_y) - stop * (u * t_x + v * t_y) / step
        return [*found, tangential[1] if len(tangential) > 1 else last, last]

    def fails(self, totals: list[float]) -> bool:
        """Return that a spring always acts."""
        del totals
        return False


def time_at_unit_stiffness(impact: Impact, velocity: float, restitution: float) -> float:
    """Return the time in touch for k = 1 in the rigid-body limit; it scales with 1/sqrt(k).

    Within a phase the normal velocity and force obey v' = a N, N' = -k v with the phase's own compliance a, so the
    phase is a piece of a harmonic motion between velocities and forces that the impact law knows.
    """
    works = [float(work) for work in impact.phase_work_normal]
    time, stored = 0.0, 0.0
    for index, impulse in enumerate(float(each) for each in impact.phase_impulse):
        if impulse <= 0.0:
            continue
        stiffness = 1.0
        if index >= 2:
            stiffness, stored = 1.0 / restitution**2, sum(works[index:])
        left = stored - works[index]
        change = 2.0 * (works[index] / impulse - velocity)
        time += _phase_time(
            stiffness, impulse, (velocity, velocity + change), (_force(stiffness, stored), _force(stiffness, left))
        )
        stored, velocity = left, velocity + change
    return time


def _force(stiffness: float, stored: float) -> float:
    return math.sqrt(2.0 * stiffness * max(stored, 0.0))


def _phase_time(stiffness: float, impulse: float, velocities: Vector, forces: Vector) -> float:
    """Return the duration of a phase of given normal impulse between two velocities and forces."""
    compliance = (velocities[1] - velocities[0]) / impulse
    if compliance <= 1e-12 * max(map(abs, velocities)) / impulse:
        mean = 0.5 * (forces[0] + forces[1])
        return impulse / mean if mean > 0.0 else 0.0
    impedance = math.sqrt(compliance / stiffness)
    before, after = (math.atan2(v, impedance * f) for v, f in zip(velocities, forces, strict=True))
    return (after - before) / math.sqrt(compliance * stiffness)
