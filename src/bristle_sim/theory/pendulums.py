"""Impact of Stronge's single and double pendulum on a rough surface, in generalized speeds (Zhang
2020, sec. 2.4).

Single (2.4.1): a slender rod hinged at O, inclined at gamma to the normal of the surface that its
tip strikes.

Double (2.4.2): slender rods OB of mass m_1 = n m_2 and BC of mass m_2, both of length L, hinged at
O and B, inclined at theta_1 and theta_2 to the normal of the surface that C strikes. In the
generalized speeds q_1 = L phi'_1 and q_2 = L phi'_2/2 the kinetic energy T and the velocity v_C of
C are, with c = cos(theta_1 - theta_2),

    T = (m_1/3 + m_2) q_1^2/2 + 2 m_2 q_2^2/3 + m_2 c q_1 q_2                                        (2.66, 2.93)
    v_C = (-q_1 cos theta_1 - 2 q_2 cos theta_2, q_1 sin theta_1 + 2 q_2 sin theta_2)                (2.68, 2.95)

An impulse (dp_x, dp_y) on C changes the generalized momenta T_1 = dT/dq_1, T_2 = dT/dq_2 by (2.69)

    dT_1 = -cos theta_1 dp_x + sin theta_1 dp_y,    dT_2 = -2 cos theta_2 dp_x + 2 sin theta_2 dp_y.

Friction makes dp_x = -mu sign(v_x) dp_y while C slips, so q is linear in p_y (2.74, 2.80, 2.98).
Slip may stop before or after the end of compression. C then sticks, or slips in the opposite
direction if mu < mu_bar (2.90). The impact ends when the normal work of restitution is W_r = -e*^2
W_c, with the work W_c of compression (2.87). ``two_rods`` solves the impact in the generalized
speeds q. ``impact.energetic_impact`` solves the same impact in the velocities of C. The two
solutions test each other.

An angular velocity is negative if it moves the tip of a rod of positive inclination towards the
surface. ValueError is raised for an argument out of its range. Source beside Zhang: W. J. Stronge,
Proc. R. Soc. Lond. A 431 (1990) 169-181.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bristle_sim.theory.impact_phases import NO_CONTACT
from bristle_sim.theory.monofilament import monofilament_impact
from bristle_sim.theory.numbers import checked_numbers
from bristle_sim.theory.two_rods import RodImpact


@dataclass(frozen=True, slots=True)
class SinglePendulumImpact:
    """The impact of a single pendulum's tip on a surface.

    Attributes:
        normal_compressive_impulse: normal impulse of compression, N s.
        normal_final_impulse: normal impulse of compression and restitution, N s.
        final_rate: angular velocity after the impact, rad/s.
        rebound_ratio: ratio of the angular velocities after and before the impact.
        outcome: name of the outcome.
    """

    normal_compressive_impulse: float
    normal_final_impulse: float
    final_rate: float
    rebound_ratio: float
    outcome: str


def single_pendulum_impact(
    rod_mass: float,
    rod_length: float,
    impact_angle: float,
    rate: float,
    friction: float,
    restitution: float,
) -> SinglePendulumImpact:
    """Return the impact of a hinged slender rod whose tip strikes a rough surface.

    The rod is Stronge's single pendulum (Zhang 2020, sec. 2.4.1 and fig. 2.26). The ratio of its
    angular velocities after and before the impact is

        phi'_f/phi'(0) = -e* sqrt((1 - mu cot gamma)/(1 + mu cot gamma)).

    There is no rebound for mu >= tan gamma.

    Args:
        rod_mass: mass of the rod, kg.
        rod_length: length of the rod, m.
        impact_angle: angle gamma of the rod to the surface's normal, 0 < gamma <= pi/2, rad.
        rate: angular velocity before the impact, rad/s; negative if the tip approaches the surface.
        friction: coefficient of friction mu.
        restitution: energetic coefficient of restitution e*.

    At gamma = 45 deg and mu = 0.6 the ratio is -e* sqrt(0.4/1.6) = -e*/2:

    >>> import math
    >>> impact = single_pendulum_impact(1.0, 1.0, math.pi / 4.0, -2.0, 0.6, 0.5)
    >>> print(f"{impact.rebound_ratio:.6f} {impact.final_rate:.6f} {impact.outcome}")
    -0.250000 0.500000 rebound
    """
    mass, length = checked_numbers(rod_mass=rod_mass, rod_length=rod_length)
    angle, rate = checked_numbers(impact_angle=impact_angle, rate=rate)
    mu, e = checked_numbers(friction=friction, restitution=restitution)
    # A bristle on a hub of radius 0, whose rate is positive where its tip approaches.
    impact = monofilament_impact(mass, length, 0.0, -rate, 1.0, angle, mu, e)
    final = rate if impact.outcome == NO_CONTACT else -float(impact.final_bristle_rate) + 0.0
    return SinglePendulumImpact(
        normal_compressive_impulse=float(impact.normal_compressive_impulse),
        normal_final_impulse=float(impact.normal_final_impulse),
        final_rate=final,
        rebound_ratio=final / rate + 0.0 if rate else 1.0,
        outcome=impact.outcome_name,
    )


@dataclass(frozen=True, slots=True)
class DoublePendulumImpact:
    """The impact of a double pendulum's tip on a surface.

    Attributes:
        final_rate_1, final_rate_2: angular velocities of the two rods after the impact, rad/s.
        normal_compressive_impulse: normal impulse of compression, N s.
        normal_final_impulse: normal impulse of compression and restitution, N s.
        slip_stop_impulse: normal impulse at which slip stops, N s; inf if slip does not stop.
        phases: names of the phases of the impact, in order, with slip or stick of the tip.
        kinetic_energy_ratio: ratio of the kinetic energies after and before the impact.
        outcome: name of the outcome.
    """

    final_rate_1: float
    final_rate_2: float
    normal_compressive_impulse: float
    normal_final_impulse: float
    slip_stop_impulse: float
    phases: tuple[str, ...]
    kinetic_energy_ratio: float
    outcome: str


def double_pendulum_impact(
    rod_mass: float,
    mass_ratio: float,
    rod_length: float,
    angle_1: float,
    angle_2: float,
    rate_1: float,
    rate_2: float,
    friction: float,
    restitution: float,
    restitution_friction: float | None = None,
) -> DoublePendulumImpact:
    """Return the impact of two hinged slender rods whose tip strikes a rough surface.

    The rods are Stronge's double pendulum with any ratio of masses (Zhang 2020, eqs. 2.66-2.108).

    Args:
        rod_mass: mass of the second rod, whose tip strikes, kg.
        mass_ratio: ratio of the mass of the first rod to that of the second rod.
        rod_length: length of either rod, m.
        angle_1: angle of the first rod to the surface's normal, -pi/2 to pi/2, rad.
        angle_2: angle of the second rod to the surface's normal, -pi/2 to pi/2, rad.
        rate_1: angular velocity of the first rod before the impact, rad/s.
        rate_2: angular velocity of the second rod before the impact, rad/s.
        friction: coefficient of friction in compression.
        restitution: energetic coefficient of restitution.
        restitution_friction: coefficient of friction in restitution; ``friction`` by default, as in
            the dissertation.

    A frictionless impact with e* = 1 conserves the kinetic energy:

    >>> impact = double_pendulum_impact(5.0, 1.0, 1.0, 0.35, 0.52, -0.1, -0.2, 0.0, 1.0)
    >>> print(f"{impact.kinetic_energy_ratio:.9f} {impact.outcome}")
    1.000000000 rebound
    """
    mass, ratio, length = checked_numbers(
        rod_mass=rod_mass, mass_ratio=mass_ratio, rod_length=rod_length
    )
    angles = checked_numbers(angle_1=angle_1, angle_2=angle_2)
    first, second = checked_numbers(rate_1=rate_1, rate_2=rate_2)
    mu, e, later = checked_numbers(
        friction=friction,
        restitution=restitution,
        restitution_friction=friction if restitution_friction is None else restitution_friction,
    )
    speeds = np.array([length * first, length * second / 2.0])
    impact = RodImpact(mass, ratio, angles, speeds)
    before = impact.kinetic_energy
    outcome = impact.resolve(mu, e, later)
    return DoublePendulumImpact(
        final_rate_1=float(impact.speeds[0]) / length,
        final_rate_2=2.0 * float(impact.speeds[1]) / length,
        normal_compressive_impulse=impact.compressive_impulse,
        normal_final_impulse=impact.impulse,
        slip_stop_impulse=impact.slip_stop,
        phases=tuple(impact.phases),
        kinetic_energy_ratio=impact.kinetic_energy / before if before > 0.0 else 1.0,
        outcome=outcome,
    )
