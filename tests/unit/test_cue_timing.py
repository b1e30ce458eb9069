"""Cue timing: the release compared with formula and reference, the bars it needs, and whole passes over them."""

from __future__ import annotations

import dataclasses
import math
import re

import numpy as np
import pytest
from matplotlib.patches import Circle
from scipy.integrate import solve_ivp

from bristle_sim.comparison import Report
from bristle_sim.parameters import Bar, Belt, Hub, Tool
from bristle_sim.reference import simulate_reference
from bristle_sim.render.release_figures import cue_figure
from bristle_sim.settings import Settings
from bristle_sim.studies.cue_timing import cue_timing
from bristle_sim.theory.cueing import released_motion
from impact_cases import data, panel


@pytest.mark.parametrize("damping", [0.0, 0.3, 1.0, 4.0])
def test_formula_of_the_released_bristle_solves_its_equation(damping: float) -> None:
    """I alpha'' + c alpha' + k alpha = 0 from rest, by a library's integrator at a relative tolerance of 1e-11."""
    tool = Tool(belt=Belt(damping_ratio=damping))
    rate = math.sqrt(tool.belt.stiffness / tool.bristle.inertia_about_root)
    time = np.linspace(0.0, 2.0 / rate, 21)
    solution = solve_ivp(
        lambda _, state: (state[1], -(rate**2) * state[0] - 2.0 * damping * rate * state[1]),
        *((0.0, time[-1]), (-0.7, 0.0), "DOP853", time),
        rtol=1e-11,
        atol=1e-13,
    )
    lag, speed = released_motion(tool, 0.7, time)
    np.testing.assert_allclose(-lag, solution.y[0], atol=1e-9)
    np.testing.assert_allclose(speed, solution.y[1], atol=1e-9 * rate)


@pytest.fixture(scope="module")
def cued() -> Report:
    return cue_timing(Tool(), math.radians(44.5), Settings())


def test_bars_that_the_readings_need(cued: Report) -> None:
    readings = cued.subject.readings
    # From an integration of I alpha'' + k alpha + g sin alpha = 0, to hundredths of a degree.
    for reading, degrees in (("per degree", 66.56), ("from 254 Hz", 59.97)):
        simulated = readings[reading].simulated
        assert math.degrees(simulated.bar_direction) == pytest.approx(degrees, abs=0.005)
        # The printed bar touches at the same retraction, so S is the same.
        assert simulated.bar_distance == pytest.approx(math.hypot(*Bar().centre), rel=1e-9)
    # A quarter period on the belt alone: A + omega t_c + gamma, A and gamma from eq. 2.2.
    inertia = 8.387e-5 * 0.027**2 / 3.0
    turn = 261.8 * 0.5 * math.pi / math.sqrt(0.00041 / inertia)
    soft = math.degrees(readings["per radian"].formula.bar_direction)
    assert soft == pytest.approx(22.035 + math.degrees(turn) + 23.447, abs=0.01)


def test_full_passes_say_what_the_bars_give(cued: Report) -> None:
    """Over the bar that the release needs and over the one that stands, compared with the independent solution."""
    mine = cued.subject.readings["per degree"]
    places = (
        (mine.simulated.bar_horizontal, mine.simulated.bar_vertical),
        (Bar().horizontal, Bar().vertical),
    )
    for (horizontal, vertical), passed in zip(places, mine.passes, strict=True):
        tool = Tool(bar=Bar(horizontal=horizontal, vertical=vertical))
        run = simulate_reference(tool, accuracy=1e-9, stop_after="strike")
        (struck,) = (each for each in run.contacts if each.obstacle == "workpart")
        lag = -0.5 * math.pi + 261.8 * struck.time - struck.angles[0]
        # The lag is a small difference of large angles, good to 100 times the accuracy of 1e-6.
        assert math.radians(passed["lag_deg_at_contact"]) == pytest.approx(lag, abs=1e-4)
        assert passed["relative_speed_at_contact"] == pytest.approx(
            struck.rates_before[0] - 261.8, rel=1e-5
        )
    assert [
        row for row in cued.extra["full_passes"] if row["belt_stiffness"] == Belt().stiffness
    ] == [*mine.passes]
    assert cued.extra["bar_stands_at_deg"] == pytest.approx(65.93, abs=0.005)
    per_radian, per_degree, _ = cued.tables[0].rows
    assert per_radian[-1] == "no strike"
    assert per_degree[2:] == ("66.56", "67.43", "1.97", "2.74")
    assert cued.answer == (
        "A release that is fastest at the strike needs the bar at 66.56°, 0.869° less than the formula's 67.43° (printed: 65.93°); a whole pass with the bar"
        " there strikes 1.97° short of radial."
    )


@pytest.mark.parametrize(
    ("tool", "words"),
    [
        (
            Tool(belt=Belt(stiffness=0.00041)),
            "A release that is fastest at the strike needs the bar at 114.33°.* there has no cued strike",
        ),
        (Tool(belt=Belt(stiffness=0.0519)), r"strikes 0\.297° short of radial"),
    ],
)
def test_the_answer_changes_with_the_tool(tool: Tool, words: str) -> None:
    answer = cue_timing(tool, math.radians(44.5), Settings(1e-4), with_reference=False).answer
    assert re.search(words, answer)


def test_nothing_cues_a_bristle_that_nothing_moves() -> None:
    limp = Tool(belt=Belt(stiffness=0.0), hub=Hub(speed=0.0))
    report = cue_timing(limp, math.radians(44.5), Settings(1e-3), with_reference=False)
    assert report.answer == "No bar cues this bristle: its relative speed has no maximum."
    drawn = {
        each.get_gid()
        for each in panel(cue_figure(report.subject), "required bar positions").patches
    }
    assert not drawn & {"bar, simulated", "bar, formula"}


def test_every_row_is_judged_by_the_same_side(cued: Report) -> None:
    """With the reference all relative differences are from it, the readings' too, and each is held to its tolerance."""
    assert all(row.reference is not None and row.ok for row in cued.quantities)
    bare = cue_timing(Tool(), math.radians(44.5), Settings(), with_reference=False)
    assert all(row.reference is None and row.ok is None for row in bare.quantities)


def test_figure_draws_the_bar_where_the_keys_say_and_the_wire_on_the_bar_it_needs(
    cued: Report,
) -> None:
    moved = Bar(horizontal=0.052, vertical=0.018)
    plan = panel(cue_figure(dataclasses.replace(cued.subject, bar=moved)), "required bar positions")
    bars = [each for each in plan.patches if isinstance(each, Circle) and each.get_gid()]
    drawn = {each.get_gid(): -1e-3 * np.array(each.get_center()) for each in bars}  # m
    assert drawn["bar as given"] == pytest.approx([0.052, 0.018])
    tip = 1e-3 * np.transpose(data(plan, "wire released"))[-1]
    # 1e-6 of the turn.
    assert np.hypot(*(tip + drawn["bar, simulated"])) == pytest.approx(Tool().bar_reach, abs=1e-9)
    (left, right), (bottom, top) = plan.get_xlim(), plan.get_ylim()
    for horizontal, vertical in drawn.values():
        assert left < -1e3 * horizontal < right
        assert bottom < -1e3 * vertical < top
