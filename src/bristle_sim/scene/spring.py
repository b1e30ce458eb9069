"""The contact spring of the compliant law: its forces as a load on the scene, and how long a contact on it lasts."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact_laws import Coefficients
from bristle_sim.scene.mechanism import Vector
from bristle_sim.scene.obstacles import Touch
from bristle_sim.theory.impact import Impact

__all__ = ["Spring", "time_at_unit_stiffness"]


class Spring:
    """Normal spring and Coulomb friction between the last link's tip and a plane through the point of first touch.

    Attributes:
        loading: whether the penetration is the largest so far; else the spring is on its steeper way out.
        peak: penetration at which unloading began; ``residual`` is the one at which its force ends.
        slip: direction of slip, or 0 in stick.
    """

    def __init__(
        self,
        scene: Scene,
        touch: Touch,
        inverse_mass: NDArray[np.float64],
        stiffness: float,
        coefficients: Coefficients,
    ) -> None:
        """For a scene whose last link's tip is at the point of touch now."""
        link = scene.mechanism.links[-1]
        self.body = scene.links[-1]
        self.anchor = (link.tip[0] - link.centre[0], link.tip[1] - link.centre[1])
        self.normal, self.tangent = touch.normal, touch.tangent
        tip = self.body.local_to_world(self.anchor)
        self.surface = tip.x * self.normal[0] + tip.y * self.normal[1]
        (_, self.coupling), (_, self.tangential) = inverse_mass.tolist()
        self.stiffness = stiffness
        self.coefficients = coefficients
        self.loading = True
        self.peak = self.residual = 0.0
        self.slip = math.copysign(1.0, touch.velocity[1]) if touch.velocity[1] else 0.0
        self._totals = [0.0, 0.0, 0.0, 0.0]

    @property
    def friction(self) -> float:
        """mu of the phase the contact is in."""
        return self.coefficients.friction if self.loading else self.coefficients.restitution_friction

    def unload(self, tip: Vector) -> None:
        """Compression has ended with the tip here."""
        self.loading = False
        self.peak = self.penetration(tip)
        self.residual = self.peak * (1.0 - self.coefficients.restitution**2)

    def penetration(self, tip: Vector) -> float:
        """Depth of the tip below the plane."""
        return self.surface - tip[0] * self.normal[0] - tip[1] * self.normal[1]

    def components(self, velocity: Vector) -> Vector:
        """(normal, tangential) components of a velocity."""
        return (
            velocity[0] * self.normal[0] + velocity[1] * self.normal[1],
            velocity[0] * self.tangent[0] + velocity[1] * self.tangent[1],
        )

    def normal_force(self, depth: float) -> float:
        """Force of the spring; past its residual depth it would pull, so that the end of the contact is a clean root."""
        if self.loading:
            return self.stiffness * depth
        return self.stiffness / self.coefficients.restitution**2 * (depth - self.residual)

    def forces(self, depth: float) -> Vector:
        """(normal, tangential) force at a penetration, stick without the share that stops leftover slip."""
        normal = self.normal_force(depth) if self.loading or self.coefficients.restitution else 0.0
        if self.slip:
            return normal, -self.friction * self.slip * normal
        return normal, -self.coupling / self.tangential * normal if self.tangential else 0.0

    def begin(self) -> None:
        """Forget what was added up."""
        self._totals = [0.0, 0.0, 0.0, 0.0]

    def apply(self, step: float) -> None:
        """Push on the tip for the next engine step, and add up impulses and works."""
        tip = self.body.local_to_world(self.anchor)
        normal, tangential = self.forces(self.penetration(tip))
        moving = self.components(self.body.velocity_at_local_point(self.anchor))
        if not self.slip and self.tangential:
            tangential -= moving[1] / (self.tangential * step)
        force = (
            normal * self.normal[0] + tangential * self.tangent[0],
            normal * self.normal[1] + tangential * self.tangent[1],
        )
        self.body.apply_force_at_world_point(force, tip)
        totals = self._totals
        totals[0] += normal * step
        totals[1] += tangential * step
        totals[2] += normal * moving[0] * step
        totals[3] += tangential * moving[1] * step

    def totals(self, step: float) -> list[float]:
        """Normal and tangential impulse, normal and tangential work."""
        del step
        return list(self._totals)

    def fails(self, totals: list[float]) -> bool:
        """A spring always acts."""
        del totals
        return False


def time_at_unit_stiffness(impact: Impact, velocity: float, restitution: float) -> float:
    """Time in touch for k = 1 in the rigid-body limit; it scales with 1/sqrt(k).

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
    """Duration of a phase of given normal impulse between two velocities and forces."""
    compliance = (velocities[1] - velocities[0]) / impulse
    if compliance <= 1e-12 * max(map(abs, velocities)) / impulse:
        mean = 0.5 * (forces[0] + forces[1])
        return impulse / mean if mean > 0.0 else 0.0
    impedance = math.sqrt(compliance / stiffness)
    before, after = (math.atan2(v, impedance * f) for v, f in zip(velocities, forces, strict=True))
    return (after - before) / math.sqrt(compliance * stiffness)
