"""The force law of a contact with springs, and the stiffness at which a contact lasts a given time.

The normal force N is bilinear in the penetration delta: N = k delta while delta exceeds every
earlier value, and

    N = (k/e*^2) (delta - delta_r),    delta_r = (1 - e*^2) delta_max,

otherwise, down to 0 at delta_r. The spring thus returns e*^2 of the work of loading, for any motion of
the bodies (Stronge 1990).

Here e* is the energetic coefficient of restitution and delta_max the largest penetration. If the
tangential compliance eta^2 is not 0, a spring of the stiffness k/eta^2 joins the contact point to a
foot on the surface. While the foot sticks, the tangential force is T = -(k/eta^2) (x - x_foot),
with the coordinates x of the contact point and x_foot of the foot. The friction limit is abs(T) <=
mu N. Where T would exceed this limit, the foot slides in the sense s with T = -mu s N. The foot's
velocity is then v_t + mu s eta^2 kappa v_n, with the velocity (v_n, v_t) of the contact point. The
stiffness ratio kappa is 1 in loading and 1/e*^2 in unloading (Maw, Barber and Fawcett 1976;
Stronge, *Impact Mechanics*, 2nd ed., sec. 5).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from bristle_sim.theory.impact_phases import OUTCOMES, STICTION, Impact

Vector = tuple[float, float]

# Rounding error of the change of velocity in a phase, as a fraction of the velocities at its ends.
# A phase with a smaller change is treated as a motion at constant velocity.
ROUNDING = 1e-12

# Least e* other than 0. Unloading takes e* times as long as loading; with a smaller e* it would be
# too short for double precision.
LEAST_RESTITUTION = 1e-3


@dataclass(frozen=True, slots=True)
class ContactSpring:
    """The springs and the friction of a contact, in SI or any other consistent units.

    Attributes:
        stiffness: normal stiffness k in loading.
        restitution: energetic coefficient of restitution e*.
        friction: Coulomb's coefficient of friction in loading.
        restitution_friction: Coulomb's coefficient of friction in unloading.
        compliance: ratio eta^2 of the normal to the tangential stiffness. With 0 there is no
            tangential spring: the contact is rigid along the surface.
        deepest: penetration at which unloading began; None while the normal spring is loading.

    A spring with e* = 0.5 is loaded to a penetration of 0.5 and unloads to the residual 0.375:

    >>> from dataclasses import replace
    >>> spring = ContactSpring(stiffness=1000.0, restitution=0.5, friction=0.3, restitution_friction=0.3)
    >>> spring.normal_force(0.25)
    250.0
    >>> unloading = replace(spring, deepest=0.5)
    >>> unloading.residual
    0.375
    >>> unloading.normal_force(0.5)
    500.0
    >>> unloading.normal_force(0.375)
    0.0
    """

    stiffness: float
    restitution: float
    friction: float
    restitution_friction: float
    compliance: float = 0.0
    deepest: float | None = None

    @property
    def loading(self) -> bool:
        """Whether the normal spring is being loaded (True) or unloaded."""
        return self.deepest is None

    @property
    def residual(self) -> float:
        """Penetration at which the normal force is 0; in unloading the depth of the dent."""
        return 0.0 if self.deepest is None else self.deepest * (1.0 - self.restitution**2)

    @property
    def steepness(self) -> float:
        """Present normal stiffness divided by the normal stiffness in loading.

        This ratio kappa is 1 in loading and 1/e*^2 in unloading. Without restitution (e* = 0) kappa
        is 0 in unloading, because there is no force.
        """
        if self.deepest is None:
            return 1.0
        return 1.0 / self.restitution**2 if self.restitution else 0.0

    @property
    def coefficient(self) -> float:
        """Coulomb's coefficient of friction in the present phase."""
        return self.friction if self.deepest is None else self.restitution_friction

    def normal_force(self, penetration: float) -> float:
        """Return the normal force at a penetration."""
        return self.stiffness * self.steepness * (penetration - self.residual)

    def foot_velocity(self, velocity: Vector, slip: int) -> float:
        """Return the velocity of the tangential spring's sliding foot along the surface.

        Without a tangential spring the result is the tangential velocity of the contact point.

        ``velocity`` is the (normal, tangential) velocity of the contact point. ``slip`` is the
        sense in which the foot slides, -1 or 1.
        """
        stretching = self.coefficient * slip * self.compliance * self.steepness
        return velocity[1] + stretching * velocity[0]

    def tangential_force(self, place: float, foot: float) -> float:
        """Return the force of the tangential spring while its foot sticks.

        ``place`` is the coordinate of the contact point along the surface, ``foot`` the coordinate
        of the spring's foot.
        """
        return -(self.stiffness / self.compliance) * (place - foot)

    def foot(self, place: float, force: float) -> float:
        """Return the coordinate of the tangential spring's foot for a given force of the spring.

        ``place`` is the coordinate of the contact point, ``force`` the force of the spring.
        """
        return place + force * self.compliance / self.stiffness


def check_restitution(restitution: float) -> None:
    """Check that a contact with this restitution can be simulated over its duration.

    Raises:
        ValueError: for a coefficient between 0 and LEAST_RESTITUTION.
    """
    if 0.0 < restitution < LEAST_RESTITUTION:
        raise ValueError(
            f"restitution = {restitution:g}: must be 0, or at least {LEAST_RESTITUTION:g}, for a contact resolved in"
            " time (dimensionless)"
        )


def frictionless_stiffness(inverse_mass: float, restitution: float, duration: float) -> float:
    """Return the normal loading stiffness at which a frictionless contact lasts a given time, N/m.

    The stiffness is k = (pi (1 + e*)/(2 T))^2/K_nn, with the duration T (s), the energetic
    coefficient of restitution e* and the inverse mass K_nn along the normal (1/kg).

    A point of 1 kg on a spring of 1 N/m is in contact for half a period, pi s:

    >>> print(f"{frictionless_stiffness(1.0, 1.0, math.pi):.6f}")
    1.000000
    """
    return (0.5 * math.pi * (1.0 + restitution) / duration) ** 2 / inverse_mass


def stiffness_for_duration(
    impact: Impact, velocity: float, restitution: float, duration: float
) -> float:
    """Return the normal loading stiffness at which a contact lasts a given time, N/m.

    The result holds in the limit of short contacts, in which the duration is inversely proportional
    to the square root of the stiffness. In a phase of the impact let a be the change of the normal
    velocity v per unit normal impulse. With a stiffness of 1 the normal force N and v obey v' = a
    N, and N' = -v in loading or N' = -v/e*^2 in unloading. The phase is therefore part of a
    harmonic motion. The duration of the phase follows from v and N at its start and at its end. The
    impact law gives both. A contact that ends in stiction lasts until the end of compression: its
    restitution has no impulse but that of rounding error.

    Args:
        impact: result of the rigid-body law for the same impact.
        velocity: normal velocity before the impact, which is negative, m/s.
        restitution: energetic coefficient of restitution e*.
        duration: required duration of the contact, s.

    A point of 1 kg that is in contact for pi/2 s needs a stiffness of 4 N/m, as half a period of
    its oscillation is then pi/2 s:

    >>> from bristle_sim.theory.impact import energetic_impact
    >>> impact = energetic_impact([[1.0, 0.0], [0.0, 1.0]], (-3.0, 0.0), 0.0, 1.0)
    >>> print(f"{stiffness_for_duration(impact, -3.0, 1.0, math.pi / 2.0):.6f}")
    4.000000
    """
    works = impact.phase_work_normal.tolist()
    time = 0.0
    stored = 0.0
    phases = 2 if impact.outcome_name == OUTCOMES[STICTION] else 4
    for index, impulse in enumerate(impact.phase_impulse.tolist()[:phases]):
        if impulse <= 0.0:
            continue
        stiffness = 1.0
        if index >= 2:
            stiffness = 1.0 / restitution**2
            stored = sum(works[index:])
        left = stored - works[index]
        change = 2.0 * (works[index] / impulse - velocity)
        forces = [math.sqrt(2.0 * stiffness * max(energy, 0.0)) for energy in (stored, left)]
        compliance = change / impulse
        velocities = (velocity, velocity + change)
        if change <= ROUNDING * max(map(abs, velocities)):
            time += 2.0 * impulse / sum(forces) if any(forces) else 0.0
        else:
            impedance = math.sqrt(compliance / stiffness)
            before, after = (
                math.atan2(v, impedance * f) for v, f in zip(velocities, forces, strict=True)
            )
            time += (after - before) / math.sqrt(compliance * stiffness)
        stored = left
        velocity = velocity + change
    return (time / duration) ** 2
