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

# Largest component of the tip's velocity that counts as zero, as a fraction of the sum of the rods'
# initial generalized speeds.
ROUNDING = 1e-12

# Largest difference of the rods' angles at which the rods count as parallel, rad. The tip of
# parallel rods moves along one line.
PARALLEL = 1e-8


def stick_friction(mass_ratio: ArrayLike, angle_1: ArrayLike, angle_2: ArrayLike) -> Number:
    """Return the least friction coefficient at which a double pendulum's tip sticks after its slip.

    With the mass ratio n = m_1/m_2 of the rods, their angles theta_1 and theta_2 to the surface's
    normal (rad) and c = cos(theta_1 - theta_2), the coefficient of friction is

        mu_bar = |sin 2 theta_1 + (n + 3) sin 2 theta_2 - 3 c sin(theta_1 + theta_2)|
                 / (2 cos^2 theta_1 + 2 (n + 3) cos^2 theta_2 - 6 c cos theta_1 cos theta_2)

    For n = 1 this is eq. 2.90 of Zhang (2020). For theta_1 = theta_2 = theta the coefficient is tan
    theta for every n (2.111). Arrays broadcast.

    The dissertation's identical rods at 20 and 30 deg:

    >>> print(f"{stick_friction(1.0, math.radians(20.0), math.radians(30.0)):.6f}")
    0.623401
    """
    first = np.asarray(angle_1, dtype=float)
    second = np.asarray(angle_2, dtype=float)
    heavy = np.add(mass_ratio, 3.0)
    c = np.cos(first - second)
    driven = np.sin(2.0 * first) + heavy * np.sin(2.0 * second) - 3.0 * c * np.sin(first + second)
    resisted = (
        np.cos(first) ** 2 + heavy * np.cos(second) ** 2 - 3.0 * c * np.cos(first) * np.cos(second)
    )
    return np.abs(driven) / (2.0 * resisted)


class RodImpact:
    """The present state of an impact of two hinged rods of equal length L.

    The generalized speeds are q = (L phi'_1, L phi'_2/2), with the angular velocities phi' of the
    rods. The impulse acts on the tip C of the second rod.

    Attributes:
        speeds: generalized speeds, m/s.
        impulse: normal impulse so far, N s.
        compressive_impulse: normal impulse of compression, N s.
        work: normal work so far, J.
        phases: names of the phases so far.
        slip_stop: normal impulse at which slip stops, N s; inf until slip stops.
    """

    def __init__(self, mass: float, ratio: float, angles: Sequence[float], speeds: Array) -> None:
        """Begin an impact.

        Args:
            mass: mass of the second rod, kg.
            ratio: ratio of the mass of the first rod to that of the second rod.
            angles: angles of the rods to the surface's normal, rad.
            speeds: generalized speeds before the impact, m/s.
        """
        cosines = np.cos(angles)
        sines = np.sin(angles)
        between = angles[0] - angles[1]
        c = math.cos(between)
        # Generalized momenta per generalized speed (2.93), and the tip's (tangential, normal)
        # velocity per generalized speed (2.95).
        self.inertia = mass * np.array([[ratio / 3.0 + 1.0, c], [c, 4.0 / 3.0]])
        self.tip = np.array([-cosines, sines]) * [1.0, 2.0]
        # Changes of the generalized speeds per unit (tangential, normal) impulse (2.94, 2.96).
        self.response = np.linalg.solve(self.inertia, self.tip.T)
        # The tip C of parallel rods moves along one line, so it cannot lift off while it sticks.
        parallel = abs(between) < PARALLEL
        self.lever = 2.0 * math.sin(between)
        in_stick = [2.0 * cosines[1], -cosines[0]]
        self.in_stick = self._guided(in_stick, 0.0 if parallel else self.lever)
        self.at_rest = [2.0 * sines[1], -sines[0]]
        self.threshold = float(stick_friction(ratio, *angles))
        self.speeds = speeds
        self.impulse = 0.0
        self.compressive_impulse = 0.0
        self.work = 0.0
        self.phases: list[str] = []
        across = 2.0 * PARALLEL if parallel else 0.0
        self._least = (ROUNDING + across) * float(np.abs(speeds).sum())
        self.first_slip = math.copysign(1.0, self.velocity[0]) if self.velocity[0] else 0.0
        self.slip_stop = math.inf if self.first_slip else 0.0

    def _guided(self, freedom: Sequence[float], push: float) -> Array:
        """Return the change of the generalized speeds per unit normal impulse in a guided motion.

        A constraint makes the change proportional to the vector ``freedom``. ``push`` is the scalar
        product of ``freedom`` and the generalized impulse, per unit normal impulse.
        """
        direction = np.array(freedom)
        return direction * (push / float(direction @ self.inertia @ direction))

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy of the rods, J (Zhang 2020, eq. 2.93)."""
        return 0.5 * float(self.speeds @ self.inertia @ self.speeds)

    @property
    def velocity(self) -> list[float]:
        """Tangential and normal velocity of the tip, m/s.

        A component that is not larger than rounding error is set to zero.
        """
        values: list[float] = (self.tip @ self.speeds).tolist()
        return [each if abs(each) > self._least else 0.0 for each in values]

    def follow(self, part: str, mu: float, work: float | None = None) -> bool:
        """Advance the impact to the end of compression or of restitution.

        The tip first slips until it stops; then it sticks or slips again. Compression ends where
        the normal velocity is 0, restitution where the normal work is ``work`` (2.87).

        Args:
            part: ``compression`` or ``restitution``.
            mu: coefficient of friction.
            work: normal work of restitution, J; None in compression.

        Returns:
            Whether a finite impulse reaches the end.
        """
        for slips in (True, False) if self.velocity[0] else (False,):
            along, away = self.velocity
            direction = math.copysign(1.0, along if slips else self.tip[0] @ self.response[:, 1])
            motion = "stick"
            change = self.in_stick
            if slips or mu < self.threshold:
                self.first_slip = self.first_slip or direction
                motion = "slip" if direction == self.first_slip else "reverse slip"
                change = self.response @ [-mu * direction, 1.0]
            if slips and work is not None and self.tip[1] @ change <= 0.0:
                # Friction larger than in compression would drive C back as soon as C leaves; instead
                # it keeps the normal velocity of C at 0.
                coupling, normal = self.tip[1] @ self.response
                change = self._guided(self.at_rest, -normal / coupling * self.lever)
            turn, gain = (self.tip @ change).tolist()
            end = until_zero(away, gain) if work is None else until_work(away, gain, work)
            stop = until_zero(along, turn) if slips else math.inf
            if math.isinf(step := min(stop, end)):
                return False
            done = (away + 0.5 * gain * step) * step
            self.speeds = self.speeds + change * step
            self.work += done
            self.impulse += step
            self.phases.append(f"{part} {motion}")
            along, away = self.velocity
            if math.isinf(self.slip_stop) and not along:
                self.slip_stop = self.impulse
            if end <= stop or (work is None and not away < 0.0):
                return True
            work = None if work is None else work - done
        return False

    def resolve(self, mu: float, restitution: float, later: float) -> str:
        """Resolve the impact and return the name of its outcome.

        ``mu`` and ``later`` are the coefficients of friction in compression and in restitution.
        ``restitution`` is the energetic coefficient of restitution.
        """
        if not self.velocity[1] < 0.0:
            return "no contact"
        if not self.follow("compression", mu):
            return "jam"
        self.compressive_impulse = self.impulse
        if restitution == 0.0:
            return "no rebound"
        ends = self.follow("restitution", later, -(restitution**2) * self.work)
        return "rebound" if ends else "stiction"


def until_zero(speed: float, gain: float) -> float:
    """Return the normal impulse after which a component of the tip's velocity is zero, N s.

    ``speed`` is this component (m/s), ``gain`` its change per unit normal impulse (1/kg). The
    result is infinite if the component does not fall to zero (eqs. 2.75, 2.76, 2.99, 2.100).
    """
    return -speed / gain if min(speed, gain) < 0.0 < max(speed, gain) else math.inf


def until_work(speed: float, gain: float, work: float) -> float:
    """Return the additional normal impulse that does a given normal work, N s.

    The impulse is the root p of v p + v' p^2/2 = W (2.83), with the normal velocity v of the tip
    (``speed``, m/s), its change v' per unit normal impulse (``gain``, 1/kg), and the work W (J).
    """
    if gain <= 0.0:
        return math.inf
    final = math.sqrt(max(speed**2 + 2.0 * gain * work, 0.0))
    return 2.0 * work / (speed + final) if final > 0.0 else 0.0
