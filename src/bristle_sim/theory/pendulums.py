"""Stronge's single and double pendulum against a rough surface, in generalized speeds (Zhang 2020, sec. 2.4).

Single (2.4.1): a slender rod of mass m and length L hinged at O, inclined at gamma to the normal of the surface that its
tip strikes; the monofilament with r_h = 0.

Double (2.4.2): slender rods OB of mass m_1 = n m_2 and BC of mass m_2, both of length L, hinged at O and B, inclined at
theta_1 and theta_2 to the normal of the surface that C strikes. In the generalized speeds q_1 = L phi'_1 and
q_2 = L phi'_2/2, with c = cos(theta_1 - theta_2),

    T = (m_1/3 + m_2) q_1^2/2 + 2 m_2 q_2^2/3 + m_2 c q_1 q_2                                        (2.66, 2.93)
    v_C = (-q_1 cos theta_1 - 2 q_2 cos theta_2, q_1 sin theta_1 + 2 q_2 sin theta_2)                (2.68, 2.95)

An impulse (dp_x, dp_y) on C changes the generalized momenta by (2.69)

    dT_1 = -cos theta_1 dp_x + sin theta_1 dp_y,    dT_2 = -2 cos theta_2 dp_x + 2 sin theta_2 dp_y.

Friction makes dp_x = -mu sign(v_x) dp_y while C slips, so q is linear in p_y (2.74, 2.80, 2.98). Slip may stop before or
after the end of compression; then C sticks, or slips the other way if mu < mu_bar (2.90). The impact ends when the normal
work of restitution is W_r = -e*^2 W_c (2.87). The rods here are followed in q; ``impact.energetic_impact`` solves the
same impact in the velocities of C, and each is the other's test.

Rates are negative where they bring the tip of a rod of positive inclination to the surface. Source beside Zhang: W. J. Stronge, *Rigid body collisions
with friction*, Proc. R. Soc. Lond. A 431 (1990) 169-181.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bristle_sim.quantity import Range
from bristle_sim.theory.checks import ranges

__all__ = [
    "DoublePendulumImpact",
    "SinglePendulumImpact",
    "double_pendulum_impact",
    "single_pendulum_impact",
    "stick_friction",
]

Number = Any
"""A float, or an array of the arguments' broadcast shape."""

Speeds = NDArray[np.float64]
"""Generalized speeds (q_1, q_2), m/s."""

_RIGHT = math.pi / 2.0
_MASS = Range("rod_mass", "kg", 1e-30, 1e6, lowest_allowed=True, source="Zhang 2020, fig. 2.27")
_RATIO = Range("mass_ratio", "1", 0.0, 1e12, lowest_allowed=False, source="Zhang 2020, below eq. 2.98: n")
_LENGTH = Range("rod_length", "m", 1e-9, 1e3, lowest_allowed=True, source="Zhang 2020, fig. 2.27")
_IMPACT_ANGLE = Range("impact_angle", "rad", 0.0, _RIGHT, lowest_allowed=False, source="Zhang 2020, fig. 2.25")
_ANGLE_1 = Range("angle_1", "rad", -_RIGHT, _RIGHT, lowest_allowed=True, source="Zhang 2020, fig. 2.27")
_ANGLE_2 = Range("angle_2", "rad", -_RIGHT, _RIGHT, lowest_allowed=True, source="Zhang 2020, fig. 2.27")
_RATE = Range("rate", "rad/s", -1e9, 1e9, lowest_allowed=True, source="Zhang 2020, fig. 2.25")
_RATE_1 = Range("rate_1", "rad/s", -1e9, 1e9, lowest_allowed=True, source="Zhang 2020, fig. 2.29")
_RATE_2 = Range("rate_2", "rad/s", -1e9, 1e9, lowest_allowed=True, source="Zhang 2020, fig. 2.28")
_FRICTION = Range("friction", "1", 0.0, 1e9, lowest_allowed=True, source="Zhang 2020, eq. 2.70")
_LATER_FRICTION = Range("restitution_friction", "1", 0.0, 1e9, lowest_allowed=True, source="Zhang 2020, eq. 2.70")
_RESTITUTION = Range("restitution", "1", 0.0, 1.0, lowest_allowed=True, source="Zhang 2020, eq. 2.87")

_ROUNDING = 1e-12
"""Share of the rods' initial speeds below which a component of the tip's velocity counts as zero."""

_PARALLEL = 1e-8
"""Rods whose angles differ by less (rad) count as parallel: their tip moves along one line, up to rounding."""


@dataclass(frozen=True, slots=True)
class SinglePendulumImpact:
    """Impact of a single pendulum: impulses p_c and p_f in N s, rate after the impact in rad/s."""

    normal_compressive_impulse: float
    normal_final_impulse: float
    final_rate: float
    rebound_ratio: float
    outcome: str


def single_pendulum_impact(
    rod_mass: float, rod_length: float, impact_angle: float, rate: float, friction: float, restitution: float
) -> SinglePendulumImpact:
    """Stronge's single pendulum (Zhang 2020, sec. 2.4.1 and fig. 2.26).

        phi'_f/phi'(0) = -e* sqrt((1 - mu cot gamma)/(1 + mu cot gamma)),    no rebound for mu >= tan gamma

    The rate, in rad/s, is negative where the tip (kg, m, 0 < gamma <= pi/2 rad) approaches the surface.

    Raises:
        ValueError: for an argument outside its range.
    """
    mass, length, angle = _MASS.check(rod_mass), _LENGTH.check(rod_length), _IMPACT_ANGLE.check(impact_angle)
    rate, mu, e = _RATE.check(rate), _FRICTION.check(friction), _RESTITUTION.check(restitution)
    if rate >= 0.0:
        return SinglePendulumImpact(0.0, 0.0, rate, 1.0, "no contact")
    # Generalized impulses of a unit normal impulse, over L; the tip's inertia is m/3.
    compressing = math.sin(angle) + mu * math.cos(angle)
    releasing = math.sin(angle) - mu * math.cos(angle)
    compressive = -mass * length * rate / (3.0 * compressing)
    if releasing <= 0.0 or e == 0.0:
        outcome = "stiction" if e > 0.0 else "no rebound"
        return SinglePendulumImpact(compressive, compressive, 0.0, 0.0, outcome)
    ratio = -e * math.sqrt(releasing / compressing)
    final = compressive + mass * length * ratio * rate / (3.0 * releasing)
    return SinglePendulumImpact(compressive, final, ratio * rate, ratio, "rebound")


@dataclass(frozen=True, slots=True)
class DoublePendulumImpact:
    """Impact of a double pendulum.

    Attributes:
        final_rate_1, final_rate_2: phi'_1, phi'_2 after the impact, rad/s.
        normal_compressive_impulse, normal_final_impulse: p_c and p_f, N s.
        slip_stop_impulse: p_s, the normal impulse at which the initial slip stops, N s; inf if it lasts.
        phases: what C does, in order, e.g. ``("compression slip", "restitution slip", "restitution stick")``.
        kinetic_energy_ratio: kinetic energy after the impact over that before it.
        outcome: a word of ``impact.OUTCOMES``.
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
    """Stronge's double pendulum with any ratio of masses (Zhang 2020, eqs. 2.66-2.108).

    Args:
        rod_mass, mass_ratio: m_2 in kg and n = m_1/m_2; identical rods have n = 1.
        rod_length: L of either rod, m.
        angle_1, angle_2: theta_1, theta_2, within a right angle, rad.
        rate_1, rate_2: phi'_1, phi'_2 before the impact, rad/s.
        friction, restitution: mu and e*.
        restitution_friction: mu in restitution, equal to friction by default as in the dissertation.

    Raises:
        ValueError: for an argument outside its range.
    """
    rods = _Rods(_MASS.check(rod_mass), _RATIO.check(mass_ratio), _ANGLE_1.check(angle_1), _ANGLE_2.check(angle_2))
    length, mu, e = _LENGTH.check(rod_length), _FRICTION.check(friction), _RESTITUTION.check(restitution)
    later = mu if restitution_friction is None else _LATER_FRICTION.check(restitution_friction)
    speeds = np.array([length * _RATE_1.check(rate_1), length * _RATE_2.check(rate_2) / 2.0])
    course = _Course(rods, speeds)
    outcome = "no contact"
    if course.tip[1] < 0.0:
        outcome = _restitute(course, later, e) if _compress(course, mu) else "jam"
    before, after = rods.kinetic_energy(speeds), rods.kinetic_energy(course.speeds)
    return DoublePendulumImpact(
        final_rate_1=float(course.speeds[0]) / length,
        final_rate_2=2.0 * float(course.speeds[1]) / length,
        normal_compressive_impulse=course.compressive_impulse,
        normal_final_impulse=course.impulse,
        slip_stop_impulse=course.slip_stop,
        phases=tuple(course.phases),
        kinetic_energy_ratio=after / before if before > 0.0 else 1.0,
        outcome=outcome,
    )


@ranges(_RATIO, _ANGLE_1, _ANGLE_2)
def stick_friction(mass_ratio: ArrayLike, angle_1: ArrayLike, angle_2: ArrayLike) -> Number:
    """Least friction with which C, once its slip has stopped, sticks: mu_bar (Zhang 2020, eq. 2.90, there for n = 1).

        mu_bar = |sin 2 theta_1 + (n + 3) sin 2 theta_2 - 3 c sin(theta_1 + theta_2)|
                 / (2 cos^2 theta_1 + 2 (n + 3) cos^2 theta_2 - 6 c cos theta_1 cos theta_2)

    Angles in rad, arrays broadcast. For theta_1 = theta_2 it is tan theta whatever n (2.111).
    """
    first, second = np.asarray(angle_1, dtype=float), np.asarray(angle_2, dtype=float)
    heavy, c = np.add(mass_ratio, 3.0), np.cos(first - second)
    driven = np.sin(2.0 * first) + heavy * np.sin(2.0 * second) - 3.0 * c * np.sin(first + second)
    held = np.cos(first) ** 2 + heavy * np.cos(second) ** 2 - 3.0 * c * np.cos(first) * np.cos(second)
    return np.abs(driven) / (2.0 * held)


@dataclass(frozen=True, slots=True)
class _Rods:
    """Inertia and geometry of the double pendulum."""

    mass: float
    ratio: float
    angle_1: float
    angle_2: float

    @property
    def parallel(self) -> bool:
        """Whether C moves along one line, so that it cannot lift off while it sticks."""
        return abs(self.angle_1 - self.angle_2) < _PARALLEL

    def kinetic_energy(self, q: Speeds) -> float:
        """T (2.93), J."""
        coupled = math.cos(self.angle_1 - self.angle_2) * q[0] * q[1]
        own = (self.ratio / 6.0 + 0.5) * q[0] ** 2 + 2.0 / 3.0 * q[1] ** 2
        return self.mass * float(own + coupled)

    def tip_velocity(self, q: Speeds) -> tuple[float, float]:
        """v_C (2.95), m/s."""
        along = -q[0] * math.cos(self.angle_1) - 2.0 * q[1] * math.cos(self.angle_2)
        away = q[0] * math.sin(self.angle_1) + 2.0 * q[1] * math.sin(self.angle_2)
        return float(along), float(away)

    def response(self, along: float, away: float) -> Speeds:
        """Change of q by an impulse on C: eqs. 2.94 and 2.96 solved for it."""
        first = -along * math.cos(self.angle_1) + away * math.sin(self.angle_1)
        second = -2.0 * along * math.cos(self.angle_2) + 2.0 * away * math.sin(self.angle_2)
        c, own = math.cos(self.angle_1 - self.angle_2), self.ratio / 3.0 + 1.0
        solved = np.array([4.0 / 3.0 * first - c * second, own * second - c * first])
        return solved / (self.mass * (4.0 / 3.0 * own - c * c))

    def slipping(self, direction: float, mu: float) -> Speeds:
        """dq/dp_y while C slips (2.74, 2.80, 2.98)."""
        return self.response(-mu * direction, 1.0)

    def sticking(self) -> Speeds:
        """dq/dp_y while C sticks: one freedom is left, q proportional to (2 cos theta_2, -cos theta_1)."""
        freedom = np.array([2.0 * math.cos(self.angle_2), -math.cos(self.angle_1)])
        lift = 0.0 if self.parallel else 2.0 * math.sin(self.angle_1 - self.angle_2)
        return freedom * lift / (2.0 * self.kinetic_energy(freedom))

    def sliding_at_rest(self) -> Speeds:
        """dq/dp_y while C slips with v_y = 0, by as much friction as keeps it there: again one freedom."""
        friction = self.tip_velocity(self.response(0.0, 1.0))[1] / self.tip_velocity(self.response(1.0, 0.0))[1]
        freedom = np.array([2.0 * math.sin(self.angle_2), -math.sin(self.angle_1)])
        drift = 2.0 * math.sin(self.angle_1 - self.angle_2)
        return -friction * freedom * drift / (2.0 * self.kinetic_energy(freedom))


class _Course:
    """The rods in the course of an impact: speeds, normal impulse and normal work so far."""

    def __init__(self, rods: _Rods, speeds: Speeds) -> None:
        self.rods, self.speeds = rods, speeds
        self.impulse, self.compressive_impulse, self.work = 0.0, 0.0, 0.0
        self.phases: list[str] = []
        across = 2.0 * _PARALLEL if rods.parallel else 0.0
        self._least = (_ROUNDING + across) * float(np.abs(speeds).sum())
        self.first_slip = self.slip
        self.slip_stop = math.inf if self.first_slip else 0.0

    @property
    def tip(self) -> tuple[float, float]:
        """v_C, rid of rounding."""
        along, away = self.rods.tip_velocity(self.speeds)
        return along if abs(along) > self._least else 0.0, away if abs(away) > self._least else 0.0

    @property
    def slip(self) -> float:
        """Direction in which C slips; 0 if it does not."""
        along, _ = self.tip
        return math.copysign(1.0, along) if along else 0.0

    def slipping(self, direction: float, mu: float) -> tuple[str, Speeds]:
        """Name of a slip, after the first one of the impact, and dq/dp_y."""
        self.first_slip = self.first_slip or direction
        return "slip" if direction == self.first_slip else "reverse slip", self.rods.slipping(direction, mu)

    def after_slip(self, mu: float) -> tuple[str, Speeds]:
        """What C does once slip has stopped, stick or slip as the normal impulse drives it, and dq/dp_y."""
        if mu >= stick_friction(self.rods.ratio, self.rods.angle_1, self.rods.angle_2):
            return "stick", self.rods.sticking()
        driven, _ = self.rods.tip_velocity(self.rods.response(0.0, 1.0))
        return self.slipping(math.copysign(1.0, driven), mu)

    def impulse_to_stop(self, change: Speeds) -> float:
        """Normal impulse at which slip stops, from here (2.75, 2.99)."""
        return _zero(self.tip[0], self.rods.tip_velocity(change)[0])

    def impulse_to_rest(self, change: Speeds) -> float:
        """Normal impulse at which compression ends, from here (2.76, 2.100)."""
        return _zero(self.tip[1], self.rods.tip_velocity(change)[1])

    def impulse_to_work(self, change: Speeds, work: float) -> float:
        """Normal impulse that does the work, from here: the root of v_y p + v_y' p^2/2 = W (2.83)."""
        speed, gain = self.tip[1], self.rods.tip_velocity(change)[1]
        if gain <= 0.0:
            return math.inf
        final = math.sqrt(max(speed**2 + 2.0 * gain * work, 0.0))
        return 2.0 * work / (speed + final) if final > 0.0 else 0.0

    def follow(self, phase: str, change: Speeds, impulse: float) -> float:
        """Apply the normal impulse, with q changing at the rate ``change``; returns its normal work."""
        work = (self.tip[1] + 0.5 * self.rods.tip_velocity(change)[1] * impulse) * impulse
        self.speeds = self.speeds + change * impulse
        self.work += work
        self.impulse += impulse
        self.phases.append(phase)
        if math.isinf(self.slip_stop) and not self.slip:
            self.slip_stop = self.impulse
        return work


def _compress(course: _Course, mu: float) -> bool:
    """Slip until C rests or slip stops; if slip stops first, stick or slip on until C rests. False if it cannot."""
    if course.slip:
        motion, change = course.slipping(course.slip, mu)
        end = min(course.impulse_to_stop(change), course.impulse_to_rest(change))
        course.follow(f"compression {motion}", change, end)
    if course.tip[1] < 0.0:
        motion, change = course.after_slip(mu)
        end = course.impulse_to_rest(change)
        if math.isinf(end):
            return False
        course.follow(f"compression {motion}", change, end)
    course.compressive_impulse = course.impulse
    return True


def _restitute(course: _Course, mu: float, restitution: float) -> str:
    """Go on until the work of restitution is -e*^2 that of compression (2.87); returns the outcome."""
    if restitution == 0.0:
        return "no rebound"
    wanted = -(restitution**2) * course.work
    if course.slip:
        motion, change = course.slipping(course.slip, mu)
        if course.rods.tip_velocity(change)[1] <= 0.0:
            # More friction than in compression: it would drive C back as soon as C leaves.
            change = course.rods.sliding_at_rest()
        stop, end = course.impulse_to_stop(change), course.impulse_to_work(change, wanted)
        wanted -= course.follow(f"restitution {motion}", change, min(stop, end))
        if end <= stop:
            return "rebound"
    motion, change = course.after_slip(mu)
    end = course.impulse_to_work(change, wanted)
    if math.isinf(end):
        return "stiction"
    course.follow(f"restitution {motion}", change, end)
    return "rebound"


def _zero(value: float, slope: float) -> float:
    """Where a linear function that starts at the value vanishes; inf if it does not."""
    return -value / slope if min(value, slope) < 0.0 < max(value, slope) else math.inf
