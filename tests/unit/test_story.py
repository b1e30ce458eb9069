"""Events that are labelled, and captions."""

from __future__ import annotations

import pytest

from bristle_sim.render.story import key_events, phase_at, phases, story_end
from bristle_sim.trajectory import Event, Trajectory
from swinging_bristle import END, STRIKE, make_trajectory


@pytest.fixture(scope="module")
def run() -> Trajectory:
    return make_trajectory()


def test_key_events_take_the_release_that_throws_and_the_first_of_the_rest():
    times = {"bar touch": (1.0, 2.0), "bar release": (1.5, 3.0), "strike": (4.0,), "workpart touch": (5.0, 6.0)}
    events = sorted((Event(name, 1e-4 * time) for name in times for time in times[name]), key=lambda each: each.time)
    chosen = [(event.name, round(1e4 * event.time)) for event in key_events(make_trajectory(events=tuple(events)))]
    assert chosen == [("bar touch", 1), ("bar release", 3), ("strike", 4), ("workpart touch", 5)]


def test_captions_tell_held_from_bounced():
    events = (Event("bar touch", 1e-4), Event("bar release", 2e-4), Event("bar touch", 3e-4), Event("strike", STRIKE))
    told = phases(make_trajectory(events=events), strike_shown=1e-4)
    captions = [phase_at(told, time).caption for time in (0.0, 1.5e-4, 2.5e-4, 4e-4, STRIKE, STRIKE + 2e-4)]
    thrown = "released: the belt throws the tip"
    assert captions == [thrown, "held back by the bar", thrown, "bounces off the bar", "strike", "rebound"]


def test_a_release_in_the_instant_of_a_touch_is_a_bounce():
    events = (
        Event("bar touch", 1e-4),
        Event("bar release", 1e-4),
        Event("bar touch", 2e-4),
        Event("bar release", 3e-4),
    )
    run = make_trajectory(events=(*events, Event("strike", STRIKE), Event("workpart release", STRIKE)))
    assert [event.name for event in key_events(run)] == ["bar touch", "bar release", "strike"]
    captions = [phase_at(phases(run, strike_shown=1e-4), time).caption for time in (1.5e-4, 2.5e-4, STRIKE + 2e-4)]
    assert captions == ["bounces off the bar", "held back by the bar", "rebound"]


def test_story_ends_soon_after_the_last_touch_or_with_the_run(run):
    assert story_end(run) == pytest.approx(1.12 * STRIKE)
    assert story_end(make_trajectory(events=())) == END


def test_the_swing_of_a_wire_that_the_hub_carries_along_is_not_labelled():
    # The closed form swings with the rate 770 sin(1100 t) rad/s: 0.85 rad/s after a microsecond, 770 a quarter period on.
    events = (Event("highest relative speed", 1e-6), Event("highest relative speed", 1.35e-3), Event("strike", STRIKE))
    run = make_trajectory(events=events)
    assert [event.time for event in key_events(run)] == [1.35e-3, STRIKE]
    assert run.notable_events == events[1:]
    assert "highest relative speed 1.35 ms, strike" in repr(run)
