"""The dissertation's tool, simulated: the numbers that two independent integrations agree on, and the cue formulas.

The operating point: radial at 90 degrees before the workpart's normal, turning with the hub; belt stiffness read per
degree; rigid, inelastic, frictionless bar. The numbers below were found with a rigid-body engine and, in generalized
coordinates, with a stiff damped bar; tolerances are those to which the two agreed, or half a last digit.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from bristle_sim.parameters import Tool
from bristle_sim.reference import simulate_reference
from bristle_sim.reference.mechanics import Chain
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings
from bristle_sim.trajectory import Trajectory

RETRACTION = math.radians(44.5)
RELEASE = {"start_relative_angle": -RETRACTION, "stop_after": "highest relative speed"}

GAMMA = math.acos(50.0 / 54.5)
"""Impact angle of a radial bristle: its tip 54.5 mm from the hub's centre, 50 mm above the workpart."""


def check_strike(run: Trajectory) -> None:
    """Time, relative speed and lag of the strike."""
    strike = run.first_contact("workpart")
    assert strike is not None
    assert strike.time == pytest.approx(4.5300e-3, rel=1e-4)
    assert strike.rates_before[0] - run.hub_speed == pytest.approx(877.09, rel=3e-4)
    assert lag(run) == pytest.approx(2.743, rel=5e-3)


def check_retraction(run: Trajectory) -> None:
    """Largest before the strike."""
    assert largest_retraction(run) == pytest.approx(44.995, rel=2e-3)


def check_bar(run: Trajectory) -> None:
    """First touch by geometry, an inelastic tap, then sustained contact until the bar releases the wire."""
    taps = [each for each in run.contacts if each.obstacle == "bar"]
    assert run.event_time("bar touch") == pytest.approx(1.279e-3, abs=0.5e-6)
    assert [(each.law, each.outcome) for each in taps[:2]] == [("energetic", "no rebound")] * 2
    assert (len(taps), taps[2].law) == (3, "sustained")
    # The last touch is ill-conditioned: the wire's end grazes the bar.
    assert run.event_time("bar release", last=True, before=4e-3) == pytest.approx(2.95e-3, abs=1e-5)


def check_strike_ledger(run: Trajectory) -> None:
    """Momentum about the root, the energetic coefficient and Coulomb's law, at the angle of the strike."""
    strike = run.first_contact("workpart")
    assert strike is not None
    assert strike.outcome == "rebound"
    assert strike.compressive_work is not None
    assert strike.restitutive_work is not None
    assert strike.compressive_impulse is not None
    angle, (normal, tangential) = strike.angles[0], strike.impulse
    kick = 3.0 * (math.sin(angle) * normal + math.cos(angle) * tangential) / (0.027 * 8.387e-5)
    # Rounding of a dozen operations.
    assert strike.rates_after[0] - strike.rates_before[0] == pytest.approx(kick, rel=1e-12)
    assert strike.restitutive_work[0] == pytest.approx(
        -(0.42**2) * strike.compressive_work[0], rel=1e-11
    )
    # The lagging bristle slides forward all through compression, then back.
    assert strike.phases[0] == "compression slip"
    assert strike.velocity_before[1] > 0.0 > strike.velocity_after[1]
    assert abs(tangential) < 0.31 * normal


def lag(run: Trajectory) -> float:
    """How far the bristle is short of radial at the strike, degrees."""
    strike = run.first_contact("workpart")
    assert strike is not None
    return math.degrees(run.hub_angle[0] + run.hub_speed * strike.time - strike.angles[0])


def largest_retraction(run: Trajectory) -> float:
    strike = run.event_time("strike") or math.inf
    return -math.degrees(float(run.relative_angle[run.time <= strike].min()))


@pytest.fixture(scope="module", params=[simulate, simulate_reference], ids=["scene", "reference"])
def solve(request: pytest.FixtureRequest) -> Callable[..., Trajectory]:
    """Either way of simulating."""
    found: Callable[..., Trajectory] = request.param
    return found


@pytest.fixture(scope="module")
def cued(solve: Callable[..., Trajectory]) -> Trajectory:
    return solve(Tool())


@pytest.mark.parametrize("check", [check_strike, check_retraction, check_bar, check_strike_ledger])
def test_numbers_of_two_integrations(check: Callable[[Trajectory], None], cued: Trajectory) -> None:
    check(cued)


def largest_after(release: float, angle: float, rate: float) -> tuple[float, float]:
    """Return time and relative angle of the largest retraction in free flight from a release, by energy and quadrature.

    I alpha'^2 + k alpha^2 + m r_h L omega^2 (1 - cos alpha) is constant; the time is the integral of 1/alpha'.
    """
    tool = Tool()
    field = tool.bristle.mass * tool.hub.radius * tool.bristle.length * tool.hub.speed**2

    def squared(at: float) -> float:
        """Return the part of alpha'^2 that the potential energy takes, rad^2/s^2."""
        return (
            tool.belt.stiffness * at**2 + field * (1.0 - math.cos(at))
        ) / tool.bristle.inertia_about_root

    total = rate**2 + squared(angle)
    largest = brentq(lambda at: squared(at) - total, angle, -0.5 * math.pi, xtol=1e-15)
    # alpha = largest cos(u) takes the singularity from the integrand.
    slowness = lambda u: -largest * math.sin(u) / math.sqrt(total - squared(largest * math.cos(u)))  # noqa: E731
    return release + quad(slowness, 0.0, math.acos(angle / largest), epsabs=1e-15)[0], largest


@pytest.mark.parametrize("rounding", [0.0, 1e-15, -1e-15])
def test_a_run_ends_where_retraction_is_largest(
    solve: Callable[..., Trajectory], rounding: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before the bar the relative rate is zero but for rounding, of either sign: no retraction is largest there."""
    true = Chain.forces

    def rounded(chain: Chain, time: Any, *state: Any) -> Any:
        return true(chain, time, *state) + rounding * np.multiply.outer(
            np.cos(2e4 * time), chain.stiffness
        )

    monkeypatch.setattr(Chain, "forces", rounded)
    run = solve(Tool(), stop_after="largest retraction")
    assert (run.stop_reason, run.time[-1]) == (
        "requested event",
        run.event_time("largest retraction"),
    )
    release = run.at(run.contacts[-1].time + run.contacts[-1].duration, side="after")
    time, angle = largest_after(release.time, release.relative_angle, release.relative_rate)
    # The scene's accuracy, 1e-6; the rate there is that times the highest one, 1e3 rad/s.
    assert (run.time[-1], run.relative_angle[-1]) == pytest.approx((time, angle), rel=1e-6)
    assert run.relative_rate[-1] == pytest.approx(0.0, abs=1e-3)
    # Found as the numbers above; half a last digit, and as for the release of the wire from the bar.
    assert run.time[-1] == pytest.approx(3.1793e-3, abs=0.5e-7)
    assert math.degrees(run.relative_angle[-1]) == pytest.approx(-44.995, abs=5e-3)


def test_first_touch_is_where_geometry_puts_it(cued: Trajectory) -> None:
    """Triangle of hub, tip and bar's centre with sides R, S and reach (law of cosines)."""
    bar = Tool().bar
    tip = 0.0545
    reach = Tool().bar_reach
    assert bar is not None
    distance = math.hypot(bar.horizontal, bar.vertical)
    between = math.acos((distance**2 + tip**2 - reach**2) / (2.0 * distance * tip))
    direction = math.atan2(bar.horizontal, bar.vertical)
    # The scene's accuracy, 1e-6.
    assert cued.event_time("bar touch") == pytest.approx(
        (math.pi / 2.0 - direction - between) / 261.8, rel=1e-6
    )


def test_restitution_of_the_bar_gives_two_taps(solve: Callable[..., Trajectory]) -> None:
    tool = Tool()
    assert tool.bar is not None
    run = solve(replace(tool, bar=replace(tool.bar, restitution=0.42)), stop_after="strike")
    taps = [each for each in run.contacts if each.obstacle == "bar"]
    assert [each.outcome for each in taps] == ["rebound", "rebound"]
    for each in taps:
        # Frictionless and of one degree of freedom: the energetic coefficient is Newton's.
        assert each.velocity_after[0] == pytest.approx(-0.42 * each.velocity_before[0], rel=1e-12)
    strike = run.first_contact("workpart")
    assert strike is not None
    assert strike.rates_before[0] - 261.8 == pytest.approx(911.9, abs=0.05)
    # As for the inelastic bar.
    assert lag(run) == pytest.approx(3.31, rel=5e-3)


class TestCue:
    """Release from rest at 44.5 degrees, no bar."""

    def test_numbers(self, solve: Callable[..., Trajectory]) -> None:
        """With the rotating root's stiffening: half of the last digits of 1.4052 ms, 869.1 rad/s and 66.56 deg."""
        run = solve(Tool(bar=None, workpart=None), **RELEASE)
        time = run.event_time("highest relative speed")
        assert time == pytest.approx(1.4052e-3, abs=0.5e-7)
        assert run.relative_rate[-1] == pytest.approx(869.1, abs=0.05)
        # Eq. 2.1: the tip's lag at release, the hub's turn, the impact angle.
        lag_of_tip = math.atan2(0.027 * math.sin(RETRACTION), 0.0275 + 0.027 * math.cos(RETRACTION))
        assert time is not None
        assert math.degrees(lag_of_tip + 261.8 * time + GAMMA) == pytest.approx(66.56, abs=0.005)


class TestReturn:
    """Positions 5 to 11 of fig. 1.5: after the strike the bristle is thrown back, drags, and comes to rest on its belt."""

    def test_undamped_it_swings_on(self, solve: Callable[..., Trajectory]) -> None:
        """After the last contact Jacobi's integral stays: the speed comes back to its value at release."""
        run = solve(Tool())
        left = run.event_time("workpart release", last=True)
        assert left is not None
        free = run.time > left
        inertia = 8.387e-5 * 0.027**2 / 3.0
        centrifugal = 0.5 * 8.387e-5 * 0.0275 * 0.027 * 261.8**2
        jacobi = (
            0.5 * inertia * run.relative_rate**2
            + 0.5 * math.degrees(0.00041) * run.relative_angle**2
        )
        jacobi -= centrifugal * (np.cos(run.relative_angle) - 1.0)
        # The scene's accuracy, relative to the angle and rate of the largest swing.
        assert np.ptp(jacobi[free]) < 1e-5 * jacobi.max()


def test_accuracy_converges_on_one_answer() -> None:
    """Relative speed at the strike: each requested accuracy is met, against the reference at 1e-12."""
    reference = simulate_reference(Tool(), stop_after="strike", accuracy=1e-12).first_contact(
        "workpart"
    )
    assert reference is not None
    for accuracy in (1e-3, 1e-5, 1e-7, 1e-9):
        strike = simulate(Tool(), Settings(accuracy=accuracy), stop_after="strike").first_contact(
            "workpart"
        )
        assert strike is not None
        assert strike.rates_before[0] == pytest.approx(reference.rates_before[0], rel=accuracy)
        assert strike.time == pytest.approx(reference.time, rel=accuracy)
