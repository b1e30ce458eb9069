"""Damped belts keep their promises, and the promises notice a program that is broken."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bristle_sim.benchmarks.hard_cases.case import HardCase
from bristle_sim.benchmarks.hard_cases.damping import cases, decay
from bristle_sim.parameters import Belt, Hub, Tool
from bristle_sim.scene import time_scales
from bristle_sim.scene import tool as scene_tool
from bristle_sim.scene.build import Effects
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings

ON_AXIS = Tool(hub=Hub(radius=0.0), bar=None, workpart=None)


@pytest.mark.parametrize("case", cases(full=False), ids=lambda case: case.name)
def test_promise(case: HardCase) -> None:
    finding = case.measure()
    assert finding.ok, finding.reached


def named(*words: str) -> list[HardCase]:
    found = [case for case in cases(full=False) if all(word in case.name for word in words)]
    assert found
    return found


class TestClosedForm:
    @pytest.mark.parametrize("ratio", [0.0, 1e-9, 0.3, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.5, 10.0, 100.0])
    def test_solves_the_equation(self, ratio: float) -> None:
        """A library's integrator, at a relative tolerance of 1e-11, on a'' + 2 zeta a' + a = 0."""
        phase = np.linspace(0.0, 20.0, 41)
        solution = solve_ivp(
            lambda _, state: (state[1], -state[0] - 2.0 * ratio * state[1]),
            (0.0, 20.0),
            (1.0, 0.0),
            method="Radau" if ratio > 10.0 else "DOP853",
            t_eval=phase,
            max_step=0.5 / (1.0 + ratio) if ratio <= 10.0 else math.inf,
            rtol=1e-11,
            atol=1e-13,
        )
        # Some hundred steps of that tolerance.
        np.testing.assert_allclose(decay(ratio, phase), solution.y, rtol=0.0, atol=1e-9)

    def test_critical_is_the_limit_of_both_sides(self) -> None:
        """(1 + p) e^-p at 1; 1e-9 beside it changes the angle by less than 1e-9, across both ways of computing it."""
        phase = np.linspace(0.0, 400.0, 401)
        expected = ((1.0 + phase) * np.exp(-phase), -phase * np.exp(-phase))
        for ratio in (1.0 - 1e-9, 1.0, 1.0 + 1e-9):
            np.testing.assert_allclose(decay(ratio, phase), expected, rtol=0.0, atol=1e-9)

    def test_slow_exponent_keeps_its_digits(self) -> None:
        """At 1e8 the bristle creeps as e^(-p/(2 zeta)), to 1/(4 zeta^2)."""
        phase = np.array([0.0, 1e7, 1e8])
        np.testing.assert_allclose(decay(1e8, phase)[0], np.exp(-phase / 2e8), rtol=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_decay_of_any_belt(seed: int) -> None:
    """Any stiffness, ratio, hub speed and accuracy, released with a rate; superposed from two closed forms."""
    rng = np.random.default_rng(seed)
    ratio, accuracy = 10.0 ** rng.uniform(-2.0, 1.0), 10.0 ** rng.uniform(-8.0, -4.0)
    belt = Belt(stiffness=10.0 ** rng.uniform(-4.0, 3.0), damping_ratio=ratio)
    rate = math.sqrt(belt.stiffness / ON_AXIS.bristle.inertia_about_root)
    tool = replace(ON_AXIS, hub=Hub(speed=rate * rng.uniform(0.2, 0.8), radius=0.0), belt=belt)
    start = float(rng.uniform(0.3, 0.7))
    run = simulate(
        tool, Settings(accuracy=accuracy, hub_turn=3.0), start_relative_angle=-start, start_relative_rate=0.3 * rate
    )
    angle, slope = decay(ratio, rate * run.time)
    # The response to a rate is -decay's own rate: both start at 0 with the slope 1.
    expected = -start * angle - 0.3 * slope
    # Rounding adds up to 1e-9 at a ratio of 10.
    assert np.abs(run.relative_angle - expected).max() <= max(accuracy, 2e-9)


@pytest.mark.parametrize("ratio", [1.0, 30.0])
def test_the_estimate_too_stays_within_the_accuracy(ratio: float) -> None:
    """However many stretches damping takes."""
    settings = Settings(hub_turn=2.0)
    run = simulate(replace(ON_AXIS, belt=Belt(damping_ratio=ratio)), settings, start_relative_angle=-0.7)
    assert run.cost.error_estimate is not None
    assert run.cost.error_estimate <= settings.accuracy


@pytest.mark.parametrize("ratio", [20.0, 100.0, 1e3])
@pytest.mark.parametrize("accuracy", [1e-3, 1e-6])
def test_a_stiff_start_does_not_freeze(ratio: float, accuracy: float) -> None:
    """It falls as it should, however little that is of what the accuracy would allow."""
    rate = math.sqrt(ON_AXIS.belt.stiffness / ON_AXIS.bristle.inertia_about_root)
    tool = replace(ON_AXIS, hub=Hub(speed=1.0, radius=0.0), belt=Belt(damping_ratio=ratio))
    run = simulate(tool, Settings(accuracy=accuracy, hub_turn=0.1 / rate), start_relative_angle=-0.5)
    fall = 1.0 - decay(ratio, np.array([0.1]))[0][0]
    assert 1.0 + 2.0 * run.relative_angle[-1] == pytest.approx(fall, rel=10.0 * accuracy, abs=accuracy * fall)


def damped(monkeypatch: pytest.MonkeyPatch, factor: float) -> None:
    """Build every scene with a damping that is off by a factor."""

    def effects(damping: float = 0.0, **others: Any) -> Effects:
        return Effects(damping=damping * factor, **others)

    monkeypatch.setattr(scene_tool, "Effects", effects)


def test_damping_off_by_little_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A belt of ratio 100 falls by 1 % only in what is tried, a thousandth of which is ten times the limit."""
    damped(monkeypatch, 1.001)
    for case in (*named("ratio 0.5: decay"), *named("ratio 100: decay"), *named("ratio 0.5: whole pass")):
        assert not case.measure().ok


def test_a_belt_that_freezes_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stretches as long as without damping: the engine's steps all agree on no motion."""
    monkeypatch.setattr(time_scales, "MOST_DAMPING", 1e9)
    (case,) = named("ratio 100: decay")
    finding = case.measure()
    assert not finding.ok
    assert finding.steps < 5000


def test_damping_that_drives_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Energy that rises by 2e-6 a radian."""
    damped(monkeypatch, -1000.0)
    (case,) = named("ratio 1e-09: decay")
    assert not case.measure().ok


def test_a_step_too_long_for_the_damping_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(time_scales, "damping_rate", lambda _: 0.0)
    (case,) = named("ratio 0.5: fixed step a tenth too long")
    assert not case.run().ok
