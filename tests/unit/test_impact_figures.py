"""Pictures of impacts show what was computed, and never what is not there."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from bristle_sim.parameters import Contact, SinglePendulum, Strike, Surface
from bristle_sim.render.impact_figures import double_pendulum_figure, oblique_figure, single_pendulum_figure
from bristle_sim.render.style import save_figure
from bristle_sim.scene.build import Scene
from bristle_sim.settings import Settings
from bristle_sim.studies.double_pendulum_families import double_pendulum_panels
from bristle_sim.studies.impacts import Impacts, single_pendulum
from bristle_sim.studies.impulse_course import energetic_course
from bristle_sim.studies.law_convergence import engine_energy
from bristle_sim.studies.rod_families import oblique_panels, single_pendulum_panels
from impact_cases import HAND, ROUGH, STICTION, TRAPEZOIDAL, bristle, data, oblique, panel, rods, two_rods, words


@pytest.fixture(scope="module")
def strike() -> Impacts:
    return bristle()


@pytest.fixture(scope="module")
def pendulum() -> Impacts:
    return rods()


@pytest.fixture(scope="module")
def strike_figure(strike: Impacts) -> Figure:
    return oblique(strike)


@pytest.fixture(scope="module")
def pendulum_figure(pendulum: Impacts) -> Figure:
    return two_rods(pendulum)


def test_impulse_plane_shows_the_course_and_the_contact_resolved_in_time(
    strike: Impacts, strike_figure: Figure
) -> None:
    plane = panel(strike_figure, "a")
    course = energetic_course(strike.chain, strike.surface)
    assert "mN·s" in plane.get_xlabel()
    for name in ("normal_velocity", "tangential_velocity"):
        x, y = data(plane, name)
        np.testing.assert_allclose(x, course.impulse * 1e3)
        np.testing.assert_allclose(y, getattr(course, name))
        x, y = data(plane, f"{name}, resolved in time")
        assert x.size > 24
        np.testing.assert_allclose(
            y,
            np.interp(x, course.impulse * 1e3, getattr(course, name)),
            atol=3.0 * TRAPEZOIDAL * np.ptp(getattr(course, name)),
        )


def test_impulse_plane_shades_phases_and_marks_impulses(pendulum: Impacts, pendulum_figure: Figure) -> None:
    plane = panel(pendulum_figure, "a")
    course = energetic_course(pendulum.chain, pendulum.surface)
    shades = {patch.get_gid(): patch.get_extents().transformed(plane.transData.inverted()) for patch in plane.patches}
    assert list(shades) == ["compression slip", "restitution slip", "restitution reverse slip"]
    for name, start, end in zip(course.phases, course.impulse, course.impulse[1:], strict=False):
        assert (shades[name].x0, shades[name].x1) == pytest.approx((start * 1e3, end * 1e3), abs=1e-9)
    marks = {"p_c": course.compression_end, "p_s": course.slip_stop, "p_f": course.impulse[-1]}
    for name, impulse in marks.items():
        assert data(plane, name)[0][0] == pytest.approx(impulse * 1e3, rel=1e-12)


def test_impulses_that_fall_together_share_a_name(strike_figure: Figure) -> None:
    plane = panel(strike_figure, "a")
    assert "$p_c = p_s$" in words(plane)
    assert data(plane, "p_c p_s")[0][0] == pytest.approx(1.231668, rel=5e-7)  # p_cy, mN s, eq. 2.37


def test_oblique_figure_shows_families_and_the_impact_at_hand(strike_figure: Figure) -> None:
    rebound, by_angle, by_restitution = (panel(strike_figure, letter) for letter in "bcd")
    assert data(rebound, HAND) == pytest.approx((23.4, -0.539903), rel=2e-6)
    for axes in (by_angle, by_restitution):
        assert data(axes, HAND) == pytest.approx((0.31, 2.504205), rel=5e-7)
    # Without friction the rate after is -e* kappa/R - r_h/(L R) of that before at any angle.
    _, frictionless = data(rebound, "curve 0")
    radius = 0.0275 / 0.027
    np.testing.assert_allclose(frictionless, -(0.42 * (3.23 + radius) + radius) / 3.23, rtol=1e-12)
    assert data(by_angle, STICTION)[0][0] == pytest.approx(math.tan(math.radians(15.0)))
    assert "23.4°" in [text.get_text() for text in by_angle.get_legend().get_texts()]


def test_points_of_a_family_lie_on_its_curves(strike_figure: Figure) -> None:
    rebound = panel(strike_figure, "b")
    for name in ("0", "0.1", "0.31", "0.6", "1"):
        curve, points = data(rebound, f"curve {name}"), data(rebound, f"energetic {name}")
        # Linear between 81 places that lie closer where the curve is steep.
        np.testing.assert_allclose(points[1], np.interp(points[0], *curve), atol=2e-3)


def test_single_pendulum_figure_shows_the_formula() -> None:
    report = single_pendulum(SinglePendulum(), Surface(), Contact(), Settings())
    assert isinstance(report.subject, Impacts)
    figure = single_pendulum_figure(report.subject, single_pendulum_panels(report.subject))
    drag = 0.31 / math.tan(math.radians(23.4))
    expected = -0.42 * math.sqrt((1.0 - drag) / (1.0 + drag))
    assert data(panel(figure, "b"), HAND) == pytest.approx((23.4, expected), rel=1e-9)
    assert data(panel(figure, "c"), HAND) == pytest.approx((0.31, expected), rel=1e-9)


def test_double_pendulum_figure_shows_rates_impulses_and_energies(pendulum_figure: Figure) -> None:
    rates, impulses, energies = (panel(pendulum_figure, letter) for letter in "bcd")
    stars = [each.get_ydata()[0] for each in rates.get_lines() if each.get_gid() == HAND]
    assert stars == pytest.approx([-0.19893234, 0.22313679], abs=5e-9)  # eqs. 2.74-2.89 evaluated on their own
    assert data(rates, "rod 1 before the impact")[1][0] == -0.1
    assert data(impulses, STICTION)[0][0] == pytest.approx(math.tan(math.radians(23.4)))
    iterations, engine = data(energies, "engine")
    assert (iterations[0], iterations[-1]) == (1.0, 1000.0)
    assert engine[-1] > 1.0 > data(energies, "energetic")[1][0]
    assert energies.get_ylim()[1] > engine.max()


def test_figures_never_simulate(strike: Impacts, pendulum: Impacts, monkeypatch: pytest.MonkeyPatch) -> None:
    """Studies compute and figures draw: no scene can be built while they do."""
    panels, rates = oblique_panels(strike), double_pendulum_panels(pendulum)
    energy = engine_energy(pendulum.chain, ROUGH)

    def refuse(*_: object) -> None:
        pytest.fail("a figure builds a scene")

    monkeypatch.setattr(Scene, "__init__", refuse)
    oblique_figure(strike, panels)
    single_pendulum_figure(strike, {"rebound over angle": panels["rebound over angle"]})
    double_pendulum_figure(pendulum, rates, energy)


def test_panels_of_one_page_have_titles_of_their_own(strike_figure: Figure, pendulum_figure: Figure) -> None:
    for figure in (strike_figure, pendulum_figure):
        titles = [axes.get_title(loc="left").split("  ", 1)[1] for axes in figure.axes]
        assert len(set(titles)) == len(titles) == 4


def test_every_dotted_line_of_stiction_is_explained(strike_figure: Figure) -> None:
    for letter in "cd":
        assert f"dashed: {STICTION}" in words(panel(strike_figure, letter))


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_figures_are_written(pendulum_figure: Figure, tmp_path: Path, suffix: str) -> None:
    path = save_figure(pendulum_figure, tmp_path / f"impact{suffix}")
    assert path.stat().st_size > 10_000


def test_figures_of_what_does_not_happen_say_so(tmp_path: Path) -> None:
    away = oblique(bristle(Strike(speed_ratio=0.0)))
    assert "no ratio" in words(panel(away, "b"))
    resting = two_rods(rods(rate_1=0.0, rate_2=0.0))
    assert "no contact" in words(panel(resting, "a"))
    assert "no energy" in words(panel(resting, "d"))
    unresolved = rods()
    del unresolved.strikes["compliant"]
    names = {each.get_gid() for each in panel(two_rods(unresolved), "a").get_lines()}
    assert not any(name and "resolved" in name for name in names)
    for number, figure in enumerate((away, resting)):
        save_figure(figure, tmp_path / f"{number}.png")


@pytest.mark.parametrize("surface", [{"friction": 0.6}, {"restitution": 0.0}, {"restitution_friction": 0.9}])
def test_figures_of_an_impact_without_rebound(surface: dict[str, float], tmp_path: Path) -> None:
    figure = oblique(bristle(**surface))
    assert [patch.get_gid() for patch in panel(figure, "a").patches] == ["compression slip"]
    save_figure(figure, tmp_path / "stuck.png")
