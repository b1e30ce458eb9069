"""Impact of a radial bristle on a hub that keeps its speed, in closed form (Zhang 2020, eqs.
2.19-2.65).

The bristle, a slender rod of mass m and length L, stands at the angle gamma to the workpart's
normal when its tip strikes. The hub (radius r_h) has the angular velocity omega, the bristle phi'
(before the impact R omega). The tip moves along one line, with the velocity

    v_C (cos gamma, -sin gamma),    v_C = L phi' + r_h omega                                                      (2.24)

so slip and compression stop together, at the angular velocity phi' = -(r_h/L) omega of the bristle.
The generalized impulse L cos gamma dp_x - L sin gamma dp_y (2.27) changes the momentum m L^2/3 phi'
(2.25). Since friction opposes slip, this impulse is -L s_1 dp_y in compression and -L s_2 dp_y in
restitution, with

    s_1 = sin gamma + mu_1 cos gamma,    s_2 = sin gamma - mu_2 cos gamma.

The results follow by integration.

Arguments broadcast; the functions return floats for floats. Impulses and works are those of the
workpart on the bristle; rates are positive in the hub's sense of rotation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Number
from bristle_sim.theory.impact_phases import NO_CONTACT, NO_REBOUND, OUTCOMES, REBOUND, STICTION
from bristle_sim.theory.numbers import require

LEAST_ANGLE = 1e-150
"""Least impact angle, rad. Without friction, impulses are inversely proportional to this angle, and
would overflow."""


@dataclass(frozen=True, slots=True)
class MonofilamentImpact:
    """The impact of a bristle in one strike, or in each of an array of strikes.

    Attributes:
        normal_compressive_impulse: normal impulse of compression, N s.
        normal_final_impulse: normal impulse of compression and restitution, N s.
        tangential_compressive_impulse: tangential impulse of compression, N s.
        normal_compressive_work: work of the normal force in compression, J.
        tangential_compressive_work: work of friction in compression, J.
        initial_bristle_rate, final_bristle_rate: absolute angular velocity of the bristle before
            and after the impact, rad/s.
        outcome: index in ``impact_phases.OUTCOMES`` of no contact, rebound, no rebound (e* = 0) or
            stiction.
    """

    normal_compressive_impulse: Number
    normal_final_impulse: Number
    tangential_compressive_impulse: Number
    normal_compressive_work: Number
    tangential_compressive_work: Number
    initial_bristle_rate: Number
    final_bristle_rate: Number
    outcome: Number

    @property
    def rebound_ratio(self) -> Number:
        """Ratio of the bristle's angular velocities after and before the impact (2.65).

        Raises:
            ValueError: where the angular velocity before the impact is 0.
        """
        if np.any(np.equal(self.initial_bristle_rate, 0.0)):
            raise ValueError(
                "speed_ratio * hub_speed = 0: must not be 0 where a rebound ratio is requested (in rad/s)"
            )
        return self.final_bristle_rate / self.initial_bristle_rate

    @property
    def outcome_name(self) -> str:
        """Name of the outcome of a single strike."""
        return OUTCOMES[int(self.outcome)]


def monofilament_impact(
    mass: Number,
    length: Number,
    hub_radius: Number,
    hub_speed: Number,
    speed_ratio: Number,
    impact_angle: Number,
    friction: Number,
    restitution: Number,
    restitution_friction: Number | None = None,
) -> MonofilamentImpact:
    """Return the impact of a rigid radial bristle on a hub of constant speed, in closed form.

    The final normal impulse p_fy and the final angular velocity phi'_f are (2.48, 2.65)

        p_fy = p_cy (1 + e* sqrt(s_1/s_2)),    phi'_f = -(r_h/L) omega - e* (v_C/L) sqrt(s_2/s_1),

    with s_1 = sin gamma + mu_1 cos gamma, s_2 = sin gamma - mu_2 cos gamma, the speed v_C of
    ``tip_speed`` and the impulse p_cy of ``normal_compressive_impulse``. In compression the
    tangential impulse is p_cx = -mu_1 p_cy (2.56), the normal work -v_C sin gamma p_cy/2 (2.40) and
    the tangential work v_C cos gamma p_cx/2 (2.58).

    p_fy grows without bound as mu_2 approaches tan gamma. With mu_2 >= tan gamma there is no
    restitution: p_fy = p_cy, as for e* = 0. The tip strikes only if v_C > 0; otherwise impulses and
    works are zero and the angular velocity does not change.

    Args:
        mass: mass of the bristle, kg.
        length: length L of the bristle, m.
        hub_radius: radius r_h of the hub, m.
        hub_speed: angular velocity omega of the hub, rad/s.
        speed_ratio: ratio of the bristle's angular velocity before the impact to that of the hub.
        impact_angle: angle gamma of the bristle to the workpart's normal, at least 1e-150 rad.
        friction: coefficient of friction mu_1 in compression.
        restitution: energetic coefficient of restitution e* (2.47), in [0, 1].
        restitution_friction: coefficient of friction mu_2 in restitution; mu_1 by default (case 2,
            eq. 2.59).

    Raises:
        ValueError: if the impact angle is too small.

    A rod of 3 kg and 1 m lies along the surface (gamma = 90 deg) and strikes at 1 rad/s on a hub of
    zero radius. Its compressive impulse is m v_C/3 = 1 N s, and it rebounds at half its angular
    velocity.

    >>> import math
    >>> impact = monofilament_impact(3.0, 1.0, 0.0, 1.0, 1.0, math.pi / 2.0, 0.0, 0.5)
    >>> print(impact.normal_compressive_impulse, impact.normal_final_impulse, impact.final_bristle_rate)
    1.0 1.5 -0.5
    """
    least = f"must be at least {LEAST_ANGLE:g}, as impulses grow as its inverse (in rad)"
    require("impact_angle", impact_angle, np.greater_equal(impact_angle, LEAST_ANGLE), least)
    later = friction if restitution_friction is None else restitution_friction
    sine, cosine = np.sin(impact_angle), np.cos(impact_angle)
    leaves = np.less(later, stiction_friction(impact_angle))
    s_1 = sine + friction * cosine
    s_2 = np.where(leaves, np.maximum(sine - later * cosine, 0.0), 0.0)[()]
    speed = tip_speed(length, hub_radius, hub_speed, speed_ratio)
    pressed = normal_compressive_impulse(mass, speed, impact_angle, friction)
    rubbed = 0.0 - np.multiply(friction, pressed)
    factor = np.where(speed > 0.0, -restitution * np.sqrt(s_2 / s_1), 1.0)
    ending = np.where(np.greater(restitution, 0.0), np.where(leaves, REBOUND, STICTION), NO_REBOUND)
    return MonofilamentImpact(
        normal_compressive_impulse=pressed,
        normal_final_impulse=pressed
        * (1.0 + restitution * np.sqrt(s_1 / np.where(s_2 > 0.0, s_2, np.inf))),
        tangential_compressive_impulse=rubbed,
        normal_compressive_work=-0.5 * np.multiply(speed, sine) * pressed,
        tangential_compressive_work=0.5 * np.multiply(speed, cosine) * rubbed,
        initial_bristle_rate=np.multiply(speed_ratio, hub_speed),
        final_bristle_rate=-(hub_radius / length) * hub_speed + factor * speed / length,
        outcome=np.where(speed > 0.0, ending, NO_CONTACT)[()],
    )


def tip_speed(length: Number, hub_radius: Number, hub_speed: Number, speed_ratio: Number) -> Number:
    """Return the speed of a radial bristle's tip before the impact, m/s (Zhang 2020, eq. 2.24).

    The speed is v_C = (R L + r_h) omega, with the angular velocity omega of the hub, the ratio R of
    the bristle's angular velocity to omega, the length L and the hub's radius r_h. The dissertation
    writes kappa omega L in (2.33), with kappa = R + r_h/L.

    In the dissertation R = 3.23, L = 27 mm and r_h = 27.5 mm, so that R L + r_h = 114.71 mm:

    >>> print(f"{tip_speed(0.027, 0.0275, 100.0, 3.23):.3f}")
    11.471
    """
    return hub_speed * (speed_ratio * length + hub_radius)


def stiction_friction(impact_angle: Number) -> Number:
    """Return the least coefficient of friction at which the tip cannot leave the workpart.

    At this or a larger coefficient of friction in restitution no impulse lifts the tip. The least
    coefficient is tan gamma, with the impact angle gamma in rad (Zhang 2020, eq. 2.51).

    >>> import math
    >>> print(f"{stiction_friction(math.pi / 4.0):.6f}")
    1.000000
    """
    # The tangent of the float nearest to pi/2 is 1.6e16, which exceeds every friction.
    return np.tan(impact_angle)


def normal_compressive_impulse(
    mass: Number, tip_speed: Number, impact_angle: Number, friction: Number
) -> Number:
    """Return the normal impulse of compression in a strike, N s (Zhang 2020, eq. 2.37).

    The impulse is m v_C/(3 s_1), with s_1 = sin(gamma) + mu cos(gamma), the bristle's mass m (kg),
    the speed v_C of its tip (m/s), the impact angle gamma (rad) and the coefficient of friction mu.

    With sin(gamma) = 3/5, cos(gamma) = 4/5 and mu = 1/2, s_1 is 1:

    >>> import math
    >>> print(f"{normal_compressive_impulse(3.0, 2.0, math.asin(0.6), 0.5):.6f}")
    2.000000
    """
    return (
        mass
        * np.maximum(tip_speed, 0.0)
        / (3.0 * (np.sin(impact_angle) + friction * np.cos(impact_angle)))
    )
