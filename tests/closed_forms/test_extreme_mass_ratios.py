"""Two rods of extreme mass ratios, compared with exact arithmetic and an independent integration."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest

from bristle_sim.benchmarks.hard_cases.strikes import ANGLES, MOTIONS
from bristle_sim.parameters import Contact, Surface
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings
from bristle_sim.theory.pendulums import double_pendulum_impact


@dataclass
class Exact:
    """A chain's contact in rational numbers, sine and cosine of its angles taken to 60 digits."""

    inertia: list[list[Fraction]]
    normal: list[Fraction]
    tangential: list[Fraction]

    @classmethod
    def of(cls, ratio: float, angles: tuple[float, float]) -> Exact:
        """Two rods of 1 m, the second of 1 kg."""
        n, sines, cosines = Fraction(ratio), [sine(a) for a in angles], [cosine(a) for a in angles]
        coupled = (sines[0] * sines[1] + cosines[0] * cosines[1]) / 2
        return cls([[n / 3 + 1, coupled], [coupled, Fraction(1, 3)]], sines, cosines)

    def solve(self, right: list[Fraction]) -> list[Fraction]:
        """Changes of the rates by generalized impulses."""
        (a, b), (_, d) = self.inertia
        whole = a * d - b * b
        return [(d * right[0] - b * right[1]) / whole, (a * right[1] - b * right[0]) / whole]


def sine(angle: float) -> Fraction:
    """Taylor's series."""
    return series(Fraction(angle), 1)


def cosine(angle: float) -> Fraction:
    """Taylor's series."""
    return series(Fraction(angle), 0)


def series(x: Fraction, power: int) -> Fraction:
    term, total = x**power, Fraction(0)
    while abs(term) > Fraction(1, 10**60):
        total += term
        term *= -x * x / ((power + 1) * (power + 2))
        power += 2
    return total.limit_denominator(10**60)


def dot(one: list[Fraction], other: list[Fraction]) -> Fraction:
    return one[0] * other[0] + one[1] * other[1]


def dead_impact(
    ratio: float, angles: tuple[float, float], rates: tuple[float, float], friction: float
) -> list[Fraction]:
    """Rates at the end of compression: slip until it stops or the tip rests, then stick or slip on.

    Without restitution no root is drawn, so that it is exact.
    """
    exact, now = Exact.of(ratio, angles), [Fraction(rate) for rate in rates]
    by_normal, by_tangential = exact.solve(exact.normal), exact.solve(exact.tangential)
    normal, coupling = dot(exact.normal, by_normal), dot(exact.tangential, by_normal)
    tangential, mu = dot(exact.tangential, by_tangential), Fraction(friction)
    for _ in range(2):
        approach, slip = dot(exact.normal, now), dot(exact.tangential, now)
        share = -mu * sign(slip) if slip else -coupling / tangential
        if not slip and mu * tangential < abs(coupling):
            share = -mu * sign(coupling)
        rise, drive = normal + share * coupling, coupling + share * tangential
        ends = [-approach / rise] if rise > 0 else []
        stops = [-slip / drive] if slip * drive < 0 else []
        impulse = min(ends + stops)
        now = [
            rate + impulse * (one + share * two) for rate, one, two in zip(now, by_normal, by_tangential, strict=True)
        ]
        if impulse in ends:
            return now
    raise AssertionError("two phases of compression at most")


def sign(value: Fraction) -> int:
    return (value > 0) - (value < 0)


def approaching(rng: np.random.Generator, ratio: float) -> Chain:
    """Random rods whose tip approaches the surface nearly without slip."""
    first, second = (float(each) for each in rng.uniform(-1.3, 1.3, size=2))
    one, two = (float(each) for each in rng.normal(size=2))
    one = -two * math.cos(second) / math.cos(first) * (1.0 + 0.1 * one)
    if math.sin(first) * one + math.sin(second) * two > 0.0:
        one, two = -one, -two
    return two_rods(ratio, (one, two), (first, second))


def two_rods(ratio: float, rates: tuple[float, float], angles: tuple[float, float]) -> Chain:
    return Chain((ratio, 1.0), (1.0, 1.0), angles, rates)


REFEREED = (1e-9, 1e-3, 1.0, 1e6, 1e12)


class TestExactArithmetic:
    @pytest.mark.parametrize("ratio", REFEREED)
    @pytest.mark.parametrize("word", MOTIONS)
    def test_dead_impacts(self, word: str, ratio: float) -> None:
        """Scene and closed form; 1e-12 rounding times the condition of the rods."""
        rates, friction = MOTIONS[word]
        found, form = self.rates(ratio, ANGLES, rates, friction)
        expected = [float(each) for each in dead_impact(ratio, ANGLES, rates, friction)]
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(form, expected, rtol=0.0, atol=1e-12)

    @pytest.mark.parametrize("ratio", REFEREED)
    def test_random_dead_impacts(self, ratio: float) -> None:
        """Nearly without slip before, so that most stick in compression; friction between 0 and 3."""
        rng = np.random.default_rng(3)
        for _ in range(15):
            chain = approaching(rng, ratio)
            (first, second), (one, two) = chain.angles, chain.rates
            angles, rates = (first, second), (one, two)
            friction = float(rng.uniform(0.0, 3.0))
            expected = [float(each) for each in dead_impact(ratio, angles, rates, friction)]
            size = max(map(abs, (*expected, *rates)))
            found, form = self.rates(ratio, angles, rates, friction)
            # Rods of nearly equal angles, down to 0.01 rad, lose four digits more.
            np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-10 * size)
            np.testing.assert_allclose(form, expected, rtol=0.0, atol=1e-10 * size)

    @staticmethod
    def rates(
        ratio: float, angles: tuple[float, float], rates: tuple[float, float], friction: float
    ) -> tuple[tuple[float, ...], tuple[float, ...]]:
        surface = Surface(friction, None, 0.0)
        hit = strike(two_rods(ratio, rates, angles), surface, Contact(), Settings())
        form = double_pendulum_impact(1.0, ratio, 1.0, -angles[0], -angles[1], -rates[0], -rates[1], friction, 0.0)
        return hit.contact.rates_after, (-form.final_rate_1, -form.final_rate_2)


@pytest.mark.parametrize("count", [3, 4])
def test_longer_chains_gain_nothing(count: int) -> None:
    """Ratios of up to 1e8 from rod to rod, in either sense."""
    rng = np.random.default_rng(count)
    for draw in range(20):
        masses = 10.0 ** (4.0 * rng.integers(-1, 2, count))
        angles, rates = rng.uniform(-1.2, 1.2, count), rng.normal(size=count)
        if float(np.sum(np.sin(angles) * rates)) > 0.0:
            rates = -rates
        rods = Chain(*(tuple(map(float, each)) for each in (masses, np.ones(count), angles, rates)))
        hit = strike(rods, Surface(float(draw % 4), None, 1.0), Contact(), Settings())
        assert hit.kinetic_energy_ratio is not None
        # Rounding.
        assert hit.kinetic_energy_ratio <= 1.0 + 1e-12
