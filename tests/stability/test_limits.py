"""Coefficients at the ends of their ranges keep their promises, and the promises notice laws that do not."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from bristle_sim.benchmarks.hard_cases.case import HardCase
from bristle_sim.benchmarks.hard_cases.limits import CHAINS, cases, mirrored
from bristle_sim.parameters import Contact, Surface
from bristle_sim.scene import contact_laws
from bristle_sim.scene.contact_laws import Coefficients, EnergeticLaw
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings
from bristle_sim.theory.impact import energetic_impact, poisson_impact
from bristle_sim.theory.pendulums import double_pendulum_impact


@pytest.mark.parametrize("case", cases(full=False), ids=lambda case: case.name)
def test_promise(case: HardCase) -> None:
    finding = case.measure()
    assert finding.ok, finding.reached


def kept(*parts: str) -> list[bool]:
    found = [case.run().ok for case in cases(full=False) if all(part in case.name for part in parts)]
    assert found
    return found


class TestPromisesNotice:
    def test_a_little_restitution(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """e* = 1e-4 for 0, at which no more than 1e-8 of the work returns."""
        of = Coefficients.of

        def lively(obstacle: Any) -> Coefficients:
            return dataclasses.replace(of(obstacle), restitution=max(1e-4, obstacle.restitution))

        monkeypatch.setattr(Coefficients, "of", lively)
        assert not any(kept("two rods, no restitution", "friction 0.3"))
        assert not any(kept("whole pass, restitution 0, friction 0.3"))

    def test_energy_gained(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Rates 1e-9 too large, and what the ledger says with them."""
        resolve = EnergeticLaw.resolve

        def gaining(*given: Any) -> Any:
            after, record = resolve(*given)
            rates = tuple(rate * (1.0 + 1e-9) for rate in after.rates)
            work = (record.restitutive_work[0] - 1e-9 * record.compressive_work[0], record.restitutive_work[1])
            return after._replace(rates=rates), dataclasses.replace(record, restitutive_work=work)

        monkeypatch.setattr("bristle_sim.scene.tool.EnergeticLaw.resolve", gaining)
        names = ("restitution 1, no friction", "restitution 1, friction 0.3")
        assert not any(case.run().ok for case in cases(full=False) if case.name.endswith(names))

    def test_friction_that_pushes_to_one_side(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(
            contact_laws,
            "energetic_impact",
            lambda matrix, velocity, mu, *rest: energetic_impact(
                matrix, velocity, mu + 1e-3 * (velocity[1] > 0), *rest
            ),
        )
        found = [case for case in cases(full=False) if case.name.endswith("mirrored") and "two rods" in case.name]
        assert found
        assert not any(case.run().ok for case in found)

    def test_a_jam_without_a_name(self, monkeypatch: pytest.MonkeyPatch) -> None:
        resolve = EnergeticLaw.resolve

        def silent(*given: Any) -> Any:
            after, record = resolve(*given)
            return after, dataclasses.replace(record, outcome="rebound")

        monkeypatch.setattr("bristle_sim.scene.tool.EnergeticLaw.resolve", silent)
        assert not any(kept("bar's friction"))


def hit(chain: Chain, friction: float, restitution: float, law: str = "energetic") -> Any:
    return strike(chain, Surface(friction, None, restitution), Contact(law), Settings())


@pytest.mark.parametrize("friction", [0.0, 0.1, 0.57])
def test_a_single_rod_leaves_as_the_closed_form_says(friction: float) -> None:
    """Zhang 2020, sec. 2.4.1, at e* = 1: -sqrt((1 - mu cot)/(1 + mu cot)) of the rate, kept but for the jam at tan 30."""
    rod = CHAINS["single rod"]
    share = friction / math.tan(math.radians(30.0))
    expected = -math.sqrt((1.0 - share) / (1.0 + share))
    # Rounding, magnified near the jam by 1/(1 - mu cot) = 80.
    assert hit(rod, friction, 1.0).contact.rates_after[0] / rod.rates[0] == pytest.approx(expected, abs=1e-13)


@pytest.mark.parametrize("seed", range(10))
def test_random_rods_at_the_limits(seed: int) -> None:
    """No normal velocity, no energy gained, mirrored the same; friction up to the largest allowed."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 4))
    angles, rates = rng.uniform(-1.2, 1.2, count), rng.normal(size=count)
    lengths, masses = rng.uniform(0.2, 2.0, count), 10.0 ** rng.uniform(-1.0, 1.0, count)
    if float(np.sum(lengths * np.sin(angles) * rates)) > 0.0:
        rates = -rates
    rods = Chain(*(tuple(map(float, each)) for each in (masses, lengths, angles, rates)))
    for friction in (0.0, float(rng.uniform(0.0, 2.0)), 1e6, 1e9):
        dead, lively = hit(rods, friction, 0.0), hit(rods, friction, 1.0)
        # Rounding of all three.
        if dead.contact.outcome != "jam":
            assert abs(dead.contact.velocity_after[0]) <= 1e-12
        assert dead.kinetic_energy_ratio <= 1.0 + 1e-12
        assert lively.kinetic_energy_ratio <= 1.0 + 1e-12
        if friction == 0.0:
            assert lively.kinetic_energy_ratio == pytest.approx(1.0, abs=1e-12)
        other = hit(mirrored(rods), friction, 1.0).contact
        np.testing.assert_allclose([-rate for rate in other.rates_after], lively.contact.rates_after, atol=1e-11)


@pytest.mark.parametrize("restitution_friction", [5.0, 1e6, 1e9])
def test_an_impulse_spent_at_rest_is_no_rebound(restitution_friction: float) -> None:
    """Poisson's restitution of 0.1 times p_c = 1 slows a slip of 1.8, at rest, by 0.045: v_n stays 0.

    Slowing is (K_nn K_tt - K_nt^2)/K_nt = 0.45 per unit of impulse.
    """
    impact = poisson_impact([[1.0, 0.8], [0.8, 1.0]], [-1.0, 1.0], 0.0, 0.1, restitution_friction)
    assert (impact.outcome_name, impact.velocity_normal) == ("no rebound", 0.0)
    assert impact.velocity_tangential == pytest.approx(1.8 - 0.045, abs=1e-14)
    both = poisson_impact([[1.0, 0.8], [0.8, 1.0]], [-1.0, 1.0], 0.0, [0.1, 0.9], [restitution_friction, 0.0])
    assert both.outcome.tolist() == [2, 1]
    assert both.velocity_normal[1] > 0.0


def test_the_first_slip_is_a_slip_whatever_the_law() -> None:
    """A tip that arrives without slip, is driven to one side and does not turn back."""
    rods = Chain((1.0, 1.0), (1.0, 1.0), (-0.5, 0.5), (1.0, -1.0))
    names = ("compression slip", "restitution slip")
    assert hit(rods, 0.1, 0.5).contact.phases == names
    assert hit(rods, 0.1, 0.5, "compliant").contact.phases == names
    assert double_pendulum_impact(1.0, 1.0, 1.0, 0.5, -0.5, -1.0, 1.0, 0.1, 0.5).phases == names


@pytest.mark.parametrize("rate", [1e-310, 1e-300, 1e-200, 1e-100, 1e9])
def test_rates_of_any_size(rate: float) -> None:
    """An impact is homogeneous in the rates."""
    fast, usual = (
        hit(Chain((5.0, 5.0), (1.0, 1.0), (-0.4, -0.5), (each, 2.0 * each)), 0.3, 0.5).contact for each in (rate, 1.0)
    )
    assert (fast.outcome, fast.phases) == (usual.outcome, usual.phases)
    # Rounding; the last digits of subnormal numbers are 5e-324 apart, 5e-14 of 1e-310.
    scaled = [each / rate for each in fast.rates_after]
    np.testing.assert_allclose(scaled, usual.rates_after, rtol=1e-13 if rate > 1e-300 else 1e-12)
