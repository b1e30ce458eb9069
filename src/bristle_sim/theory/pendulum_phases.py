"""Phases of a double pendulum's impact, followed in generalized speeds (Zhang 2020, eqs. 2.66-2.100).

Within a phase the speeds q = (L phi'_1, L phi'_2/2) are linear in the normal impulse; ``pendulums`` says which rods these are
and holds the functions to call.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array, Number
from bristle_sim.theory.checks import checked_arguments

Speeds = Array
"""Generalized speeds (q_1, q_2), m/s."""

_ROUNDING = 1e-12
"""Fraction of the rods' initial speeds below which a component of the tip's velocity counts as zero."""

_PARALLEL = 1e-8
"""Rods whose angles differ by less (rad) count as parallel: their tip moves along one line, up to rounding."""


@checked_arguments
def stick_friction(mass_ratio: ArrayLike, angle_1: ArrayLike, angle_2: ArrayLike) -> Number:
    """Return the least friction with which C, once its slip has stopped, sticks: mu_bar (Zhang 2020, eq. 2.90, n = 1).

        mu_bar = |sin 2 theta_1 + (n + 3) sin 2 theta_2 - 3 c sin(theta_1 + theta_2)|
                 / (2 cos^2 theta_1 + 2 (n + 3) cos^2 theta_2 - 6 c cos theta_1 cos theta_2)

    Angles in rad, arrays broadcast. For theta_1 = theta_2 it is tan theta whatever n (2.111).
    """
    first, second = np.asarray(angle_1, dtype=float), np.asarray(angle_2, dtype=float)
    heavy, c = np.add(mass_ratio, 3.0), np.cos(first - second)
    driven = np.sin(2.0 * first) + heavy * np.sin(2.0 * second) - 3.0 * c * np.sin(first + second)
    resisted = np.cos(first) ** 2 + heavy * np.cos(second) ** 2 - 3.0 * c * np.cos(first) * np.cos(second)
    return np.abs(driven) / (2.0 * resisted)


@dataclass(frozen=True, slots=True)
class Rods:
    """Inertia and geometry of a double pendulum: mass of the second rod, kg, ratio of the masses, angles, rad."""

    mass: float
    ratio: float
    angle_1: float
    angle_2: float

    @property
    def parallel(self) -> bool:
        """Tell whether C moves along one line, so that it cannot lift off while it sticks."""
        return abs(self.angle_1 - self.angle_2) < _PARALLEL

    def kinetic_energy(self, q: Speeds) -> float:
        """Return T (2.93), J."""
        coupled = math.cos(self.angle_1 - self.angle_2) * q[0] * q[1]
        own = (self.ratio / 6.0 + 0.5) * q[0] ** 2 + 2.0 / 3.0 * q[1] ** 2
        return self.mass * float(own + coupled)

    def tip_velocity(self, q: Speeds) -> tuple[float, float]:
        """Return v_C (2.95), m/s."""
        along = -q[0] * math.cos(self.angle_1) - 2.0 * q[1] * math.cos(self.angle_2)
        away = q[0] * math.sin(self.angle_1) + 2.0 * q[1] * math.sin(self.angle_2)
        return float(along), float(away)

    def response(self, along: float, away: float) -> Speeds:
        """Return the change of q by an impulse on C: eqs. 2.94 and 2.96 solved for it."""
        first = -along * math.cos(self.angle_1) + away * math.sin(self.angle_1)
        second = -2.0 * along * math.cos(self.angle_2) + 2.0 * away * math.sin(self.angle_2)
        c, own = math.cos(self.angle_1 - self.angle_2), self.ratio / 3.0 + 1.0
        solved = np.array([4.0 / 3.0 * first - c * second, own * second - c * first])
        return solved / (self.mass * (4.0 / 3.0 * own - c * c))

    def slipping(self, direction: float, mu: float) -> Speeds:
        """Return dq/dp_y while C slips (2.74, 2.80, 2.98)."""
        return self.response(-mu * direction, 1.0)

    def sticking(self) -> Speeds:
        """Return dq/dp_y while C sticks: one freedom is left, q proportional to (2 cos theta_2, -cos theta_1)."""
        freedom = np.array([2.0 * math.cos(self.angle_2), -math.cos(self.angle_1)])
        lift = 0.0 if self.parallel else 2.0 * math.sin(self.angle_1 - self.angle_2)
        return freedom * lift / (2.0 * self.kinetic_energy(freedom))

    def sliding_at_rest(self) -> Speeds:
        """Return dq/dp_y while C slips with v_y = 0, under the friction that keeps it there: again one freedom."""
        friction = self.tip_velocity(self.response(0.0, 1.0))[1] / self.tip_velocity(self.response(1.0, 0.0))[1]
        freedom = np.array([2.0 * math.sin(self.angle_2), -math.sin(self.angle_1)])
        drift = 2.0 * math.sin(self.angle_1 - self.angle_2)
        return -friction * freedom * drift / (2.0 * self.kinetic_energy(freedom))


class RodImpact:
    """The rods during an impact: speeds, normal impulse and normal work so far."""

    def __init__(self, rods: Rods, speeds: Speeds) -> None:
        self.rods, self.speeds = rods, speeds
        self.impulse, self.compressive_impulse, self.work = 0.0, 0.0, 0.0
        self.phases: list[str] = []
        across = 2.0 * _PARALLEL if rods.parallel else 0.0
        self._least = (_ROUNDING + across) * float(np.abs(speeds).sum())
        self.first_slip = self.slip
        self.slip_stop = math.inf if self.first_slip else 0.0

    @property
    def tip(self) -> tuple[float, float]:
        """Return v_C without its rounding."""
        along, away = self.rods.tip_velocity(self.speeds)
        return along if abs(along) > self._least else 0.0, away if abs(away) > self._least else 0.0

    @property
    def slip(self) -> float:
        """Return the direction in which C slips; 0 if it does not."""
        along, _ = self.tip
        return math.copysign(1.0, along) if along else 0.0

    def slipping(self, direction: float, mu: float) -> tuple[str, Speeds]:
        """Return what a slip is called, beside the first one of the impact, and dq/dp_y."""
        self.first_slip = self.first_slip or direction
        return "slip" if direction == self.first_slip else "reverse slip", self.rods.slipping(direction, mu)

    def after_slip(self, mu: float) -> tuple[str, Speeds]:
        """Return what C does once slip has stopped, stick or slip as the normal impulse drives it, and dq/dp_y."""
        if mu >= stick_friction(self.rods.ratio, self.rods.angle_1, self.rods.angle_2):
            return "stick", self.rods.sticking()
        driven, _ = self.rods.tip_velocity(self.rods.response(0.0, 1.0))
        return self.slipping(math.copysign(1.0, driven), mu)

    def impulse_to_stop(self, change: Speeds) -> float:
        """Return the further normal impulse at which slip stops (2.75, 2.99)."""
        return _zero(self.tip[0], self.rods.tip_velocity(change)[0])

    def impulse_to_rest(self, change: Speeds) -> float:
        """Return the further normal impulse at which compression ends (2.76, 2.100)."""
        return _zero(self.tip[1], self.rods.tip_velocity(change)[1])

    def impulse_to_work(self, change: Speeds, work: float) -> float:
        """Return the further normal impulse that does the work, the root of v_y p + v_y' p^2/2 = W (2.83)."""
        speed, gain = self.tip[1], self.rods.tip_velocity(change)[1]
        if gain <= 0.0:
            return math.inf
        final = math.sqrt(max(speed**2 + 2.0 * gain * work, 0.0))
        return 2.0 * work / (speed + final) if final > 0.0 else 0.0

    def follow(self, phase: str, change: Speeds, impulse: float) -> float:
        """Apply the normal impulse, with q changing at the rate ``change``, and return its normal work."""
        work = (self.tip[1] + 0.5 * self.rods.tip_velocity(change)[1] * impulse) * impulse
        self.speeds = self.speeds + change * impulse
        self.work += work
        self.impulse += impulse
        self.phases.append(phase)
        if math.isinf(self.slip_stop) and not self.slip:
            self.slip_stop = self.impulse
        return work


def compress(impact: RodImpact, mu: float) -> bool:
    """Slip until C rests or slip stops; if slip stops first, stick or slip on until C rests; return whether it can."""
    if impact.slip:
        motion, change = impact.slipping(impact.slip, mu)
        end = min(impact.impulse_to_stop(change), impact.impulse_to_rest(change))
        impact.follow(f"compression {motion}", change, end)
    if impact.tip[1] < 0.0:
        motion, change = impact.after_slip(mu)
        end = impact.impulse_to_rest(change)
        if math.isinf(end):
            return False
        impact.follow(f"compression {motion}", change, end)
    impact.compressive_impulse = impact.impulse
    return True


def restitute(impact: RodImpact, mu: float, restitution: float) -> str:
    """Continue until the work of restitution is -e*^2 that of compression (2.87), and return the outcome."""
    if restitution == 0.0:
        return "no rebound"
    wanted = -(restitution**2) * impact.work
    if impact.slip:
        motion, change = impact.slipping(impact.slip, mu)
        if impact.rods.tip_velocity(change)[1] <= 0.0:
            # More friction than in compression: it would drive C back as soon as C leaves.
            change = impact.rods.sliding_at_rest()
        stop, end = impact.impulse_to_stop(change), impact.impulse_to_work(change, wanted)
        wanted -= impact.follow(f"restitution {motion}", change, min(stop, end))
        if end <= stop:
            return "rebound"
    motion, change = impact.after_slip(mu)
    end = impact.impulse_to_work(change, wanted)
    if math.isinf(end):
        return "stiction"
    impact.follow(f"restitution {motion}", change, end)
    return "rebound"


def _zero(value: float, slope: float) -> float:
    """Return where a linear function that starts at the value vanishes; inf if it does not."""
    return -value / slope if min(value, slope) < 0.0 < max(value, slope) else math.inf
