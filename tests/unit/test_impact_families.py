"""Families of an impact at hand are the closed forms with its own parameters, simulated impacts lie on them, and all is drawn."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable

import numpy as np
import pytest

from bristle_sim.dissertation.impact_families import STEPS, convergence_panel, impact_families, with_own
from bristle_sim.dissertation.redrawn import Panel
from bristle_sim.parameters import Contact, DoublePendulum, SinglePendulum, Strike, Surface
from bristle_sim.render.impact_figure import impact_figure
from bristle_sim.scene.build import Scene
from bristle_sim.settings import Settings
from bristle_sim.studies.impacts import COMPLIANT_TOLERANCE, Impacts, double_pendulum, single_pendulum
from impact_cases import ROUGH, bristle, data, panel, rods

ANGLE, RESTITUTION = math.radians(40.1234), 0.61
"""Of a pendulum unlike the default, whose name in a key is as long as a name can be."""

COMPLIANT = Contact("compliant")
ENERGY = "energy after the engine's own contact"


def pendulum(contact: Contact = COMPLIANT, rate: float = -100.0) -> Impacts:
    surface = Surface(0.2, None, RESTITUTION)
    found = single_pendulum(SinglePendulum(2.0, 0.5, math.degrees(ANGLE), rate), surface, contact, Settings()).subject
    assert isinstance(found, Impacts)
    return found


def two_rods(contact: Contact = COMPLIANT) -> Impacts:
    found = double_pendulum(DoublePendulum(mass_ratio=20.0), ROUGH, contact, Settings()).subject
    assert isinstance(found, Impacts)
    return found


@functools.cache
def case(make: Callable[[], Impacts]) -> tuple[Impacts, dict[str, Panel]]:
    """An impact and its families, computed once."""
    impacts = make()
    return impacts, impact_families(impacts)


@pytest.fixture
def struck() -> dict[str, Panel]:
    return case(bristle)[1]


@pytest.fixture
def swung() -> dict[str, Panel]:
    return case(pendulum)[1]


@pytest.fixture
def hinged() -> dict[str, Panel]:
    return case(rods)[1]


def test_own_value_takes_the_place_of_the_nearest() -> None:
    assert with_own((0.0, 0.1, 0.3, 0.6), 0.31) == (0.0, 0.1, 0.31, 0.6)
    assert with_own((0.0, 0.1), 0.0) == (0.0, 0.1)
    assert with_own((0.2, 0.4), 0.9) == (0.2, 0.9)


def test_families_of_a_bristle_mark_the_impact_at_hand(struck: dict[str, Panel]) -> None:
    """p_f and the ratio at the operating point, eqs. 2.48 and 2.65 evaluated on their own to seven digits."""
    for name in ("final impulse, by impact angle", "final impulse, by restitution"):
        (mark,) = struck[name].marks
        assert (mark.x, mark.y) == pytest.approx((0.31, 2.504205e-3), rel=5e-7)
    (mark,) = struck["rebound ratio over the impact angle"].marks
    assert (mark.x, mark.y) == pytest.approx((math.radians(23.4), -0.539903), rel=2e-6)


def test_rebound_of_a_pendulum_of_ones_own(swung: dict[str, Panel]) -> None:
    """-e* sqrt[(1 - mu/tan gamma)/(1 + mu/tan gamma)], none from mu = tan gamma on (Stronge 1990)."""
    over_angle, over_friction = swung["rebound ratio over the impact angle"], swung["rebound ratio over friction"]
    assert [curve.name for curve in over_angle.curves] == ["0", "0.2", "0.31", "0.5", "1"]
    assert over_friction.curves[-1].name == "40.1234°"
    for law, tolerance in (("energetic", 1e-7), ("compliant", COMPLIANT_TOLERANCE)):  # the root magnifies rounding
        for curve, friction in zip(over_angle.curves, (0.0, 0.2, 0.31, 0.5, 1.0), strict=True):
            angle, found = curve.points[law]
            drag = np.minimum(friction / np.tan(angle), 1.0)
            np.testing.assert_allclose(found, -RESTITUTION * np.sqrt((1.0 - drag) / (1.0 + drag)), atol=tolerance)
        mu, found = over_friction.curves[-1].points[law]
        drag = mu / math.tan(ANGLE)
        np.testing.assert_allclose(found, -RESTITUTION * np.sqrt((1.0 - drag) / (1.0 + drag)), rtol=tolerance)


def test_final_impulse_of_a_pendulum_of_ones_own(swung: dict[str, Panel]) -> None:
    """m v/3 [1/s_1 + e*/sqrt(s_1 s_2)], s = sin gamma +- mu cos gamma (2.48), by restitution; ends short of tan gamma."""
    shown = swung["final impulse, by restitution"]
    for curve, restitution in zip(shown.curves, (0.2, 0.42, 0.61, 0.8), strict=True):
        s_1, s_2 = (math.sin(ANGLE) + sign * curve.x * math.cos(ANGLE) for sign in (1.0, -1.0))
        expected = 2.0 * 0.5 * 100.0 / 3.0 * (1.0 / s_1 + restitution / np.sqrt(s_1 * s_2))
        np.testing.assert_allclose(
            curve.theory, expected, rtol=1e-9
        )  # rounding, magnified 1e4 times at 0.9999 tan gamma
        mu, found = curve.points["energetic"]
        np.testing.assert_allclose(found, np.interp(mu, curve.x, expected), rtol=1e-9)
    assert [level.value for level in shown.levels] == pytest.approx([math.tan(ANGLE)])


def test_friction_of_restitution_alone_bounds_no_impulse() -> None:
    """With mu_2 given, p_f stays finite beyond tan gamma = 0.43, and no line of stiction is drawn."""
    shown = impact_families(bristle(restitution_friction=0.2, friction=0.9))["final impulse, by restitution"]
    assert shown.curves[0].x[-1] == pytest.approx(1.125)
    assert (shown.levels, shown.top) == ((), None)


def test_rates_over_the_mass_ratio(hinged: dict[str, Panel]) -> None:
    """At n = 1 and 1e4 with mu = 0.5, eqs. 2.74-2.108 evaluated on their own to eight digits."""
    expected = {"first": (-0.19893234, -0.10002302), "second": (0.22313679, 0.12120826)}
    for rod, (equal, heavy) in expected.items():
        shown = hinged[f"rate of the {rod} rod after impact"]
        (mark,) = shown.marks
        assert (mark.x, mark.y) == (1.0, pytest.approx(equal, abs=5e-9))
        curve = shown.curves[1]
        assert (curve.name, curve.x[-1]) == ("0.5", pytest.approx(1e4))
        assert curve.theory[-1] == pytest.approx(heavy, abs=5e-9)
        for law, tolerance in (("energetic", 1e-9), ("compliant", COMPLIANT_TOLERANCE)):
            n, found = curve.points[law]
            np.testing.assert_allclose(found, np.interp(n, curve.x, curve.theory), rtol=tolerance)
    impulse = hinged["final impulse over friction"]
    assert [curve.name for curve in impulse.curves] == ["$n$ = 1", "$n$ = 10", "$n$ = 100"]


def test_mass_ratio_at_its_end() -> None:
    """Curves end at 1e12, where theory does, which the impact at hand reaches."""
    shown = impact_families(rods(mass_ratio=1e12))["rate of the first rod after impact"]
    assert (shown.marks[0].x, shown.curves[0].x[-1]) == (pytest.approx(1e12), pytest.approx(1e12))


def kinetic_energy(rates: tuple[float, float]) -> float:
    """T of identical rods of 5 kg and 1 m at 20 and 30 deg, eq. 2.66."""
    q_1, q_2 = rates[0], 0.5 * rates[1]
    return 5.0 * (2.0 / 3.0 * q_1**2 + 2.0 / 3.0 * q_2**2 + math.cos(math.radians(10.0)) * q_1 * q_2)


def test_the_engine_creates_energy(hinged: dict[str, Panel]) -> None:
    (curve,) = hinged[ENERGY].curves
    count, engine = curve.points["engine"]
    before, found = kinetic_energy((-0.1, -0.2)), dict(zip(count, engine, strict=True))
    # Rates measured with the bare engine, to three digits: energies to about twice 5e-4/0.2.
    assert found[10] == pytest.approx(kinetic_energy((-0.212, 0.249)) / before, rel=2e-2)
    assert found[1000] == pytest.approx(kinetic_energy((-0.335, 0.363)) / before, rel=2e-2)
    assert found[1000] > 1.0
    # The energetic law's rates, eqs. 2.74-2.89 evaluated on their own to eight digits.
    assert curve.theory[0] == pytest.approx(kinetic_energy((-0.19893234, 0.22313679)) / before, rel=1e-7)


@pytest.mark.parametrize("make", [pendulum, two_rods])
@pytest.mark.parametrize("duration", [None, 1e-5])
def test_contact_of_plain_steps_converges_with_the_first_power(make, duration: float | None) -> None:
    shown = convergence_panel(make(Contact("compliant", duration)))
    (curve,) = shown.curves
    step, error = curve.points["compliant"]
    assert step == pytest.approx(1.0 / STEPS)
    # From 64 to 1024 steps the error's own curvature leaves a few hundredths; a longer contact turns the rods by 1e-3.
    order = math.log(error[0] / error[-1]) / math.log(step[0] / step[-1])
    assert order == pytest.approx(1.0, abs=0.05)
    assert float(curve.name.removeprefix("first order; observed: ")) == pytest.approx(order, abs=0.02)  # a fit to all
    if duration is None:
        (mark,) = shown.marks
        assert 0.0 < mark.y < 1e-5 < COMPLIANT_TOLERANCE  # ten times the requested accuracy


def test_a_contact_that_stops_at_the_surface_has_no_order() -> None:
    (curve,) = convergence_panel(bristle(contact=COMPLIANT, friction=0.6)).curves
    assert curve.name == "first order; all below 0.0001"


def test_no_families_without_contact_and_no_ratio_at_rest() -> None:
    assert impact_families(pendulum(rate=0.0)) == {}
    assert impact_families(rods(rate_1=0.0, rate_2=0.0)) == {}
    resting = impact_families(bristle(Strike(speed_ratio=0.0)))
    assert list(resting) == ["final impulse, by impact angle", "final impulse, by restitution"]


@pytest.mark.parametrize(("make", "count"), [(bristle, 5), (pendulum, 6), (rods, 5), (two_rods, 6)])
def test_a_page_holds_every_panel_and_simulates_nothing(make, count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    impacts, families = case(make)
    monkeypatch.setattr(Scene, "__init__", lambda *_: pytest.fail("a figure builds a scene"))
    figure = impact_figure(impacts, families)
    assert len(figure.axes) == count
    for letter, (title, shown) in zip("bcdefg", families.items(), strict=False):
        axes = panel(figure, letter)
        assert axes.get_title(loc="left").endswith(title)
        scale = {"(mN·s)": 1e3, "(N·s)": 1.0}.get(axes.get_ylabel().split()[-1], shown.y.factor)
        for curve in shown.curves:
            x, y = data(axes, f"curve {curve.name}")
            np.testing.assert_allclose(x, shown.x.factor * curve.x)
            np.testing.assert_allclose(y, scale * curve.theory, rtol=1e-12)
    figure.draw_without_rendering()
    page = figure.bbox
    for axes in figure.axes:
        box = axes.get_tightbbox()
        assert box is not None
        assert page.x0 <= box.x0
        assert box.x1 <= page.x1
        assert page.y0 <= box.y0
        assert box.y1 <= page.y1
