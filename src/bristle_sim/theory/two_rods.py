"""Two hinged rods in generalized speeds, and the phases of an impact at their tip.

The symbols and the equation numbers are those of the module ``pendulums`` (Zhang 2020, sec. 2.4.2).
C is the tip of the second rod.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array, Number

# Component of the tip's velocity, as a fraction of the rods' initial speeds, that counts as zero.
ROUNDING = 1e-12

# Largest difference of the angles of rods that count as parallel, rad; their tip moves along one
# line.
PARALLEL = 1e-8


def stick_friction(mass_ratio: ArrayLike, angle_1: ArrayLike, angle_2: ArrayLike) -> Number:
    """Return the least friction at which the tip of a double pendulum sticks once its slip stops.

    With the mass ratio n = m_1/m_2 of the rods, their angles theta_1 and theta_2 to the surface's
    normal (rad) and c = cos(theta_1 - theta_2), it is

        mu_bar = |sin 2 theta_1 + (n + 3) sin 2 theta_2 - 3 c sin(theta_1 + theta_2)|
                 / (2 cos^2 theta_1 + 2 (n + 3) cos^2 theta_2 - 6 c cos theta_1 cos theta_2)

    For n = 1 this is eq. 2.90 of Zhang (2020). Arrays broadcast. For theta_1 = theta_2 = theta it
    is tan theta for every n (2.111).

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


class Rods:
    """The kinetics of two hinged rods of equal length at given angles to the surface's normal.

    The motion is given by the generalized speeds q = (L phi'_1, L phi'_2/2) (m/s) with the length L
    and the rates phi' of the rods. The tip C of the second rod receives impulses. ``mass`` is the
    mass of the second rod, ``ratio`` the mass of the first rod over it.
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
        self.parallel = abs(between) < PARALLEL

    def kinetic_energy(self, q: Array) -> float:
        """Return the kinetic energy of the rods, J (Zhang 2020, eq. 2.93)."""
        own = (self.ratio / 6.0 + 0.5) * q[0] ** 2 + 2.0 / 3.0 * q[1] ** 2
        return self.mass * float(own + self.c * q[0] * q[1])

    def tip_velocity(self, q: Array) -> tuple[float, float]:
        """Return the (tangential, normal) velocity of the tip, m/s (Zhang 2020, eq. 2.95)."""
        along = -q[0] * self.cos_1 - 2.0 * q[1] * self.cos_2
        return float(along), float(q[0] * self.sin_1 + 2.0 * q[1] * self.sin_2)

    def response(self, along: float, away: float) -> Array:
        """Return the change of the generalized speeds by an impulse on the tip, m/s.

        The impulse has the tangential component ``along`` and the normal component ``away``, N s.
        The change solves eqs. 2.94 and 2.96.
        """
        first = -along * self.cos_1 + away * self.sin_1
        second = -2.0 * along * self.cos_2 + 2.0 * away * self.sin_2
        own = self.ratio / 3.0 + 1.0
        solved = np.array([4.0 / 3.0 * first - self.c * second, own * second - self.c * first])
        return solved / (self.mass * (4.0 / 3.0 * own - self.c * self.c))

    def sticking(self) -> Array:
        """Return the change of the generalized speeds per unit normal impulse while the tip sticks.

        One degree of freedom is left: the speeds are proportional to (2 cos theta_2, -cos theta_1).
        """
        freedom = np.array([2.0 * self.cos_2, -self.cos_1])
        lift = 0.0 if self.parallel else 2.0 * self.sine
        return freedom * lift / (2.0 * self.kinetic_energy(freedom))

    def sliding_at_rest(self) -> Array:
        """Return the change of the generalized speeds per unit normal impulse in slip at rest.

        Friction keeps the normal velocity of the tip at 0. One degree of freedom is left.
        """
        friction = (
            self.tip_velocity(self.response(0.0, 1.0))[1]
            / self.tip_velocity(self.response(1.0, 0.0))[1]
        )
        freedom = np.array([2.0 * self.sin_2, -self.sin_1])
        return -friction * freedom * (2.0 * self.sine) / (2.0 * self.kinetic_energy(freedom))


class RodImpact:
    """The present state of an impact of two rods.

    It holds the generalized speeds of the rods (m/s) and the normal impulse (N s) and normal work,
    J, so far.
    """

    def __init__(self, rods: Rods, speeds: Array) -> None:
        self.rods = rods
        self.speeds = speeds
        self.impulse = 0.0
        self.compressive_impulse = 0.0
        self.work = 0.0
        self.phases: list[str] = []
        across = 2.0 * PARALLEL if rods.parallel else 0.0
        self._least = (ROUNDING + across) * float(np.abs(speeds).sum())
        self.first_slip = math.copysign(1.0, self.tip[0]) if self.tip[0] else 0.0
        self.slip_stop = math.inf if self.first_slip else 0.0

    @property
    def tip(self) -> list[float]:
        """Return the (tangential, normal) velocity of the tip, m/s.

        A component no larger than rounding error is set to zero.
        """
        return [
            each if abs(each) > self._least else 0.0 for each in self.rods.tip_velocity(self.speeds)
        ]

    def until_zero(self, axis: int, change: Array) -> float:
        """Return the normal impulse until the end of slip (axis 0) or of compression (axis 1), N s.

        ``change`` is the change of the generalized speeds per unit normal impulse (eqs. 2.75, 2.76,
        2.99, 2.100).
        """
        value = self.tip[axis]
        slope = self.rods.tip_velocity(change)[axis]
        return -value / slope if min(value, slope) < 0.0 < max(value, slope) else math.inf

    def until_work(self, change: Array, work: float) -> float:
        """Return the further normal impulse that does a given normal work, N s.

        It is the root p of v p + v' p^2/2 = W (2.83), with the normal velocity v of the tip, its
        change v' per unit normal impulse, and the work W, J.
        """
        speed = self.tip[1]
        gain = self.rods.tip_velocity(change)[1]
        if gain <= 0.0:
            return math.inf
        final = math.sqrt(max(speed**2 + 2.0 * gain * work, 0.0))
        return 2.0 * work / (speed + final) if final > 0.0 else 0.0

    def follow(self, part: str, mu: float, work: float | None = None) -> bool:
        """Follow compression or restitution to its end.

        The tip first slips until it stops; then it sticks or slips again until the end. Compression
        ends where the normal velocity is 0, restitution where its normal work is done (2.87).

        Args:
            part: ``compression`` or ``restitution``.
            mu: coefficient of friction.
            work: normal work of restitution, J; None in compression.

        Returns:
            Whether the end is reached by a finite impulse.
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
        """Resolve the impact and return the name of its outcome.

        ``mu`` is the coefficient of friction in compression, ``later`` the one in restitution.
        """
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
