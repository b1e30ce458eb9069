"""The data behind the pictures of impacts: closed forms over impulse, angle, friction and mass ratio, and the scene's."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bristle_sim.comparison import Report
from bristle_sim.parameters import (
    Bar,
    Belt,
    Bristle,
    Contact,
    DoublePendulum,
    Hub,
    SinglePendulum,
    Strike,
    Surface,
    Tool,
)
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.contact_laws import EnergeticLaw
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings
from bristle_sim.studies.cue_places import BarPlace, formula_motion, full_pass
from bristle_sim.studies.cue_timing import cue_timing
from bristle_sim.studies.impact_families import (
    double_pendulum_panels,
    oblique_panels,
    single_pendulum_panels,
    with_own,
)
from bristle_sim.studies.impact_sweeps import Case, Sweep, sweep_panel
from bristle_sim.studies.impacts import Impacts, double_pendulum, oblique_impact, single_pendulum
from bristle_sim.studies.impulse_course import contact_inverse_mass, energetic_course, recorded_course, tip_velocity
from bristle_sim.studies.law_convergence import IDENTICAL_RODS, compliant_convergence, engine_energy, strike_by
from bristle_sim.studies.pendulum_sweeps import HEAVY_ROD, HEAVY_ROD_SURFACE, closed_form, heavy_rod_panel

ROUNDING = 1e-11
"""Relative: a few hundred operations on doubles, amplified by what cancels in K near a jam."""

GAMMA = math.radians(23.4)
BRISTLE = Chain((8.387e-5,), (0.027,), (-GAMMA,), (3.23 * 261.8,), 0.0275, 261.8, -GAMMA)
ROD = Chain((8.387e-5,), (0.027,), (-GAMMA,), (845.6,))
THREE_RODS = Chain((3.0, 1.5, 0.7), (0.4, 0.9, 0.6), (0.3, -0.5, -0.9), (-1.0, 2.0, 3.0))
PRESSED = Chain((5.0, 5.0), (1.0, 1.0), (math.radians(-30.0), math.radians(40.0)), (0.3, -0.1))
"""Its slip goes the way that friction would press the tip back: with enough of it in restitution, slip at rest."""
STICKY = Surface(friction=0.7, restitution=0.5)
ROUGH = Surface(friction=0.5, restitution=0.5)


def test_inverse_mass_of_one_rod() -> None:
    # A rod's tip weighs m/3 across the rod and nothing gives along it.
    across = np.array([math.sin(-GAMMA), math.cos(-GAMMA)])
    expected = 3.0 / ROD.masses[0] * np.outer(across, across)
    np.testing.assert_allclose(contact_inverse_mass(ROD), expected, rtol=ROUNDING)


def test_inverse_mass_of_identical_rods_has_the_printed_stick_threshold() -> None:
    inverse_mass = contact_inverse_mass(IDENTICAL_RODS)
    threshold = abs(inverse_mass[0, 1]) / inverse_mass[1, 1]
    assert threshold == pytest.approx(0.623401, abs=5e-7)  # eq. 2.90 at 20, 30 deg, to the digits given


@pytest.mark.parametrize(
    ("chain", "surface"),
    [
        (BRISTLE, Surface()),
        (IDENTICAL_RODS, ROUGH),
        (IDENTICAL_RODS, STICKY),
        (IDENTICAL_RODS, Surface(friction=0.1, restitution=0.5, restitution_friction=0.8)),
        (PRESSED, Surface(friction=0.1, restitution=0.5, restitution_friction=5.0)),
        (THREE_RODS, ROUGH),
    ],
)
def test_course_ends_where_the_scene_does(chain: Chain, surface: Surface) -> None:
    """The scene's K comes from the engine's bodies and joints, the course's from the rods' kinetic energy."""
    course = energetic_course(chain, surface)
    contact = strike(chain, surface, Contact("energetic"), Settings()).contact
    speed = math.hypot(*contact.velocity_before)
    np.testing.assert_allclose(tip_velocity(chain), contact.velocity_before, rtol=ROUNDING)
    np.testing.assert_allclose(
        (course.normal_velocity[-1], course.tangential_velocity[-1]), contact.velocity_after, atol=ROUNDING * speed
    )
    assert course.impulse[-1] == pytest.approx(contact.impulse[0], rel=ROUNDING)
    assert course.phases == contact.phases


@pytest.mark.parametrize(
    ("friction", "compressive", "final", "motions"),
    [
        (0.3, 0.45772963, 0.70237711, ("slip", "slip", "reverse slip")),
        (0.5, 0.37905577, 0.59199844, ("slip", "slip", "reverse slip")),
        (0.7, 0.32345998, 0.51199185, ("slip", "slip", "stick")),
    ],
)
def test_course_of_identical_rods(friction: float, compressive: float, final: float, motions: tuple[str, ...]) -> None:
    """Impulses from Zhang 2020, eqs. 2.74-2.89, evaluated on their own to eight digits."""
    course = energetic_course(IDENTICAL_RODS, Surface(friction=friction, restitution=0.5))
    assert course.compression_end == pytest.approx(compressive, abs=5e-9)
    assert course.impulse[-1] == pytest.approx(final, abs=5e-9)
    assert tuple(phase.split(" ", 1)[1] for phase in course.phases) == motions
    assert np.interp(course.compression_end, course.impulse, course.normal_velocity) == pytest.approx(0.0, abs=1e-15)
    assert np.interp(course.slip_stop, course.impulse, course.tangential_velocity) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(("chain", "surface"), [(BRISTLE, Surface()), (IDENTICAL_RODS, STICKY), (THREE_RODS, ROUGH)])
def test_course_returns_the_work_that_restitution_asks_for(chain: Chain, surface: Surface) -> None:
    course = energetic_course(chain, surface)
    steps = np.diff(course.impulse) * 0.5 * (course.normal_velocity[1:] + course.normal_velocity[:-1])
    compression = course.impulse[1:] <= course.compression_end * (1.0 + ROUNDING)
    ratio = -steps[~compression].sum() / steps[compression].sum()
    assert ratio == pytest.approx(surface.restitution**2, rel=ROUNDING)


def test_course_without_approach_is_a_point() -> None:
    course = energetic_course(Chain((1.0,), (1.0,), (-0.4,), (-1.0,)), Surface())
    assert course.impulse.tolist() == [0.0]
    assert course.phases == ()


@pytest.mark.parametrize(
    ("chain", "surface"), [(BRISTLE, Surface()), (IDENTICAL_RODS, ROUGH), (IDENTICAL_RODS, STICKY)]
)
def test_contact_resolved_in_time_lies_on_the_course(chain: Chain, surface: Surface) -> None:
    course = energetic_course(chain, surface)
    history = strike(chain, surface, Contact("compliant"), Settings()).contact.history
    assert history is not None
    recorded = recorded_course(history)
    # 24 stretches of half a wave of force or more: the trapezoidal rule leaves (pi/24)^2/12 of the impulse.
    trapezoidal = (math.pi / 24.0) ** 2 / 12.0
    assert recorded.impulse[-1] == pytest.approx(course.impulse[-1], rel=trapezoidal)
    for name in ("normal_velocity", "tangential_velocity"):
        expected = np.interp(recorded.impulse, course.impulse, getattr(course, name))
        change = np.ptp(getattr(course, name))
        # The same share of the impulse moves a velocity by at most its steepest slope, at most 3 times the mean here.
        np.testing.assert_allclose(getattr(recorded, name), expected, atol=3.0 * trapezoidal * change)


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


def rods(mass_ratio: float = 1.0) -> Impacts:
    found = double_pendulum(DoublePendulum(mass_ratio=mass_ratio), ROUGH, Contact(), Settings()).subject
    assert isinstance(found, Impacts)
    return found


def test_final_rates_over_the_mass_ratio() -> None:
    panel = double_pendulum_panels(rods())["rates over mass ratio"]
    first, second = panel.curves
    assert first.x[-1] == pytest.approx(1e4)
    # Eqs. 2.92-2.108 at n = 1e4, evaluated on their own to eight digits.
    assert first.theory[-1] == pytest.approx(-0.10002302, abs=5e-9)
    assert second.theory[-1] == pytest.approx(0.12120826, abs=5e-9)
    assert [mark.y for mark in panel.marks] == pytest.approx([-0.19893234, 0.22313679], abs=5e-9)
    for rod, curve in enumerate((first, second), start=1):
        for law, tolerance in (("energetic", 1e-11), ("compliant", 1e-5)):  # rounding; ten times the accuracy asked for
            x, simulated = curve.points[law]
            assert x.size == {"energetic": 9, "compliant": 4}[law]
            for ratio, value in zip(x, simulated, strict=True):
                chain = Chain((5.0 * ratio, 5.0), (1.0, 1.0), IDENTICAL_RODS.angles, IDENTICAL_RODS.rates)
                expected = getattr(closed_form(chain, ROUGH), f"final_rate_{rod}")
                assert value == pytest.approx(expected, rel=tolerance)


def test_bristle_as_a_double_pendulum() -> None:
    """Fig. 2.30: p_f at mu = 0.31 and n = 700, eq. 2.87 evaluated on its own."""
    found = closed_form(HEAVY_ROD, HEAVY_ROD_SURFACE).normal_final_impulse
    assert found == pytest.approx(2.4923689e-3, rel=5e-8)
    curve = next(each for each in heavy_rod_panel().curves if each.name == "$n$ = 700")
    # A heavy first rod is a hub of radius L: p_f of the bristle on it, to the share of the masses, 1/700.
    angle = math.radians(23.4)
    momentum = 8.387e-5 * 0.027 * (845.6 + 261.8) / 3.0
    for x, simulated in curve.points.values():
        s_1, s_2 = (math.sin(angle) + sign * x * math.cos(angle) for sign in (1.0, -1.0))
        expected = momentum * (s_2 + 0.42 * np.sqrt(s_1 * s_2)) / (s_1 * s_2)
        np.testing.assert_allclose(simulated, expected, rtol=1.0 / 700.0)


def kinetic_energy(rates: tuple[float, float]) -> float:
    """T of identical rods of 5 kg and 1 m at 20 and 30 deg, eq. 2.66."""
    q_1, q_2 = rates[0], 0.5 * rates[1]
    return 5.0 * (2.0 / 3.0 * q_1**2 + 2.0 / 3.0 * q_2**2 + math.cos(math.radians(10.0)) * q_1 * q_2)


def test_the_engine_creates_energy() -> None:
    energy = engine_energy(IDENTICAL_RODS, ROUGH, iterations=(10, 1000))
    before = kinetic_energy((-0.1, -0.2))
    # Rates measured with the bare engine, to three digits: energies to about twice 5e-4/0.2.
    assert energy.engine[0] == pytest.approx(kinetic_energy((-0.212, 0.249)) / before, rel=2e-2)
    assert energy.engine[1] == pytest.approx(kinetic_energy((-0.335, 0.363)) / before, rel=2e-2)
    assert energy.engine[1] > 1.0
    # The energetic law's rates, eqs. 2.74-2.89 evaluated on their own to eight digits.
    assert energy.energetic == pytest.approx(kinetic_energy((-0.19893234, 0.22313679)) / before, rel=1e-7)


def test_strike_by_a_law_is_the_strike_of_that_name() -> None:
    found, named = strike_by(THREE_RODS, ROUGH, EnergeticLaw()), strike(THREE_RODS, ROUGH, Contact(), Settings())
    assert found.rates_after == named.contact.rates_after
    assert found.kinetic_energy_ratio == pytest.approx(named.kinetic_energy_ratio, rel=1e-14)  # one sum, two orders


@pytest.mark.parametrize("mass_ratio", [1.0, 1e4])
def test_compliant_contact_converges_to_the_energetic_law(mass_ratio: float) -> None:
    case = compliant_convergence(mass_ratio, plain=(64, 512))
    order = math.log(case.plain_error[0] / case.plain_error[1]) / math.log(512 / 64)
    assert order > 0.95  # one, less what the first-order error's own curvature and the contact's length leave
    assert case.plain_error[1] < 4e-3  # first order, and 1e-3 at about 2000 steps measured with the bare engine
    assert (case.plain_steps >= (64, 512)).all()
    # Asked for 1e-2 ... 1e-6; the last within ten times of what was asked for.
    assert case.extrapolated_error[-1] < 1e-5
    assert case.extrapolated_error[0] < 1e-2


DAMPINGS = (0.0, 0.3, 1.0, 4.0)


@pytest.mark.parametrize("damping", DAMPINGS)
def test_formula_of_the_released_bristle_obeys_its_equation(damping: float) -> None:
    """I alpha'' + c alpha' + k alpha = 0 from rest, by finite differences."""
    tool = Tool(belt=Belt(damping_ratio=damping))
    rate = math.sqrt(tool.belt.stiffness / tool.bristle.inertia_about_root)
    time = np.linspace(0.0, 2.0 / rate, 4001)
    lag, speed = formula_motion(tool, 0.7, time)
    angle = -lag
    assert (lag[0], speed[0]) == (0.7, 0.0)
    step = time[1] - time[0]
    slope, acceleration = np.gradient(angle, step)[1:-1], np.gradient(speed, step)[1:-1]
    # Central differences leave (fastest rate x step)^2/6 = (8 x 5e-4)^2/6.
    np.testing.assert_allclose(slope, speed[1:-1], atol=5e-6 * 0.7 * rate * 8.0)
    residual = acceleration + 2.0 * damping * rate * speed[1:-1] + rate**2 * angle[1:-1]
    np.testing.assert_allclose(residual, 0.0, atol=5e-6 * 0.7 * rate**2 * 64.0)


def test_formula_is_a_cosine_without_damping() -> None:
    tool = Tool()
    rate = math.sqrt(tool.belt.stiffness / tool.bristle.inertia_about_root)
    time = np.linspace(0.0, 0.5 * math.pi / rate, 7)
    lag, speed = formula_motion(tool, 0.7, time)
    np.testing.assert_allclose(lag, 0.7 * np.cos(rate * time), atol=1e-15)
    assert speed[-1] == pytest.approx(0.7 * rate, rel=1e-14)


def test_formula_needs_a_belt() -> None:
    with pytest.raises(ValueError, match="stiffness = 0"):
        formula_motion(Tool(belt=Belt(0.0)), 0.7, 1e-3)


@pytest.fixture(scope="module")
def cued() -> Report:
    return cue_timing(Tool(), math.radians(44.5), Settings())


def test_bars_that_the_readings_need(cued: Report) -> None:
    places = cued.subject.places
    # From an integration of I alpha'' + k alpha + g sin alpha = 0, to hundredths of a degree.
    for reading, degrees in (("per_degree", 66.56), ("from_254_hz", 59.97)):
        simulated = places[reading].simulated
        assert simulated is not None
        assert math.degrees(simulated.direction) == pytest.approx(degrees, abs=0.005)
        distance = math.hypot(*Bar().centre)  # the printed bar touches at the same retraction, so S is the same
        assert math.hypot(simulated.horizontal, simulated.vertical) == pytest.approx(distance, rel=1e-9)
    # A quarter period on the belt alone: A + omega t_c + gamma, A and gamma from eq. 2.2.
    soft = places["per_radian"]
    assert soft.formula is not None
    inertia = 8.387e-5 * 0.027**2 / 3.0
    turn = 261.8 * 0.5 * math.pi / math.sqrt(0.00041 / inertia)
    assert math.degrees(soft.formula.direction) == pytest.approx(22.035 + math.degrees(turn) + 23.447, abs=0.01)


def test_full_passes_say_what_the_bars_give(cued: Report) -> None:
    """Over the bar that the release needs and over the one that stands, compared with the independent solution."""
    mine = cued.subject.places["per_degree"]
    for place, passed in ((mine.simulated, mine.passed), (BarPlace.of(Bar()), mine.passed_as_given)):
        tool = Tool(bar=Bar(horizontal=place.horizontal, vertical=place.vertical))
        run = simulate_reference(tool, accuracy=1e-9, stop_after="strike")
        (struck,) = (each for each in run.contacts if each.obstacle == "workpart")
        lag = -0.5 * math.pi + 261.8 * struck.time - struck.angles[0]
        # The lag is a small difference of large angles, good to 100 times the accuracy of 1e-6.
        assert passed.retraction == pytest.approx(lag, abs=1e-4)
        assert passed.relative_speed == pytest.approx(struck.rates_before[0] - 261.8, rel=1e-5)
    assert math.degrees(mine.passed.retraction) == pytest.approx(1.97, abs=0.005)  # the finding of README
    rows = [row for row in cued.extra["full_passes"] if row["belt_stiffness"] == Tool().belt.stiffness]
    assert [round(row["lag_deg_at_contact"], 2) for row in rows] == [1.97, 2.74]
    remarks = "\n".join(cued.remarks)
    assert "can be cued there" not in remarks
    assert "a full pass with the bar at 66.56 deg strikes 1.97 deg short of radial" in remarks


def test_a_pass_that_cannot_be_simulated_says_why() -> None:
    inside = BarPlace(0.01, 0.01, math.pi / 4.0)
    passed = full_pass(Tool(), Bar(), inside, Settings())
    assert passed.retraction is None
    assert str(passed).startswith("cannot be simulated (bar_radius")


def test_every_row_is_judged_by_the_same_side(cued: Report) -> None:
    """With the reference all relative differences are from it, the readings' too, and each is held to its tolerance."""
    assert all(row.reference is not None and row.ok for row in cued.quantities)
    bare = cue_timing(Tool(), math.radians(44.5), Settings(), with_reference=False)
    assert all(row.reference is None and row.ok is None for row in bare.quantities)


def test_print_belongs_to_the_printed_tool_alone() -> None:
    other = cue_timing(Tool(hub=Hub(speed=250.0)), math.radians(44.5), Settings(), with_reference=False)
    assert all(row.printed is None for row in other.quantities)


def test_the_released_wire_ends_on_the_bar_that_it_needs(cued: Report) -> None:
    """Released tip, bar and hub's centre are in line, and at the highest speed the tip is on the workpart (fig. 2.3)."""
    timing = cued.subject
    bar, tool = timing.places[timing.own].simulated, Tool()
    tip = timing.released[-1]
    towards = np.array([-bar.horizontal, -bar.vertical]) / math.hypot(bar.horizontal, bar.vertical)
    reach = math.hypot(bar.horizontal, bar.vertical) - tool.bar_reach
    np.testing.assert_allclose(tip, reach * towards, atol=1e-12)  # m; rounding and the event's instant
    assert timing.fastest[-1, 1] == pytest.approx(-tool.workpart_depth, abs=1e-8)  # radial to the accuracy, 1e-6


def test_bars_need_a_bar() -> None:
    with pytest.raises(ValueError, match="bar, workpart"):
        cue_timing(Tool(bar=None), 0.7, Settings())
