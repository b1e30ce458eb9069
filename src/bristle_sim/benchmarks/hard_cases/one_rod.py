"""A strike of one straight rod in closed form, however near its friction is to the jam.

What decides, sin phi - mu s cos phi, is taken of the very numbers that the floats are, so that no digit of it is lost.
"""

from __future__ import annotations

import decimal
import math
from dataclasses import dataclass
from decimal import Decimal

__all__ = ["RodStrike", "rod_strike", "sine_and_cosine"]


def sine_and_cosine(angle: float) -> tuple[Decimal, Decimal]:
    """Of the very number that the float is, in rad, by their series, in the digits of the decimal context in force."""
    sums, term, power = [Decimal(1), Decimal(0)], Decimal(1), 0
    least = Decimal(10) ** -(decimal.getcontext().prec + 30)
    while abs(term) > least:
        power += 1
        term *= Decimal(angle) / power
        sums[power % 2] += term if power % 4 < 2 else -term
    return sums[1], sums[0]


@dataclass(frozen=True, slots=True)
class RodStrike:
    """What a strike of one rod comes to.

    Attributes:
        outcome: a word.
        impulse: normal, N s.
        distance: of the friction from the jam, relative to it.
        arms: 1/|sin phi cos phi|, which magnifies what is rounded of the tip's place.
    """

    outcome: str
    impulse: float
    distance: float
    arms: float


def rod_strike(
    mass: float, angle: float, velocity: tuple[float, float], friction: float, restitution: float
) -> RodStrike:
    """A rod's tip arrives with (v_n, v_t) in m/s; the rod's angle in rad is positive for a tip ahead of its root.

    Pulled, its tip moves along one line and slip and compression stop together; pushed, slip goes on while it can.
    """
    slip = math.copysign(1.0, velocity[1])
    with decimal.localcontext(prec=60):
        sine, cosine = sine_and_cosine(angle)
        rubbing = Decimal(friction) * int(slip) * cosine
        against, along = float(sine - rubbing), float(sine + rubbing)
        place = float(abs((abs(rubbing) - abs(sine)) / sine)), float(abs(1 / (sine * cosine)))
    normal, tangential = 3.0 / mass * float(sine), 3.0 / mass * float(cosine)
    if slip * float(sine) > 0.0:
        if normal * against <= 0.0:
            return RodStrike("jam", abs(velocity[1] / (tangential * against)) if against else math.inf, *place)
        return RodStrike("rebound", -velocity[0] / (normal * against) * (1.0 + restitution), *place)
    compressive = -velocity[0] / (normal * against)
    if normal * along <= 0.0:
        return RodStrike("stiction", compressive, *place)
    return RodStrike("rebound", compressive * (1.0 + restitution * math.sqrt(against / along)), *place)
