"""Stronge's single and double pendulum against a rough surface, in generalized speeds (Zhang 2020,
sec. 2.4).

Single (2.4.1): a slender rod hinged at O, inclined at gamma to the normal of the surface that its
tip strikes.

Double (2.4.2): slender rods OB of mass m_1 = n m_2 and BC of mass m_2, both of length L, hinged at
O and B, inclined at theta_1 and theta_2 to the normal of the surface that C strikes. In the
generalized speeds q_1 = L phi'_1 and q_2 = L phi'_2/2, with c = cos(theta_1 - theta_2),

    T = (m_1/3 + m_2) q_1^2/2 + 2 m_2 q_2^2/3 + m_2 c q_1 q_2                                        (2.66, 2.93)
    v_C = (-q_1 cos theta_1 - 2 q_2 cos theta_2, q_1 sin theta_1 + 2 q_2 sin theta_2)                (2.68, 2.95)

An impulse (dp_x, dp_y) on C changes the generalized momenta by (2.69)

    dT_1 = -cos theta_1 dp_x + sin theta_1 dp_y,    dT_2 = -2 cos theta_2 dp_x + 2 sin theta_2 dp_y.

Friction makes dp_x = -mu sign(v_x) dp_y while C slips, so q is linear in p_y (2.74, 2.80, 2.98).
Slip may stop before or after the end of compression; then C sticks, or slips the other way if mu <
mu_bar (2.90). The impact ends when the normal work of restitution is W_r = -e*^2 W_c (2.87). This
module follows the rods in q. ``impact.energetic_impact`` solves the same impact in the velocities
of C; each is a test of the other.

Rates are negative where they bring the tip of a rod of positive inclination to the surface.
ValueError is raised for an argument out of its range. Source beside Zhang: W. J. Stronge, Proc. R.
Soc. Lond. A 431 (1990) 169-181.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array, Number
from bristle_sim.theory.monofilament import LEAST_ANGLE
from bristle_sim.theory.numbers import RANGES, checked_numbers, require

_ROUNDING = 1e-12  # fraction of the rods' initial speeds below which a component of the tip's velocity counts as zero

# Largest difference of the angles of parallel rods, rad; their tip moves along one line.
_PARALLEL = 1e-8


@dataclass(frozen=True, slots=True)
class SinglePendulumImpact:
    """Impact of a single pendulum.

    Attributes:
        normal_compressive_impulse: p_c, N s.
        normal_final_impulse: p_f, N s.
        final_rate: rate after the impact, rad/s.
        rebound_ratio: rate after over rate before the impact.
        outcome: outcome in words.
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
    """Return the impact of Stronge's single pendulum (Zhang 2020, sec. 2.4.1 and fig. 2.26).

        phi'_f/phi'(0) = -e* sqrt((1 - mu cot gamma)/(1 + mu cot gamma)),    no rebound for mu >= tan gamma

    Mass in kg, length in m, 0 < gamma <= pi/2 in rad; the rate, rad/s, is negative where the tip
    approaches the surface.

    At gamma = 45 deg and mu = 0.6 the ratio is -e* sqrt(0.4/1.6) = -e*/2:

    >>> impact = single_pendulum_impact(1.0, 1.0, math.pi / 4.0, -2.0, 0.6, 0.5)
    >>> print(f"{impact.rebound_ratio:.6f} {impact.final_rate:.6f} {impact.outcome}")
    -0.250000 0.500000 rebound
    """
    mass, length = checked_numbers(rod_mass=rod_mass, rod_length=rod_length)
    angle, rate = checked_numbers(impact_angle=impact_angle, rate=rate)
    mu, e = checked_numbers(friction=friction, restitution=restitution)
    require(
        "impact_angle", angle, angle >= LEAST_ANGLE, f"must be at least {LEAST_ANGLE:g} (in rad)"
    )
    if rate >= 0.0:
        return SinglePendulumImpact(0.0, 0.0, rate, 1.0, "no contact")
    compressing = math.sin(angle) + mu * math.cos(angle)
    releasing = math.sin(angle) - mu * math.cos(angle)
    compressive = -mass * length * rate / (3.0 * compressing)
    if releasing <= 0.0 or e == 0.0:
        return SinglePendulumImpact(
            compressive, compressive, 0.0, 0.0, "stiction" if e > 0.0 else "no rebound"
        )
    ratio = -e * math.sqrt(releasing / compressing)
    final = compressive + mass * length * ratio * rate / (3.0 * releasing)
    return SinglePendulumImpact(compressive, final, ratio * rate, ratio, "rebound")


@dataclass(frozen=True, slots=True)
class DoublePendulumImpact:
    """Impact of a double pendulum.

    Attributes:
        final_rate_1, final_rate_2: rates of the rods after the impact, rad/s.
        normal_compressive_impulse: p_c, N s.
        normal_final_impulse: p_f, N s.
        slip_stop_impulse: p_s, normal impulse at which slip stops, N s; inf if slip does not stop.
        phases: motions of the tip C, in order.
        kinetic_energy_ratio: kinetic energy after over before the impact.
        outcome: outcome in words.
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
    """Return the impact of Stronge's double pendulum of any mass ratio (Zhang 2020, eqs.
    2.66-2.108).

    m_2 in kg, n = m_1/m_2, L of either rod in m, theta_1 and theta_2 within a right angle in rad,
    phi'_1 and phi'_2 before the impact in rad/s. The friction in restitution equals that in
    compression by default, as in the dissertation.

    A frictionless impact keeps the kinetic energy if e* = 1:

    >>> impact = double_pendulum_impact(5.0, 1.0, 1.0, 0.35, 0.52, -0.1, -0.2, 0.0, 1.0)
    >>> print(f"{impact.kinetic_energy_ratio:.9f} {impact.outcome}")
    1.000000000 rebound
    """
    mass, ratio, *angles = checked_numbers(
        rod_mass=rod_mass, mass_ratio=mass_ratio, angle_1=angle_1, angle_2=angle_2
    )
    length, mu, e = checked_numbers(
        rod_length=rod_length, friction=friction, restitution=restitution
    )
    later = (
        mu
        if restitution_friction is None
        else RANGES["restitution_friction"].check(restitution_friction)
    )
    first, second = checked_numbers(rate_1=rate_1, rate_2=rate_2)
    speeds = np.array([length * first, length * second / 2.0])
    rods = _Rods(mass, ratio, angles)
    impact = _RodImpact(rods, speeds)
    outcome = impact.resolve(mu, e, later)
    before, after = rods.kinetic_energy(speeds), rods.kinetic_energy(impact.speeds)
    return DoublePendulumImpact(
        final_rate_1=float(impact.speeds[0]) / length,
        final_rate_2=2.0 * float(impact.speeds[1]) / length,
        normal_compressive_impulse=impact.compressive_impulse,
        normal_final_impulse=impact.impulse,
        slip_stop_impulse=impact.slip_stop,
        phases=tuple(impact.phases),
        kinetic_energy_ratio=after / before if before > 0.0 else 1.0,
        outcome=outcome,
    )


def stick_friction(mass_ratio: ArrayLike, angle_1: ArrayLike, angle_2: ArrayLike) -> Number:
    """Return mu_bar, the least friction at which C sticks after its slip has stopped.

    For n = 1 it is eq. 2.90 of Zhang (2020):

        mu_bar = |sin 2 theta_1 + (n + 3) sin 2 theta_2 - 3 c sin(theta_1 + theta_2)|
                 / (2 cos^2 theta_1 + 2 (n + 3) cos^2 theta_2 - 6 c cos theta_1 cos theta_2)

    Angles in rad, arrays broadcast. For theta_1 = theta_2 it is tan theta whatever n (2.111).

    The dissertation's identical rods at 20 and 30 deg:

    >>> print(f"{stick_friction(1.0, math.radians(20.0), math.radians(30.0)):.6f}")
    0.623401
    """
    first, second = np.asarray(angle_1, dtype=float), np.asarray(angle_2, dtype=float)
    heavy = np.add(mass_ratio, 3.0)
    c = np.cos(first - second)
    driven = np.sin(2.0 * first) + heavy * np.sin(2.0 * second) - 3.0 * c * np.sin(first + second)
    resisted = (
        np.cos(first) ** 2 + heavy * np.cos(second) ** 2 - 3.0 * c * np.cos(first) * np.cos(second)
    )
    return np.abs(driven) / (2.0 * resisted)


class _Rods:
    """The rods at their angles.

    They determine the effect of speeds q = (q_1, q_2), m/s, and of impulses on C; a normal impulse
    changes q by dq/dp_y.
    """

    def __init__(self, mass: float, ratio: float, angles: Sequence[float]) -> None:
        self.mass = mass
        self.ratio = ratio
        self.angles = angles
        (self.cos_1, self.cos_2), (self.sin_1, self.sin_2) = (
            map(math.cos, angles),
            map(math.sin, angles),
        )
        between = angles[0] - angles[1]
        self.c = math.cos(between)
        self.sine = math.sin(between)
        # The tip C of parallel rods moves along one line, so it cannot lift off while it sticks.
        self.parallel = abs(between) < _PARALLEL

    def kinetic_energy(self, q: Array) -> float:
        """Return T (2.93), J."""
        own = (self.ratio / 6.0 + 0.5) * q[0] ** 2 + 2.0 / 3.0 * q[1] ** 2
        return self.mass * float(own + self.c * q[0] * q[1])

    def tip_velocity(self, q: Array) -> tuple[float, float]:
        """Return v_C (2.95), m/s."""
        along = -q[0] * self.cos_1 - 2.0 * q[1] * self.cos_2
        return float(along), float(q[0] * self.sin_1 + 2.0 * q[1] * self.sin_2)

    def response(self, along: float, away: float) -> Array:
        """Return the change of q by an impulse on C (eqs. 2.94 and 2.96, solved for it)."""
        first = -along * self.cos_1 + away * self.sin_1
        second = -2.0 * along * self.cos_2 + 2.0 * away * self.sin_2
        own = self.ratio / 3.0 + 1.0
        solved = np.array([4.0 / 3.0 * first - self.c * second, own * second - self.c * first])
        return solved / (self.mass * (4.0 / 3.0 * own - self.c * self.c))

    def sticking(self) -> Array:
        """Return dq/dp_y while C sticks.

        One degree of freedom is left, with q proportional to (2 cos theta_2, -cos theta_1).
        """
        freedom = np.array([2.0 * self.cos_2, -self.cos_1])
        lift = 0.0 if self.parallel else 2.0 * self.sine
        return freedom * lift / (2.0 * self.kinetic_energy(freedom))

    def sliding_at_rest(self) -> Array:
        """Return dq/dp_y while C slips with v_y = 0, under the friction that keeps v_y at 0.

        One degree of freedom is left.
        """
        friction = (
            self.tip_velocity(self.response(0.0, 1.0))[1]
            / self.tip_velocity(self.response(1.0, 0.0))[1]
        )
        freedom = np.array([2.0 * self.sin_2, -self.sin_1])
        return -friction * freedom * (2.0 * self.sine) / (2.0 * self.kinetic_energy(freedom))


class _RodImpact:
    """The present state of the rods' impact: speeds q, normal impulse and normal work."""

    def __init__(self, rods: _Rods, speeds: Array) -> None:
        self.rods = rods
        self.speeds = speeds
        self.impulse = 0.0
        self.compressive_impulse = 0.0
        self.work = 0.0
        self.phases: list[str] = []
        across = 2.0 * _PARALLEL if rods.parallel else 0.0
        self._least = (_ROUNDING + across) * float(np.abs(speeds).sum())
        self.first_slip = math.copysign(1.0, self.tip[0]) if self.tip[0] else 0.0
        self.slip_stop = math.inf if self.first_slip else 0.0

    @property
    def tip(self) -> list[float]:
        """Velocity of C, with components of the size of rounding set to zero."""
        return [
            each if abs(each) > self._least else 0.0 for each in self.rods.tip_velocity(self.speeds)
        ]

    def until_zero(self, axis: int, change: Array) -> float:
        """Return the normal impulse from now on to the end of slip (axis 0) or compression (axis
        1).

        (Eqs. 2.75, 2.76, 2.99, 2.100.)
        """
        value = self.tip[axis]
        slope = self.rods.tip_velocity(change)[axis]
        return -value / slope if min(value, slope) < 0.0 < max(value, slope) else math.inf

    def until_work(self, change: Array, work: float) -> float:
        """Return the normal impulse from now on that does a given work, the root of v_y p + v_y'
        p^2/2 = W (2.83).
        """
        speed = self.tip[1]
        gain = self.rods.tip_velocity(change)[1]
        if gain <= 0.0:
            return math.inf
        final = math.sqrt(max(speed**2 + 2.0 * gain * work, 0.0))
        return 2.0 * work / (speed + final) if final > 0.0 else 0.0

    def follow(self, part: str, mu: float, work: float | None = None) -> bool:
        """Slip until slip or this part of the impact ends, then stick or slip until the part ends.

        The part is compression, which ends where C rests, or restitution, which ends with the
        normal work that remains (2.87).

        Returns:
            Whether the part ends.
        """
        for slips in (True, False) if self.tip[0] else (False,):
            driven = (
                self.tip[0] if slips else self.rods.tip_velocity(self.rods.response(0.0, 1.0))[0]
            )
            direction = math.copysign(1.0, driven)
            motion = "stick"
            if slips or mu < stick_friction(self.rods.ratio, *self.rods.angles):
                self.first_slip = self.first_slip or direction
                motion = "slip" if direction == self.first_slip else "reverse slip"
            change = (
                self.rods.sticking()
                if motion == "stick"
                else self.rods.response(-mu * direction, 1.0)
            )
            if slips and work is not None and self.rods.tip_velocity(change)[1] <= 0.0:
                # Friction larger than in compression would drive C back as soon as C leaves.
                change = self.rods.sliding_at_rest()
            end = self.until_zero(1, change) if work is None else self.until_work(change, work)
            stop = self.until_zero(0, change) if slips else math.inf
            if math.isinf(step := min(stop, end)):
                return False
            done = (self.tip[1] + 0.5 * self.rods.tip_velocity(change)[1] * step) * step
            self.speeds = self.speeds + change * step
            self.work = self.work + done
            self.impulse = self.impulse + step
            self.phases.append(f"{part} {motion}")
            if math.isinf(self.slip_stop) and not self.tip[0]:
                self.slip_stop = self.impulse
            if end <= stop or (work is None and not self.tip[1] < 0.0):
                return True
            work = None if work is None else work - done
        return False

    def resolve(self, mu: float, restitution: float, later: float) -> str:
        """Compress, restitute, and return the outcome."""
        if not self.tip[1] < 0.0:
            return "no contact"
        if not self.follow("compression", mu):
            return "jam"
        self.compressive_impulse = self.impulse
        if restitution == 0.0:
            return "no rebound"
        return (
            "rebound"
            if self.follow("restitution", later, -(restitution**2) * self.work)
            else "stiction"
        )
