"""Strikes of two rods, of any ratio of masses, beside a referee that solves the same impact with eighty digits."""

from __future__ import annotations

import decimal
import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from decimal import Decimal

import numpy as np
import pytest

from bristle_sim.parameters import Contact, Surface
from bristle_sim.scene.strike import Chain, ChainStrike, strike
from bristle_sim.settings import Settings

ROUNDING = 256.0 * sys.float_info.epsilon
"""Rounding of a strike: some hundred operations on numbers of the order of the result."""

RODS = Chain((1.0, 1.0), (1.0, 1.0), (-math.radians(20.0), -math.radians(30.0)), (0.1, 0.2))

MOTIONS = {
    "slip reverses": ((0.1, 0.2), (0.0, 0.3, 0.7)),
    "sticks": ((-1.0, 1.1), (0.7, 5.0)),
    "slips": ((1.0, 0.2), (0.0, 0.3)),
}
"""Rates and frictions: slip that turns round in restitution, that stops in compression, that goes on."""

SAME = Decimal(10) ** -40
"""Impulses that differ by less are one, in eighty digits."""


@pytest.fixture(autouse=True)
def eighty_digits() -> Iterator[None]:
    with decimal.localcontext(prec=80):
        yield


def rods(name: str, ratio: float) -> Chain:
    return replace(RODS, masses=(ratio, 1.0), rates=MOTIONS[name][0])


def sine_and_cosine(angle: float) -> tuple[Decimal, Decimal]:
    """By their series."""
    sums = [Decimal(1), Decimal(0)]
    term = Decimal(1)
    for power in range(1, 100):
        term *= Decimal(angle) / power
        sums[power % 2] += term if power % 4 < 2 else -term
    return sums[1], sums[0]


Pair = tuple[Decimal, Decimal]


def dot(one: Pair, other: Pair) -> Decimal:
    return one[0] * other[0] + one[1] * other[1]


@dataclass
class Referee:
    """Stronge's law for two rods of 1 m, in exact arithmetic: phase by phase, each to the impulse at which it ends."""

    chain: Chain
    friction: float
    restitution: float
    later: float | None = None
    impulse: Decimal = Decimal(0)
    outcome: str = "rebound"
    sticks: bool = False
    rates: Pair = field(init=False)

    def __post_init__(self) -> None:
        (s_1, c_1), (s_2, c_2) = map(sine_and_cosine, self.chain.angles)
        heavy, light = map(Decimal, self.chain.masses)
        own = heavy / 3 + light
        coupled = light * (c_1 * c_2 + s_1 * s_2) / 2
        other = light / 3
        determinant = own * other - coupled**2
        self.normal = (s_1, s_2)
        self.tangent = (c_1, c_2)
        self.push, self.rub = (
            (
                (other * arm[0] - coupled * arm[1]) / determinant,
                (own * arm[1] - coupled * arm[0]) / determinant,
            )
            for arm in (self.normal, self.tangent)
        )
        self.rates = (Decimal(self.chain.rates[0]), Decimal(self.chain.rates[1]))
        self.inertia = (own, coupled, other)
        self.k = (
            dot(self.normal, self.push),
            dot(self.tangent, self.push),
            dot(self.tangent, self.rub),
        )
        self.energy_before = self.energy()
        self.solve()

    def energy(self) -> Decimal:
        """Twice the kinetic energy."""
        (one, other), (own, coupled, light) = self.rates, self.inertia
        return own * one**2 + 2 * coupled * one * other + light * other**2

    def solve(self) -> None:
        slip = self.sign(dot(self.tangent, self.rates)) or self.driven(self.friction)
        done = Decimal(0)
        while dot(self.normal, self.rates) < -SAME:
            # Compression, to its end or that of slip.
            slip, work = self.phase(slip, self.friction, None)
            done += work
        e = Decimal(self.restitution)
        later = self.friction if self.later is None else self.later
        left = -done * e * e
        slip = self.sign(dot(self.tangent, self.rates)) or self.driven(later)
        if self.restitution == 0.0:
            self.outcome = "no rebound"
        while self.restitution > 0.0 and left > SAME:
            slip, work = self.phase(slip, later, left)
            left -= work

    def phase(self, slip: int, mu: float, left: Decimal | None) -> tuple[int, Decimal]:
        """Up to the end of slip, of compression, or (given the work that is left) of restitution."""
        normal, coupling, tangential = self.k
        ratio = -Decimal(mu) * slip if slip else -coupling / tangential
        gain = normal + ratio * coupling
        drift = coupling + ratio * tangential
        if not slip:
            self.sticks = True
            drift = Decimal(0)
        approach = dot(self.normal, self.rates)
        rub = dot(self.tangent, self.rates)
        if left is not None and gain <= 0:
            # It would press the tip on again as soon as it leaves: as much friction as keeps it there.
            ratio = -normal / coupling
            gain = Decimal(0)
            drift = coupling - normal * tangential / coupling
        end = self.end(approach, gain, left)
        stop = -rub / drift if self.sign(rub) * drift < 0 else Decimal("inf")
        step = min(end, stop)
        self.impulse += step
        self.rates = tuple(
            rate + step * (one + ratio * other)
            for rate, one, other in zip(self.rates, self.push, self.rub, strict=True)
        )
        return (slip if end < stop else self.driven(mu)), step * (
            approach + dot(self.normal, self.rates)
        ) / 2

    def end(self, approach: Decimal, gain: Decimal, left: Decimal | None) -> Decimal:
        if left is None:
            return -approach / gain if gain > 0 else Decimal("inf")
        root = (approach**2 + 2 * gain * left).sqrt() + approach
        return 2 * left / root if root > 0 else Decimal("inf")

    def driven(self, mu: float) -> int:
        _, coupling, tangential = self.k
        return 0 if Decimal(mu) * tangential >= abs(coupling) else self.sign(coupling)

    @staticmethod
    def sign(value: Decimal) -> int:
        return 0 if abs(value) < SAME else 1 if value > 0 else -1


def hit(
    chain: Chain, friction: float, restitution: float, later: float | None = None
) -> ChainStrike:
    return strike(chain, Surface(friction, later, restitution), Contact(), Settings())


def off(found: ChainStrike, exact: Referee) -> float:
    """Largest error of the rates, relative to the largest, and of the impulse."""
    rates = [float(rate) for rate in exact.rates]
    size = max(map(abs, (*rates, *found.contact.rates_before)))
    errors = [
        abs(one - other) / size for one, other in zip(found.contact.rates_after, rates, strict=True)
    ]
    return max(*errors, abs(found.contact.impulse[0] / float(exact.impulse) - 1.0))


class TestReferee:
    """What the referee says where a person can say it, too."""

    def test_printed_point(self) -> None:
        """Eight digits worked out apart: theta = 20, 30 deg, rates -0.1, -0.2 rad/s, e* = 0.5, mu = 0.7, 1 kg."""
        exact = Referee(rods("slip reverses", 1.0), 0.7, 0.5)
        assert [float(rate) for rate in exact.rates] == pytest.approx(
            [0.19260193, -0.20898534], abs=5.1e-9
        )
        assert float(exact.impulse) == pytest.approx(0.51199185 / 5.0, abs=1.1e-9)
        assert exact.sticks


@pytest.mark.parametrize("ratio", [1e-9, 1e-3, 1e3, 1e9, 1e12, 1e15])
@pytest.mark.parametrize("name", MOTIONS)
def test_chosen_motions_beside_the_referee(name: str, ratio: float) -> None:
    chain = rods(name, ratio)
    for friction in MOTIONS[name][1]:
        for restitution in (0.0, 0.5, 1.0):
            exact = Referee(chain, friction, restitution)
            found = hit(chain, friction, restitution)
            assert found.contact.outcome == exact.outcome
            assert off(found, exact) <= ROUNDING


@pytest.mark.parametrize("ratio", [1e-9, 1e-3, 1.0, 1e4, 1e8, 1e12, 1e15])
def test_drawn_rods_beside_the_referee(ratio: float) -> None:
    """Every second draw comes almost without slip, and so sticks in compression where friction is large.

    A way out of stick above a hundredth of the normal column is not given its digits back: two of sixteen may be lost. The
    nearer a slip's normal compliance is to none, the more its friction's rounding shows: K_nn over that compliance.
    """
    rng = np.random.default_rng(int(math.log10(ratio)) + 20)
    sticks = 0
    for draw in range(24):
        chain = random_rods(rng, ratio, almost_sticks=draw % 2 == 0)
        friction = rng.choice([0.0, 0.4, 1.0, 4.0])
        restitution = rng.choice([0.0, 0.6, 1.0])
        exact = Referee(chain, friction, restitution)
        found, (normal, coupling, _) = hit(chain, friction, restitution), map(float, exact.k)
        near = normal / min(normal, abs(normal - friction * abs(coupling)))
        assert found.contact.outcome == exact.outcome
        assert off(found, exact) <= (100.0 if exact.sticks else near) * ROUNDING
        assert found.kinetic_energy_ratio is not None
        assert found.kinetic_energy_ratio <= 1.0 + 100.0 * ROUNDING
        sticks += exact.sticks
    assert sticks > 2


def random_rods(rng: np.random.Generator, ratio: float, *, almost_sticks: bool) -> Chain:
    first, second = rng.uniform(-1.3, 1.3, 2).tolist()
    one, other = rng.normal(size=2).tolist()
    if almost_sticks:
        one = -other * math.cos(second) / math.cos(first) * (1.0 + 0.1 * rng.normal())
    side = -1.0 if math.sin(first) * one + math.sin(second) * other > 0.0 else 1.0
    return Chain((ratio, 1.0), (1.0, 1.0), (first, second), (side * one, side * other))


@pytest.mark.parametrize("ratio", [1e-3, 1.0, 1e6, 1e12])
def test_friction_larger_in_restitution(ratio: float) -> None:
    """Slip at rest, whose impulse is of the order of n, beside the referee."""
    chain = replace(rods("sticks", ratio), rates=(-1.0, 1.0))
    exact = Referee(chain, 0.0, 0.5, 5.0)
    found = hit(chain, 0.0, 0.5, 5.0)
    assert exact.impulse > Decimal(ratio) / 100
    assert off(found, exact) <= 100.0 * ROUNDING


@pytest.mark.parametrize("count", [3, 4])
def test_longer_chains_gain_nothing(count: int) -> None:
    """Ratios of up to 1e8 from rod to rod, in either sense."""
    rng = np.random.default_rng(count)
    for draw in range(20):
        masses = 10.0 ** (4.0 * rng.integers(-1, 2, count))
        angles = rng.uniform(-1.2, 1.2, count)
        rates = rng.normal(size=count)
        rates = -rates if float(np.sum(np.sin(angles) * rates)) > 0.0 else rates
        chain = Chain(
            *(tuple(map(float, each)) for each in (masses, np.ones(count), angles, rates))
        )
        found = hit(chain, float(draw % 4), 1.0)
        assert found.kinetic_energy_ratio is not None
        assert found.kinetic_energy_ratio <= 1.0 + 1e-12  # rounding


@pytest.mark.parametrize("law", ["energetic", "compliant"])
@pytest.mark.parametrize("degrees", [5.0, 20.0, 30.9])
def test_two_rods_in_line_stick_where_friction_exceeds_the_tangent(
    degrees: float, law: str
) -> None:
    """The tip moves across the line only, so slip and approach end together, and restitution cannot move it: stiction.

    With the mass matrix [[8, 3], [3, 2]]/6 and the lever (1, 1), the rates (1, 1) become (3, -3)/2 and 9/16 of the energy is
    left. A compliance in stick of rounding error made the tip rebound with more energy than it came with.
    """
    angle = math.radians(degrees)
    chain = Chain((1.0, 1.0), (1.0, 1.0), (angle, angle), (-1.0, -1.0))
    found = strike(chain, Surface(0.6, None, 1.0), Contact(law), Settings(accuracy=1e-6))
    assert found.contact.outcome == "stiction"
    assert found.contact.rates_after == pytest.approx((-1.5, 1.5), rel=1e-5)
    assert found.kinetic_energy_ratio == pytest.approx(0.5625, rel=1e-5)
