"""A row of bristles: least pitches searched on simulated rows, and what a neighbour's touch does to the strike."""

import functools
import math
import re

import numpy as np
import pytest

from bristle_sim.parameters import Belt, Bristle, Neighbours, Tool, Workpart
from bristle_sim.render.bristle_figures import instants, neighbours_figure, pitches_to_draw
from bristle_sim.render.drawing import touch_places
from bristle_sim.render.tool_films import row_film
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies import least_pitch as module
from bristle_sim.studies.least_pitch import least_pitch, polyline_distance
from bristle_sim.studies.neighbours import neighbours

ALONE = {
    "relative_speed_at_contact": 877.09,
    "lag_deg_at_contact": 2.743,
    "normal_final_impulse": 2.751e-3,
}
"""The strike of a bristle without neighbours, which two integrations agree on."""


@functools.cache
def report(search="no", **row):
    return neighbours(Tool(), Neighbours(search=search, **row), Settings())


def rows(**options):
    return {each.name: each for each in report(**options).quantities}


@pytest.mark.nightly
def test_least_pitches_on_simulated_rows():
    """Theory to 0.05 deg, which is 16.4 deg to the strike and some 46 in the whole pass, undamped."""
    found = rows(search="yes")
    for name, known, within in (("to_strike", 16.4, 0.05), ("whole_pass", 46.0, 0.5)):
        row = found[f"least_pitch_{name}_deg"]
        assert row.simulated == pytest.approx(known, abs=within)
        assert abs(row.simulated - row.theory) <= 0.05
    own = found["least_pitch_to_own_strike_deg"]
    assert (
        found["least_pitch_to_strike_deg"].theory
        < own.theory
        == pytest.approx(own.simulated, abs=0.05)
    )


def test_a_bristle_that_touches_nobody_strikes_as_if_alone():
    """Ten times the accuracy of 1e-6, of a lag that is the difference of angles twenty times as large."""
    found = rows(pitch_deg=50.0)
    assert found["wire_contacts"].simulated == 0
    for name, value in ALONE.items():
        assert found[name].simulated == pytest.approx(
            value, rel=2e-4
        )  # of which four digits are known
        assert found[name].simulated == pytest.approx(
            found[name].theory, rel=2e-4 if "lag" in name else 1e-5
        )


def test_a_touch_that_changes_nothing_is_said_to_change_nothing():
    """Long bristles on a slow hub touch at 3.5 ms and strike at 12 ms, as a bristle alone does."""
    tool = Tool().replace(hub_speed="1500 rpm", bristle_length="40 mm")
    answer = neighbours(tool, Neighbours(search="no"), Settings(accuracy=1e-4)).answer
    assert "changes the next" not in answer
    assert "after a touch, which is the impulse of a bristle alone." in answer


@pytest.mark.nightly
def test_the_answer_names_pitches_and_what_a_touch_does():
    """Each number is that of the table; there is a row for each bristle, whose first one strikes as if alone."""
    found = report(search="yes")
    assert re.match(
        r"Wires of one plane touch each other at a spacing below 46\.13°; below 18\.69° a touch changes the next strike\."
        r" At 15° bristle 2 strikes with 0\.903 mN s, after a touch; a bristle alone has 2\.75 mN s\.",
        found.answer,
    )
    first, second = found.extra["bristles"]
    assert [each["bristle"] for each in (first, second)] == [1, 2]
    for name, value in ALONE.items():
        assert first[name] == pytest.approx(value, rel=2e-4)
    assert len(found.tables[0].rows) == 2
    assert (
        "At 50° bristle 2 strikes with 2.75 mN s, untouched until then;"
        in report(pitch_deg=50.0).answer
    )


def test_a_pass_without_a_strike():
    """The workpart is out of reach: the whole pass has a least pitch, the strike has none."""
    found = neighbours(
        Tool(workpart=Workpart(penetration=-0.01)), Neighbours(search="no"), Settings()
    )
    assert found.answer.endswith("At 15° bristle 2 does not strike: end of the planned time.")
    values = {each.name: each for each in found.quantities}
    assert found.outcome == "no contact"
    assert values["least_pitch_to_strike_deg"].theory is None
    assert values["least_pitch_whole_pass_deg"].theory > 0.0
    assert [words for words, _ in instants(found.subject)] == ["first touch", "last touch"]
    figure = neighbours_figure(
        found.subject, [5.0, 10.0], dict.fromkeys(ALONE, np.full(2, math.nan))
    )
    assert (
        sum(
            "no strike at any pitch" in text.get_text()
            for axes in figure.axes
            for text in axes.texts
        )
        == 3
    )


def test_a_pass_of_too_many_oscillations_is_not_searched(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(module, "MOST_SAMPLES", 10)
    found = neighbours(
        Tool(bar=None, workpart=None), Neighbours(search="no", pitch_deg=60.0), Settings()
    )
    assert any(
        "not searched, as the pass has too many oscillations" in each for each in found.remarks
    )


def test_wires_that_touch_at_every_pitch_are_not_searched():
    """Roots a quarter turn apart are sqrt(2) 27.5 mm = 38.9 mm from each other."""
    tool = Tool(bristle=Bristle(wire_diameter=0.04), bar=None, workpart=None)
    found = neighbours(tool, Neighbours(search="no", pitch_deg=150.0), Settings())
    assert any("not searched, as wires touch each other even" in each for each in found.remarks)
    assert len(pitches_to_draw(found.subject)) == 5


def test_a_row_that_the_foremost_bristle_stops_leaves_the_last_one_unjudged():
    """Friction in restitution locks the first strike: the second bristle, a pitch behind it, is on the bar then."""
    surface = Workpart(restitution_friction=1e8)
    tool = Tool(
        belt=Belt(stiffness=0.094),
        bristle=Bristle(mass=8.387e-5, wire_diameter=1e-9),
        workpart=surface,
    )
    found = neighbours(tool, Neighbours(search="no"), Settings())
    assert found.outcome == "no contact"
    assert all(each.ok is None for each in found.quantities if each.name in ALONE)
    assert any("(jam)" in each for each in found.remarks)


def test_a_long_row_has_as_little_time_as_two_bristles():
    """Each of twelve takes a sixth of the steps of each of two; those of a hundred iterations count twice."""
    steps = Settings(maximum_steps=1200, hub_turn=1000.0)
    for bristles, most in ((2, 1200), (12, 200)):
        with pytest.raises(ValueError, match="step budget spent after") as refused:
            neighbours(Tool(), Neighbours(search="no", bristles=bristles), steps)
        assert 0.5 * most <= int(re.search(r"after (\d+) engine", str(refused.value))[1]) < 2 * most


def test_wires_that_turn_with_the_hub_touch_at_their_roots():
    """2 r_h sin(beta/2) = d."""
    free = Tool(bar=None, workpart=Workpart(penetration=-0.01))
    run = simulate(free, Settings(hub_turn=1.0))
    found = least_pitch(run, 7.1e-4, until=run.time[-1], largest=math.radians(5.0))
    assert found == pytest.approx(
        2.0 * math.asin(7.1e-4 / (2.0 * 0.0275)), rel=1e-6
    )  # tolerance of the root search


def test_distances_of_bent_lines_against_points_on_them():
    chance = np.random.default_rng(5)
    lines = chance.normal(size=(2, 25, 3, 2))
    fraction = np.linspace(0.0, 1.0, 200)[:, np.newaxis]
    dense = [
        np.concatenate([line[:, i, np.newaxis] * (1.0 - fraction) + line[:, i + 1, np.newaxis] * fraction for i in (0, 1)], axis=1)
        for line in lines
    ]  # fmt: skip
    expected = np.linalg.norm(dense[0][:, :, np.newaxis] - dense[1][:, np.newaxis], axis=-1).min(
        axis=(1, 2)
    )
    found = polyline_distance(*(lines @ np.array([1.0, 1j])))
    # Points are at most half of 1/199 of a piece, some 5 long, away from the nearest ones.
    assert found == pytest.approx(expected, abs=0.03)
    assert (found <= expected + 1e-12).all()
    assert (found == 0.0).sum() > 2


class TestPictures:
    def test_where_wires_touch(self):
        """The end of one wire 0.7 mm above the middle of the other one: midway between the centre lines."""
        flat = np.array([[0.0, 0.0], [0.02, 0.0]])
        upright = np.array([[0.01, 0.03], [0.01, 7e-4]])
        assert touch_places([flat, upright], 7e-4) == pytest.approx(np.array([[10.0, 0.35]]))
        assert touch_places([upright, flat], 7e-4) == pytest.approx(np.array([[10.0, 0.35]]))
        assert touch_places([flat, upright + np.array([0.0, 1e-4])], 7e-4).shape == (0, 2)

    def test_the_film_marks_touches_and_says_how_fast_the_spoilt_strike_is(self):
        subject = report().subject
        scene = row_film(subject, width=160, height=120, duration=4.0)
        strike = subject.bristles[1].first_contact("workpart")
        touch = [
            each.time
            for each in subject.bristles[1].events
            if each.name == "wire touch" and each.time < strike.time
        ][-1]
        scene.show(float(scene.warp.film_time(touch)) + 0.01)
        assert len(scene.rings.get_xdata()) == 1
        scene.show(float(scene.warp.film_time(strike.time)) + 0.01)
        rate = strike.rates_before[0] - Tool().hub.speed
        assert scene.texts[0] == f"bristle 2 strikes at {rate:.0f} rad/s relative to the hub"


def test_the_reference_judges_the_last_bristle_of_a_row():
    """A touch between the wires leaves the row without theory; the independent row agrees within the tolerances."""
    found = neighbours(
        Tool(), Neighbours(search="no"), Settings(1e-4, hub_turn=2.3), with_reference=True
    )
    judged = [each for each in found.quantities if each.tolerance is not None]
    assert {each.name for each in judged} >= {"wire_contacts", "normal_final_impulse"}
    assert all(each.judge and each.judge[0] == "reference" and each.ok for each in judged)
