"""What figures and films of impacts show is what was computed, on readable scales, and they never show what is not there."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from bristle_sim.parameters import (
    Bar,
    Bristle,
    Contact,
    DoublePendulum,
    Hub,
    SinglePendulum,
    Strike,
    Surface,
    Tool,
)
from bristle_sim.render.chain_drawing import ChainDrawing
from bristle_sim.render.contact_motion import ContactMotion, caption, contact_motion, stretches
from bristle_sim.render.convergence_figure import compliant_convergence_figure
from bristle_sim.render.cue_figure import cue_figure
from bristle_sim.render.impact_figures import double_pendulum_figure, oblique_figure, single_pendulum_figure
from bristle_sim.render.impact_video import ImpactScene, impact_video
from bristle_sim.render.prefixes import scale_for
from bristle_sim.render.style import save_figure
from bristle_sim.scene.build import Scene
from bristle_sim.scene.strike import Chain
from bristle_sim.scene.strike import strike as strike_chain
from bristle_sim.settings import Settings
from bristle_sim.studies.cue_timing import CueTiming, cue_timing
from bristle_sim.studies.impact_families import double_pendulum_panels, oblique_panels, single_pendulum_panels
from bristle_sim.studies.impacts import Impacts, double_pendulum, oblique_impact, single_pendulum
from bristle_sim.studies.impulse_course import energetic_course
from bristle_sim.studies.law_convergence import Convergence, engine_energy
from bristle_sim.studies.timed_contact import with_visible_contact

STICTION = "stiction, $\\mu$ = tan $\\gamma$"
HAND = "the impact at hand"
ROUGH = Surface(friction=0.5, restitution=0.5)
TRAPEZOIDAL = (math.pi / 24.0) ** 2 / 12.0
"""Relative error of an impulse summed by the trapezoidal rule over the 24 stretches of a record."""


def bristle(state: Strike | None = None, contact: Contact | None = None, **surface: float) -> Impacts:
    report = oblique_impact(Hub(), Bristle(), state or Strike(), Surface(**surface), contact or Contact(), Settings())
    assert isinstance(report.subject, Impacts)
    return report.subject


def rods(surface: Surface = ROUGH, **pendulum: float) -> Impacts:
    report = double_pendulum(DoublePendulum(**pendulum), surface, Contact(), Settings())
    assert isinstance(report.subject, Impacts)
    return report.subject


def oblique(impacts: Impacts) -> Figure:
    return oblique_figure(impacts, oblique_panels(impacts))


def two_rods(impacts: Impacts) -> Figure:
    energy = engine_energy(impacts.chain, impacts.surface) if any(impacts.chain.rates) else None
    return double_pendulum_figure(impacts, double_pendulum_panels(impacts), energy)


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


@pytest.fixture(scope="module")
def strike_motion(strike: Impacts) -> ContactMotion:
    return contact_motion(strike.strikes["compliant"].contact)


@pytest.fixture(scope="module")
def pendulum_motion(pendulum: Impacts) -> ContactMotion:
    return contact_motion(pendulum.strikes["compliant"].contact)


def panel(figure: Figure, letter: str) -> Axes:
    return next(axes for axes in figure.axes if axes.get_title(loc="left").startswith(f"$\\bf{{{letter}}}"))


def line(axes: Axes, name: str) -> Line2D:
    return next(each for each in axes.get_lines() if each.get_gid() == name)


def data(axes: Axes, name: str) -> tuple[np.ndarray, np.ndarray]:
    x, y = line(axes, name).get_data()
    return np.asarray(x, dtype=float), np.asarray(y, dtype=float)


def words(axes: Axes) -> str:
    return "\n".join(text.get_text() for text in axes.texts)


@pytest.mark.parametrize(
    ("largest", "factor", "unit"),
    [
        (1.2e-3, 1e3, "mN·s"),
        (0.592, 1e3, "mN·s"),
        (27.0, 1.0, "N·s"),
        (-4e6, 1e-6, "MN·s"),
        (1e-30, 1e15, "fN·s"),
        (0.0, 1.0, "N·s"),
        (math.inf, 1.0, "N·s"),
    ],
)
def test_scales_are_readable(largest: float, factor: float, unit: str) -> None:
    scale = scale_for(largest, "N·s")
    assert scale.unit == unit
    assert scale.factor == pytest.approx(factor, rel=1e-15)


def test_scale_of_almost_a_thousand_is_the_next_one() -> None:
    assert scale_for(999.9999999, "m").unit == "km"
    assert scale_for(999.0, "m").unit == "m"


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


def test_convergence_figure_shows_its_cases() -> None:
    steps = np.array([100.0, 1000.0])
    case = Convergence(3.0, steps, 1.0 / steps, steps[1:], np.array([1e-6]))
    (axes,) = compliant_convergence_figure([case]).axes
    assert data(axes, "plain 3")[1].tolist() == [1e-2, 1e-3]
    assert data(axes, "extrapolated 3")[1].tolist() == [1e-6]
    x, y = data(axes, "order one")
    assert math.log(y[1] / y[0]) / math.log(x[1] / x[0]) == pytest.approx(-1.0)


@pytest.fixture(scope="module")
def release() -> CueTiming:
    subject = cue_timing(Tool(), math.radians(44.5), Settings(), with_reference=False).subject
    assert isinstance(subject, CueTiming)
    return subject


def bars(axes: Axes) -> dict[str, np.ndarray]:
    """Centres of the bars drawn, m, by name."""
    return {
        patch.get_gid(): -1e-3 * np.array(patch.get_center())
        for patch in axes.patches
        if isinstance(patch, Circle) and patch.get_gid()
    }


def test_cue_figure_marks_both_cues_and_every_bar(release: CueTiming, tmp_path: Path) -> None:
    figure = cue_figure(release)
    retraction, speed, plan = (panel(figure, letter) for letter in "abc")
    inertia = 8.387e-5 * 0.027**2 / 3.0
    natural = math.sqrt(math.degrees(0.00041) / inertia)
    assert data(speed, "cue, quasi-static formula")[0][0] == pytest.approx(0.5e3 * math.pi / natural)
    assert data(speed, "highest, quasi-static formula")[1][0] == pytest.approx(math.radians(44.5) * natural)
    # From an integration of I alpha'' + k alpha + g sin alpha = 0, to the digits given.
    assert data(speed, "cue, simulated")[0][0] == pytest.approx(1.4052, abs=5e-5)
    assert data(speed, "highest, simulated")[1][0] == pytest.approx(869.1, abs=0.05)
    assert data(retraction, "retraction, simulated")[1][0] == pytest.approx(44.5)
    assert abs(data(retraction, "retraction, simulated")[1][-1]) < 1e-3
    sides = {f"{side} {reading}" for side in ("simulated", "formula") for reading in ("per_degree", "from_254_hz")}
    assert set(bars(plan)) == {"bar as given", *sides}  # the soft belt's are on the other side of the hub
    table = "\n".join(words(axes) for axes in figure.axes)
    assert all(degrees in table for degrees in ("66.56°", "59.97°", "65.93°", "114.33°", "1.97°", "2.74°"))
    assert "0.00041 N·m per radian *" in table
    save_figure(figure, tmp_path / "cue.png")


def test_cue_figure_draws_the_bar_where_the_keys_say_and_the_wire_on_the_bar_it_needs(release: CueTiming) -> None:
    moved = Bar(horizontal=0.052, vertical=0.018)
    plan = panel(cue_figure(dataclasses.replace(release, bar=moved)), "c")
    drawn = bars(plan)
    assert drawn["bar as given"] == pytest.approx([0.052, 0.018])
    needed = drawn["simulated per_degree"]
    outline = next(patch.get_xy() for patch in plan.patches if patch.get_gid() == "wire released") * 1e-3
    tip = 0.5 * (outline[1] + outline[2])
    assert np.hypot(*(tip + needed)) == pytest.approx(Tool().bar_reach, abs=1e-9)  # m; rounding, and 1e-6 of the turn
    (left, right), (bottom, top) = plan.get_xlim(), plan.get_ylim()
    for horizontal, vertical in drawn.values():
        assert left < -1e3 * horizontal < right
        assert bottom < -1e3 * vertical < top


def test_cue_figure_never_simulates(release: CueTiming, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("a figure must not simulate")

    for module in ("scene.tool", "studies.cue_timing", "studies.cue_places"):
        monkeypatch.setattr(f"bristle_sim.{module}.simulate", refuse)
    cue_figure(release)


def test_cue_figure_without_a_formula_or_a_cue(release: CueTiming) -> None:
    own = dataclasses.replace(release.places["per_degree"], simulated=None, formula=None, passed=None)
    places = {**release.places, "per_degree": own}
    bare = dataclasses.replace(release, places=places, formula=None, released=None, fastest=None)
    figure = cue_figure(bare)
    assert set(bars(panel(figure, "c"))) == {"bar as given", "simulated from_254_hz", "formula from_254_hz"}
    assert "none" in words(figure.axes[-1])


def test_motion_passes_the_record(pendulum: Impacts, pendulum_motion: ContactMotion) -> None:
    history = pendulum.strikes["compliant"].contact.history
    assert history is not None
    for part in stretches(history):
        inside = slice(part.start + 1, part.stop - 1)
        time = history.time[inside] - history.time[0]
        for name in ("normal_velocity", "tangential_velocity", "normal_force", "tangential_force"):
            expected = getattr(history, name)[inside]
            size = np.abs(getattr(history, name)).max()
            # Linear between 1500 instants; unloading is twice as quick as half a wave: (2 pi/1500)^2/8.
            found = np.interp(time, pendulum_motion.time, getattr(pendulum_motion, name))
            np.testing.assert_allclose(found, expected, atol=2.2e-6 * size)


def test_motion_before_and_after_is_free(strike: Impacts, strike_motion: ContactMotion) -> None:
    contact = strike.strikes["compliant"].contact
    start, end = strike_motion.time[0], strike_motion.time[-1]
    assert start < 0.0 < strike_motion.touch_end < end
    assert strike_motion.touch_end == pytest.approx(contact.duration)
    for instant, velocity in ((start, contact.velocity_before), (end, contact.velocity_after)):
        assert strike_motion.at("normal_force", instant) == 0.0
        assert strike_motion.at("normal_velocity", instant) == pytest.approx(velocity[0])
        assert strike_motion.at("tangential_velocity", instant) == pytest.approx(velocity[1])
    assert strike_motion.at("depth", start) == pytest.approx(contact.velocity_before[0] * -start)
    risen = strike_motion.at("depth", strike_motion.touch_end) - strike_motion.at("depth", end)
    assert risen == pytest.approx(contact.velocity_after[0] * (end - strike_motion.touch_end))


def test_motion_of_one_degree_of_freedom_is_on_one_line(strike_motion: ContactMotion) -> None:
    """The bristle's tip moves along (cos gamma, -sin gamma) all the time (eq. 2.24)."""
    depth = strike_motion.along * math.tan(math.radians(23.4))
    # Between samples depth and velocity are filled in each on its own, to second order: (pi/24)^2/12.
    np.testing.assert_allclose(strike_motion.depth, depth, atol=TRAPEZOIDAL * np.ptp(strike_motion.depth))


def test_phases_of_the_motions(strike_motion: ContactMotion, pendulum_motion: ContactMotion) -> None:
    assert [phase.caption for phase in strike_motion.phases] == [
        "the tip arrives",
        "compression slip",
        "restitution reverse slip",
        "rebound",
    ]
    assert [phase.caption for phase in pendulum_motion.phases][1:-1] == [
        "compression slip",
        "restitution slip",
        "restitution reverse slip",
    ]
    stop = pendulum_motion.slip_stop
    assert stop == pendulum_motion.phases[3].start
    arrival = pendulum_motion.tangential_velocity[0]
    assert abs(pendulum_motion.at("tangential_velocity", stop)) < 1e-6 * arrival
    # Friction opposes slip: its jump there is twice mu times the normal force.
    jump = np.diff(pendulum_motion.tangential_force).max()
    assert jump == pytest.approx(2.0 * 0.5 * pendulum_motion.at("normal_force", stop), rel=1e-6)


def test_motion_that_ends_in_stick_and_in_stiction() -> None:
    sticking = contact_motion(rods(Surface(friction=0.7, restitution=0.5)).strikes["compliant"].contact)
    assert sticking.phases[-2].caption == "restitution stick"
    stuck = contact_motion(bristle(friction=0.6).strikes["compliant"].contact)
    assert stuck.phases[-1].caption == "stiction: the tip stays"
    assert stuck.at("depth", stuck.time[-1]) == stuck.at("depth", stuck.touch_end)
    assert stuck.at("normal_force", stuck.time[-1]) > 0.0


def test_captions() -> None:
    assert caption("restitution reverse slip") == "restitution: the tip slips back"
    assert caption("rebound") == "rebound"


def test_no_motion_of_an_instantaneous_contact(strike: Impacts) -> None:
    with pytest.raises(ValueError, match="there is no motion in time"):
        contact_motion(strike.strikes["energetic"].contact)


def test_chain_is_drawn_to_scale_where_it_strikes() -> None:
    chain = Chain((1.0, 1.0), (2.0, 1.0), (0.0, -0.5 * math.pi), (1.0, 0.0))
    struck = strike_chain(chain, Surface(), Contact(), Settings())
    np.testing.assert_allclose(struck.centre_line, [(0.0, 0.0), (0.0, -2.0), (-1.0, -2.0)], atol=1e-15)
    axes = Figure().add_axes((0.0, 0.0, 1.0, 1.0))
    ChainDrawing(axes, struck, 0.0, 1.0)
    np.testing.assert_allclose(line(axes, "rods").get_xydata(), [(1.0, 2.0), (1.0, 0.0), (0.0, 0.0)], atol=1e-15)


def test_root_of_a_chain_on_a_hub_is_on_its_rim(strike: Impacts) -> None:
    """The radial bristle's root and tip, 23.4 deg before the workpart's normal."""
    gamma = math.radians(23.4)
    towards = np.array([-math.sin(gamma), -math.cos(gamma)])
    for struck in strike.strikes.values():
        np.testing.assert_allclose(struck.centre_line, np.outer([0.0275, 0.0545], towards), atol=1e-15)


@pytest.mark.parametrize("contact", [Contact(), Contact("compliant"), Contact("engine")])
def test_films_show_the_printed_compression_and_say_so(contact: Contact) -> None:
    """50 us of compression, millimetres and some ten newtons instead of nanometres and meganewtons."""
    shown = with_visible_contact(bristle(contact=contact))
    scene = ImpactScene(shown, width=320, height=180)
    assert scene.motion.compression_end == pytest.approx(5e-5, rel=1e-5)
    # Impulse over duration: the mean force of 2.8 mN s in some 100 us; the peak is at most pi/2 of it in either half.
    assert 20.0 < scene.motion.normal_force.max() < 100.0
    written = "\n".join(each.get_text() for each in scene.stage.figure.texts)
    assert "compression 50 µs (as printed, for the film)" in written


def test_films_show_a_requested_duration() -> None:
    shown = with_visible_contact(bristle(contact=Contact("compliant", 2e-5)))
    assert contact_motion(shown.strikes["compliant"].contact).touch_end == pytest.approx(2e-5, rel=0.02)  # see scene
    assert shown.timing == "contact_duration as requested"


def test_films_of_rods_too_small_or_slow_for_it_show_the_limit_and_say_so() -> None:
    tiny = oblique_impact(Hub(), Bristle(length=1e-5), Strike(), Surface(), Contact(), Settings()).subject
    slow = rods(rate_1=-1e-5, rate_2=-2e-5)
    for impacts in (tiny, slow):
        shown = with_visible_contact(impacts)
        assert shown.timing == "rigid-body limit"
        assert shown.strikes == impacts.strikes


def test_film_shows_the_motion(pendulum: Impacts, pendulum_motion: ContactMotion) -> None:
    scene = ImpactScene(pendulum, width=320, height=180, duration=4.0)
    stop = pendulum_motion.slip_stop
    assert stop is not None
    film_time = float(scene.warp.film_time(stop))
    scene.show(film_time)
    assert scene.caption.get_text() == "slip stops"
    for marker, name, factor in scene.panels.markers:
        (x,), (y,) = (np.asarray(values) for values in marker.get_data())
        instant = x / scene.panels.clock.factor
        assert instant == pytest.approx(stop, rel=1e-3)  # the warp is linear between 4001 nodes
        expected = pendulum_motion.at(name, instant) * factor
        assert y == pytest.approx(expected, abs=1e-9 * max(1.0, abs(expected)))
    scene.show(film_time + 0.6)
    assert scene.caption.get_text() == "restitution: the tip slips back"
    scene.show(scene.warp.film[-1])
    assert scene.caption.get_text() == "rebound"


def test_forces_in_the_film_follow_slip(pendulum: Impacts, pendulum_motion: ContactMotion) -> None:
    scene = ImpactScene(pendulum, width=320, height=180)
    close_up, stop = scene.close_up, pendulum_motion.slip_stop
    assert stop is not None
    sides = []
    for time in (0.9 * stop, stop + 0.1 * (pendulum_motion.touch_end - stop)):
        close_up.show(time)
        friction, normal = (each.get_path().get_extents() for each in (close_up.friction, close_up.normal))
        sides.append(0.5 * (friction.x0 + friction.x1 - normal.x0 - normal.x1))
        assert close_up.normal.get_visible()
    assert sides[0] < 0.0 < sides[1]
    close_up.show(float(pendulum_motion.time[-1]))
    assert not close_up.friction.get_visible()
    assert not close_up.normal.get_visible()


def test_ways_in_the_close_up_are_to_scale(strike: Impacts, strike_motion: ContactMotion) -> None:
    close_up = ImpactScene(strike, width=320, height=180).close_up
    lowest = []
    for time in (0.0, 0.5 * strike_motion.touch_end):
        close_up.show(time)
        outline = close_up.rod.get_xy()
        lowest.append(outline[outline[:, 1].argmin()])
    moved = (lowest[1] - lowest[0]) / close_up.scale
    assert close_up.stretch == 1.0
    expected = [strike_motion.at(name, 0.5 * strike_motion.touch_end) for name in ("along", "depth")]
    assert moved[0] == pytest.approx(expected[0], rel=1e-9)
    assert -moved[1] == pytest.approx(expected[1], rel=1e-9)


@pytest.mark.parametrize("state", [Strike(impact_angle_deg=1.0), Strike(impact_angle_deg=90.0)])
def test_films_of_grazing_and_head_on_strikes(state: Strike) -> None:
    scene = ImpactScene(bristle(state, friction=0.001), width=320, height=180, duration=1.0)
    assert len([bytes(frame) for frame in scene.frames(3)]) == 3
    assert math.isfinite(scene.close_up.scale)
    assert (scene.close_up.stretch > 1.0) == (state.impact_angle_deg < 45.0)


@pytest.mark.parametrize("suffix", [".gif", ".mp4"])
def test_film_is_written(strike: Impacts, tmp_path: Path, suffix: str) -> None:
    if suffix == ".mp4":
        pytest.importorskip("imageio_ffmpeg")
    path = impact_video(strike, tmp_path / f"impact{suffix}", fps=10.0, width=320, height=180, duration=0.5)
    assert path.stat().st_size > 1000
    assert [each.name for each in tmp_path.iterdir()] == [path.name]


def test_no_film_of_a_tip_that_does_not_approach(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no contact"):
        impact_video(rods(rate_1=1.0, rate_2=1.0), tmp_path / "impact.gif")
    with pytest.raises(ValueError, match=r"\.avi"):
        impact_video(rods(), tmp_path / "impact.avi")
    unresolved = dataclasses.replace(rods(), strikes={})
    with pytest.raises(ValueError, match="not resolved in time"):
        impact_video(unresolved, tmp_path / "impact.gif")
    assert not list(tmp_path.iterdir())
