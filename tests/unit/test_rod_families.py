"""Families of a rod's impacts are the closed forms, and simulated impacts lie on them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bristle_sim.parameters import Bristle, Contact, Hub, SinglePendulum, Strike, Surface
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings
from bristle_sim.studies.impacts import Impacts, oblique_impact, single_pendulum
from bristle_sim.studies.rod_families import Case, Sweep, oblique_panels, single_pendulum_panels, sweep_panel, with_own

ROUNDING = 1e-11
"""Relative: a few hundred operations on doubles, amplified by what cancels in K near a jam."""
GAMMA = math.radians(23.4)
BRISTLE = Chain((8.387e-5,), (0.027,), (-GAMMA,), (3.23 * 261.8,), 0.0275, 261.8, -GAMMA)
ROD = Chain((8.387e-5,), (0.027,), (-GAMMA,), (845.6,))


def test_with_own_takes_the_place_of_its_neighbours() -> None:
    assert with_own((0.0, 0.1, 0.3, 0.6), 0.31) == (0.0, 0.1, 0.31, 0.6)
    assert with_own((0.0, 0.1), 0.0) == (0.0, 0.1)
    assert with_own((0.2, 0.4), 0.9) == (0.2, 0.4, 0.9)


def pendulum_rebound(angle: np.ndarray, friction: float, restitution: float) -> np.ndarray:
    """Stronge 1990; no rebound for mu >= tan gamma."""
    drag = np.minimum(friction / np.tan(angle), 1.0)
    return -restitution * np.sqrt((1.0 - drag) / (1.0 + drag))


def over_friction(rod: Chain, family: str, values: tuple[float, ...], *, until_stiction: bool = True) -> Sweep:
    return Sweep("friction", 0.0, 1.0, family, values, until_stiction, Case.of(rod, Surface()))


def over_angle(rod: Chain, frictions: tuple[float, ...]) -> Sweep:
    return Sweep("impact_angle", math.radians(2.0), 0.5 * math.pi, "friction", frictions, base=Case.of(rod, Surface()))


def test_a_case_is_its_chain_and_surface() -> None:
    surface = Surface(0.2, 0.3, 0.7)
    for rod in (BRISTLE, ROD):
        case = Case.of(rod, surface)
        assert case.surface == surface
        found = strike(case.chain, surface, Contact(), Settings()).contact
        expected = strike(rod, surface, Contact(), Settings()).contact
        assert found.impulse == pytest.approx(expected.impulse, rel=ROUNDING)
        assert found.rates_after == pytest.approx(expected.rates_after, rel=ROUNDING)


def test_rebound_of_a_pendulum_over_the_angle() -> None:
    curves = sweep_panel("rebound_ratio", over_angle(ROD, (0.0, 0.31, 1.0))).curves
    assert [curve.name for curve in curves] == ["0", "0.31", "1"]
    for curve, friction in zip(curves, (0.0, 0.31, 1.0), strict=True):
        x, simulated = curve.points["energetic"]
        assert x.size >= 6
        # Near stiction the root magnifies rounding to its square root.
        np.testing.assert_allclose(curve.theory, pendulum_rebound(curve.x, friction, 0.42), atol=1e-7)
        np.testing.assert_allclose(simulated, pendulum_rebound(x, friction, 0.42), atol=1e-7)
    assert curves[2].points["energetic"][1][0] == pytest.approx(0.0, abs=1e-12)  # 2 deg sticks at mu = 1


def test_rebound_over_friction_agrees_with_rebound_over_angle() -> None:
    (curve,) = sweep_panel("rebound_ratio", over_friction(ROD, "impact_angle", (GAMMA,))).curves
    assert curve.name == "23.4°"
    for x, values in ((curve.x, curve.theory), curve.points["energetic"]):
        expected = [float(pendulum_rebound(np.array(GAMMA), mu, 0.42)) for mu in x]
        np.testing.assert_allclose(values, expected, rtol=1e-9)
    assert curve.x[-1] < math.tan(GAMMA)


def test_rebound_of_the_bristle_is_the_printed_one() -> None:
    """phi'_f/phi'(0) at the operating point, eq. 2.65 evaluated on its own."""
    (curve,) = sweep_panel("rebound_ratio", over_angle(BRISTLE, (0.31,))).curves
    at_rest = -0.0275 / (0.027 * 3.23)
    assert curve.theory[0] == pytest.approx(at_rest, rel=ROUNDING)  # stiction: the tip stays
    near = np.abs(curve.x - GAMMA).argmin()
    slope = (curve.theory[near + 1] - curve.theory[near - 1]) / (curve.x[near + 1] - curve.x[near - 1])
    assert curve.theory[near] + slope * (GAMMA - curve.x[near]) == pytest.approx(-0.539903, abs=1e-3)


def bristle_impacts(speed_ratio: float = 3.23, surface: Surface | None = None) -> Impacts:
    parts = (Hub(), Bristle(), Strike(speed_ratio=speed_ratio), surface or Surface(), Contact(), Settings())
    found = oblique_impact(*parts).subject
    assert isinstance(found, Impacts)
    return found


def test_families_of_a_bristle_mark_the_impact_at_hand() -> None:
    """p_f and the ratio at the operating point, eqs. 2.48 and 2.65 evaluated on their own to seven digits."""
    panels = oblique_panels(bristle_impacts())
    for name in ("impulse by angle", "impulse by restitution"):
        (mark,) = panels[name].marks
        assert (mark.x, mark.y) == pytest.approx((0.31, 2.504205e-3), rel=5e-7)
    (mark,) = panels["rebound over angle"].marks
    assert (mark.x, mark.y) == pytest.approx((GAMMA, -0.539903), rel=2e-6)


def test_no_rebound_ratio_at_rest() -> None:
    assert set(oblique_panels(bristle_impacts(0.0))) == {"impulse by angle", "impulse by restitution"}
    resting = single_pendulum(SinglePendulum(rate=0.0), Surface(), Contact(), Settings()).subject
    assert single_pendulum_panels(resting) == {}
    with pytest.raises(ValueError, match="rebound ratio"):
        sweep_panel("rebound_ratio", over_angle(Chain(ROD.masses, ROD.lengths, ROD.angles, (0.0,)), (0.1,)))


def test_friction_of_restitution_alone_bounds_no_impulse() -> None:
    """With mu_2 given, p_f stays finite beyond tan gamma = 0.43, and no line of stiction is drawn."""
    panel = oblique_panels(bristle_impacts(surface=Surface(restitution_friction=0.2)))["impulse by restitution"]
    assert panel.curves[0].x[-1] == 1.0
    assert panel.levels == ()
    assert panel.top is None


def test_final_impulse_over_friction() -> None:
    curves = sweep_panel("normal_final_impulse", over_friction(BRISTLE, "restitution", (0.0, 0.42))).curves
    # p_cy and p_fy without friction, from eqs. 2.37 and 2.48 evaluated on their own to seven digits.
    assert curves[0].theory[0] == pytest.approx(2.113995e-3, rel=5e-7)
    assert curves[1].theory[0] == pytest.approx(3.001874e-3, rel=5e-7)
    x, simulated = curves[1].points["energetic"]
    s_1, s_2 = (math.sin(GAMMA) + sign * x * math.cos(GAMMA) for sign in (1.0, -1.0))
    momentum = 8.387e-5 * (0.027 * 3.23 + 0.0275) * 261.8 / 3.0
    np.testing.assert_allclose(simulated, momentum * (s_2 + 0.42 * np.sqrt(s_1 * s_2)) / (s_1 * s_2), rtol=ROUNDING)


def test_final_impulse_ends_short_of_stiction() -> None:
    panel = sweep_panel("normal_final_impulse", over_friction(BRISTLE, "impact_angle", (0.3, 1.4)))
    for curve, angle in zip(panel.curves, (0.3, 1.4), strict=True):
        assert curve.x[-1] <= min(1.0, 0.9999 * math.tan(angle))
        assert np.isfinite(curve.theory).all()
    assert [level.value for level in panel.levels] == [math.tan(0.3)]  # that of 1.4 rad is beyond the curves
