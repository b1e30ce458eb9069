"""Signs of event functions on a motion at a constant rate, whose angle is the time."""

from functools import partial

import pytest

from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.events.changes import Changes
from bristle_sim.scene.events.functions import EventFunction
from bristle_sim.scene.events.touch_search import Interval
from bristle_sim.scene.integrate.extrapolation import Extrapolation
from bristle_sim.scene.integrate.stepping import Advance
from bristle_sim.scene.mechanism import Link, Mechanism, State


def reached(time: float) -> Advance:
    return Advance(State(time, (time,), (1.0,)), (0.0,), (), 0.0)


def interval(begin: float, end: float) -> Interval:
    return Interval(reached(begin).state, reached(end), lambda span: reached(begin + span))


def passes(angle: float) -> EventFunction:
    def beyond(at: Advance) -> float:
        return at.state.angles[0] - angle

    return EventFunction(f"past {angle}", beyond)


def test_an_event_after_the_first_one_of_an_interval_is_found_in_the_next() -> None:
    """Looked at first is the one at 0.8, which has not happened yet where the interval is cut at 0.5."""
    scene = Scene(Mechanism((Link.rod(1.0, 1.0),)), Effects())
    changes = Changes(scene, Extrapolation(1e-6), 1e-6)
    late, early = functions = [passes(0.8), passes(0.5)]
    changes.begin(reached(0.1).state, functions)
    known, whole = dict(changes.signs), interval(0.1, 1.0)
    find = partial(changes.find, before=None)
    first = find(late, whole)
    assert first is not None
    second = find(early, whole._replace(end=first))
    assert second is not None
    # Located to 1e-3 of the accuracy, of values below 1.
    assert second.state.time == pytest.approx(0.5, abs=1e-9)
    changes.return_to(known, functions, second, early)
    following = interval(second.state.time, 1.0)
    assert find(early, following) is None
    again = find(late, following)
    assert again is not None
    assert again.state.time == pytest.approx(0.8, abs=1e-9)
