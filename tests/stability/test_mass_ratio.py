"""Pendulums of any mass ratio beside exact arithmetic, and promises that notice lost digits."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bristle_sim.benchmarks.hard_cases import mass_ratio
from bristle_sim.benchmarks.hard_cases.case import HardCase
from bristle_sim.benchmarks.hard_cases.mass_ratio import MOTIONS, cases
from bristle_sim.parameters import Contact, Surface
from bristle_sim.scene import contact_laws, contact_space
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings
from bristle_sim.theory.impact import energetic_impact
from bristle_sim.theory.pendulums import double_pendulum_impact


@pytest.mark.parametrize("case", cases(full=False), ids=lambda case: case.name)
def test_promise(case: HardCase) -> None:
    finding = case.measure()
    assert finding.ok, finding.reached


def kept(*names: str) -> list[bool]:
    found = [case.run().ok for case in cases(full=False) if case.name in names]
    assert len(found) == len(names)
    return found


class TestPromisesNotice:
    def test_stick_told_from_rounding(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """K alone tells the compliance in stick to four digits at 1e12."""
        monkeypatch.setattr(contact_laws, "energetic_impact", lambda *given: energetic_impact(*given[:-1]))
        assert not any(kept("n = 1e+12, stick"))

    def test_a_way_out_of_stick_that_is_not_refined(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(contact_space, "_refine", lambda *_: None)
        assert not any(kept("n = 1e+12, stick"))

    def test_a_first_rod_of_another_mass(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """A millionth heavier; at 1e12 it moves as little."""
        chain = mass_ratio.chain
        monkeypatch.setattr(mass_ratio, "chain", lambda ratio, *rest: chain(ratio * (1.0 + 1e-6), *rest))
        assert not any(kept("n = 1000, slip", "n = 1000, reverse slip", "n = 1000, stick"))

    def test_a_flight_less_accurate(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(mass_ratio, "Extrapolation", lambda _: Extrapolation(1e-5))
        assert not any(kept("n = 0.01, flight", "n = 1000, flight"))

    def test_joints_that_are_not_closed(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Gaps of single steps add up."""
        monkeypatch.setattr(Scene, "correct_joints", lambda _scene, **_: None)
        assert not any(kept("n = 0.01, 1000 plain steps", "n = 1e+12, 1000 plain steps"))


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


REFEREED = (1e-9, 1e-3, 1.0, 1e6, 1e12)


class TestBesideExactArithmetic:
    @pytest.mark.parametrize("ratio", REFEREED)
    @pytest.mark.parametrize("word", MOTIONS)
    def test_dead_impacts(self, word: str, ratio: float) -> None:
        """Scene and closed form; 1e-12 as in the promise."""
        rates, friction = MOTIONS[word]
        found, form = self.rates(ratio, mass_ratio.ANGLES, rates, friction)
        expected = [float(each) for each in dead_impact(ratio, mass_ratio.ANGLES, rates, friction)]
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(form, expected, rtol=0.0, atol=1e-12)

    @pytest.mark.parametrize("ratio", REFEREED)
    def test_random_dead_impacts(self, ratio: float) -> None:
        """Nearly without slip before, so that most stick in compression; friction between 0 and 3."""
        rng = np.random.default_rng(3)
        for _ in range(15):
            angles, rates = mass_ratio._approaching(rng, near_stick=True)
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
        hit = strike(mass_ratio.chain(ratio, rates, angles), surface, Contact(), Settings())
        form = double_pendulum_impact(1.0, ratio, 1.0, -angles[0], -angles[1], -rates[0], -rates[1], friction, 0.0)
        return hit.contact.rates_after, (-form.final_rate_1, -form.final_rate_2)

    def test_stick_at_a_ratio_of_1e12_turns_round(self) -> None:
        """A tip that arrives without slip, is held and returns all work has only one way to go, and goes back on it."""
        first, second = mass_ratio.ANGLES
        rates = (-1.0, math.cos(first) / math.cos(second))
        hit = strike(mass_ratio.chain(1e12, rates), Surface(5.0, None, 1.0), Contact(), Settings())
        # Rounding of the rates leaves a slip of 1e-16.
        np.testing.assert_allclose(hit.contact.rates_after, [-rate for rate in rates], rtol=1e-12)


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


@pytest.mark.parametrize("ratio", [0.1, 1e3, 1e9])
def test_flight_beside_an_independent_solution(ratio: float) -> None:
    """The equations of motion of two rods, by scipy."""
    mechanism = Mechanism((Link.rod(ratio, 1.0), Link.rod(1.0, 1.0)))
    scene, stepper, state = Scene(mechanism, Effects()), Extrapolation(1e-10), mass_ratio.START
    while state.time < mass_ratio.END:
        length = stepper.propose(mass_ratio.END - state.time)
        result = stepper.advance(scene, state, length)
        if stepper.accepts(result, length):
            state = result.state

    def slope(_: float, y: Any) -> Any:
        first, second, one, two = y
        c, s = math.cos(first - second) / 2.0, math.sin(first - second) / 2.0
        turned = np.linalg.solve([[ratio / 3.0 + 1.0, c], [c, 1.0 / 3.0]], [-s * two**2, s * one**2])
        return [one, two, *turned]

    start = (*mass_ratio.START.angles, *mass_ratio.START.rates)
    end = solve_ivp(slope, (0.0, mass_ratio.END), start, "DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    # A hundred stretches of 1e-10, and scipy's own error.
    np.testing.assert_allclose((*state.angles, *state.rates), end, rtol=0.0, atol=1e-8)


def timed_or_refused(rods: Chain, surface: Surface) -> tuple[float, ...] | str:
    """Rates after a contact resolved in time, or the line that refuses it."""
    try:
        return strike(rods, surface, Contact("compliant"), Settings()).contact.rates_after
    except ValueError as error:
        return str(error)


def test_a_contact_in_time_follows_heavy_rods_that_stick() -> None:
    """Random pendulums, friction of 5, to ten times the accuracy of 1e-6; or one line that refuses, above 1e3 only."""
    rng, surface = np.random.default_rng(11), Surface(5.0, None, 0.5)
    for ratio in (1.0, 30.0, 1e3, 1e6):
        for _ in range(4):
            angles, rates = mass_ratio._approaching(rng, near_stick=True)
            rods = mass_ratio.chain(ratio, rates, angles)
            limit = strike(rods, surface, Contact(), Settings()).contact.rates_after
            timed = timed_or_refused(rods, surface)
            if isinstance(timed, str):
                assert ratio > 1e3, timed
                assert "allowed" in timed
                assert "\n" not in timed
            else:
                size = max(map(abs, (*rates, *limit)))
                np.testing.assert_allclose(timed, limit, rtol=0.0, atol=1e-5 * size)


def test_state_is_closed_at_any_ratio() -> None:
    """Placed bodies meet at their joints to rounding."""
    scene = Scene(Mechanism((Link.rod(1e12, 1.0), Link.rod(1.0, 1.0))), Effects())
    scene.place(State(0.0, (0.3, -1.2), (2.0, 5.0)))
    for joint in scene.joints:
        gap = joint.a.local_to_world(joint.anchor_a) - joint.b.local_to_world(joint.anchor_b)
        assert gap.length < 1e-15
