"""The picture of a pass: events and captions, the recorded centre line, lines to scale, texts in their places."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest
from matplotlib.text import Text

from bristle_sim import Bristle, Tool, Trajectory, simulate, simulate_reference
from bristle_sim.render.pass_figure import pass_figure
from bristle_sim.render.story import key_events, phase_at, phases, story_end
from bristle_sim.render.tool_films import pass_film
from bristle_sim.trajectory import Event
from swinging_bristle import END, STRIKE, artist, make_trajectory


@pytest.fixture(scope="module")
def run() -> Trajectory:
    return make_trajectory()


def test_a_wire_that_stays_on_the_bar_does_not_bounce_off_it():
    """It folds back on a bar too near to the hub, pressed on it to the end; with much friction it locks there at once."""
    pressed = Tool().replace(bar_horizontal=0.042, bar_vertical=0.005)
    run = simulate(pressed)
    (contact,) = [each for each in run.contacts if each.law == "sustained"]
    assert contact.time + contact.duration == pytest.approx(run.time[-1])
    assert "held back by the bar" in [each.caption for each in phases(run)]
    assert BOUNCING not in [each.caption for each in phases(run)]


def test_key_events_take_the_release_that_throws_and_the_first_of_the_rest():
    times = {
        "bar touch": (1.0, 2.0),
        "bar release": (1.5, 3.0),
        "strike": (4.0,),
        "workpart touch": (5.0, 6.0),
    }
    events = sorted(
        (Event(name, 1e-4 * time) for name in times for time in times[name]),
        key=lambda each: each.time,
    )
    chosen = [
        (event.name, round(1e4 * event.time))
        for event in key_events(make_trajectory(events=tuple(events)))
    ]
    assert chosen == [("bar touch", 1), ("bar release", 3), ("strike", 4), ("workpart touch", 5)]


THROWN = "released: the belt throws the tip"
RESTING = "held back by the bar"
BOUNCING = "bounces off the bar"


@pytest.mark.parametrize(
    ("names", "instants", "captions"),
    [
        (
            "touch release touch",
            (1, 2, 3),
            [THROWN, RESTING, RESTING, "off the bar", BOUNCING, "strike", "rebound"],
        ),
        (
            "touch release touch release",
            (1, 1, 2, 3),
            [THROWN, BOUNCING, BOUNCING, RESTING, None, None, "rebound"],
        ),
    ],
)
def test_captions_distinguish_rest_on_the_bar_from_bounces(
    names: str, instants: tuple[int, ...], captions: list[str]
):
    """A release in the instant of a touch is a bounce."""
    events = [
        Event(f"bar {name}", 1e-4 * at) for name, at in zip(names.split(), instants, strict=True)
    ]
    shown = phases(make_trajectory(events=(*events, Event("strike", STRIKE))), strike_shown=1e-4)
    times = (0.0, 1.2e-4, 1.5e-4, 2.5e-4, 4e-4, STRIKE, STRIKE + 2e-4)
    for time, caption in zip(times, captions, strict=True):
        assert caption in (None, phase_at(shown, time).caption)


def test_story_ends_soon_after_the_last_touch_or_with_the_run(run):
    assert story_end(run) == pytest.approx(1.12 * STRIKE)
    assert story_end(make_trajectory(events=())) == END


def test_the_swing_of_a_wire_that_the_hub_carries_along_is_not_labelled():
    # The closed form swings with the rate 770 sin(1100 t) rad/s: 0.85 rad/s after a microsecond, 770 a quarter period on.
    events = (
        Event("highest relative speed", 1e-6),
        Event("highest relative speed", 1.35e-3),
        Event("strike", STRIKE),
    )
    run = make_trajectory(events=events)
    assert [event.time for event in key_events(run)] == [1.35e-3, STRIKE]
    assert run.notable_events == events[1:]
    assert "highest relative speed 1.35 ms, strike" in repr(run)


def kinked(run: Trajectory, corners: int = 5) -> Trajectory:
    """The same run with a centre line that no tool has: four links at odd angles, and with its own velocities."""
    spread_out = np.linspace(0.0, 1.0, corners)[:, None] ** [1.0, 1.7]
    changed = {}
    for name in ("centre_line", "centre_line_velocity"):
        root = getattr(run, name)[:, :1]
        tip = getattr(run, name)[:, 1:]
        changed[name] = root + (0.8 * tip - root) * spread_out
    return dataclasses.replace(run, **changed)


def test_pictures_show_the_recorded_centre_line_and_nothing_of_their_own(run):
    """Of whatever shape: were any length, knee or angle of the tool used, wire and record would part."""
    odd = kinked(run)
    figure = pass_figure(odd, Tool(), until=END)
    for number, event in enumerate(key_events(odd), start=1):
        for wire in figure.findobj(lambda each, number=number: each.get_gid() == f"wire {number}"):
            # A wire that ends an interval is a sample; the others lie between two.
            assert wire.get_xydata() == pytest.approx(
                1e3 * odd.at(event.time).centre_line, abs=1e-9
            )
    path = np.concatenate(
        [
            artist(figure, name).get_xydata()
            for name in ("tip path until the strike", "tip path after the strike")
        ]
    )
    for sample in 1e3 * odd.tip:
        assert np.hypot(*(path - sample).T).min() < 1e-9  # mm: every recorded tip is on the path
    scene = pass_film(odd, Tool(), width=320, height=240, duration=1.0, until=END)
    for number in (10, 30, 60, 100):
        scene.show(float(scene.warp.film_time(odd.time[number])))
        shown = scene.wires[0].wire.get_xydata()
        # The warp's inverse is linear between 4001 nodes: an instant off by rounding, times 40 m/s.
        assert shown == pytest.approx(1e3 * odd.centre_line[number], abs=1e-6)
        assert scene.trail.get_xydata()[-1] == pytest.approx(1e3 * odd.tip[number], abs=1e-6)


def test_a_run_without_a_strike_or_obstacles_is_drawn():
    run = make_trajectory(events=(Event("highest relative speed", STRIKE),))
    bare = dataclasses.replace(run, contacts=())
    written = {
        each.get_text() for each in pass_figure(bare, Tool(bar=None, workpart=None)).findobj(Text)
    }
    assert any(each.startswith("no strike; the run ended:") for each in written)
    assert not {"bar", "workpart"} & written


@pytest.mark.parametrize("knee_angle_deg", [-30.0, 0.0, 45.0])
def test_a_bent_wire_touches_the_bar_and_strikes_the_workpart_in_the_picture(knee_angle_deg):
    """Scene and reference write the centre line each from its own kinematics; both have a sample at the strike."""
    tool = Tool(bristle=Bristle(knee_angle_deg=knee_angle_deg))
    run = simulate(tool, stop_after="strike")
    other = simulate_reference(tool, accuracy=1e-9, stop_after="strike")
    figure = pass_figure(run, tool)
    numbers = {event.name: number for number, event in enumerate(key_events(run), start=1)}
    struck = artist(figure, f"wire {numbers['strike']}").get_xydata()
    assert struck[-1] == pytest.approx(1e3 * run.tip[-1], abs=1e-9)
    assert struck[-1, 1] == pytest.approx(
        -1e3 * tool.workpart_depth, abs=1e-6
    )  # mm; where the touch is located
    touching = artist(figure, f"wire {numbers['bar touch']}").get_xydata()
    distance = min(
        _distance(1e3 * np.array(tool.bar.centre), *piece) for piece in itertools.pairwise(touching)
    )
    assert distance == pytest.approx(1e3 * tool.bar_reach, abs=1e-6)
    strike = run.first_contact("workpart")
    written = "\n".join(each.get_text() for each in figure.findobj(Text))
    assert f"tip arrives at {math.hypot(*strike.velocity_before):.2f} m/s" in written
    lengths = np.linalg.norm(np.diff(run.centre_line, axis=1), axis=-1)
    assert lengths.sum(axis=1) == pytest.approx(
        np.full(run.time.size, tool.bristle.length), rel=1e-12
    )
    before = [
        np.flatnonzero(each.time == each.first_contact("workpart").time)[0] for each in (run, other)
    ]
    # Accuracy 1e-6, magnified tenfold as elsewhere: of 55 mm and 40 m/s.
    for name, size in (("centre_line", 0.055), ("centre_line_velocity", 40.0)):
        mine, theirs = (
            getattr(each, name)[at] for each, at in zip((run, other), before, strict=True)
        )
        assert mine == pytest.approx(theirs, abs=1e-5 * size)


def _distance(point: np.ndarray, start: np.ndarray, end: np.ndarray) -> float:
    """Of a point from a straight piece of wire."""
    along = end - start
    fraction = min(max(float((point - start) @ along / (along @ along)), 0.0), 1.0)
    return float(np.hypot(*(point - start - fraction * along)))
