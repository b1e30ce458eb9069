"""A run that was interrupted resumes as if it had not been, to the requested accuracy."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from bristle_sim.parameters import Bar, Belt, Bristle, Contact, Hub, Tool, Workpart
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.resume import resume, simulated_with
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import Trajectory

SETTINGS = Settings(accuracy=1e-6)

TWICE = 2e-6
"""Two runs, each within the requested accuracy."""


def difference(one: Trajectory, other: Trajectory) -> float:
    """Return the largest relative difference of two passes: time, rate and impulse of the strike, all impulses, and the end."""
    pairs = [(one.time[-1], other.time[-1]), (one.angles[-1, 0], other.angles[-1, 0])]
    pairs += [(sum(each.impulse[0] for each in one.contacts), sum(each.impulse[0] for each in other.contacts))]
    strikes = [run.first_contact("workpart") for run in (one, other)]
    if strikes[0] is not None and strikes[1] is not None:
        first, second = strikes[0], strikes[1]
        pairs += [(first.time, second.time), (first.impulse[0], second.impulse[0])]
        pairs += [(first.rates_before[0], second.rates_before[0]), (first.rates_after[0], second.rates_after[0])]
    fastest = abs(other.rates).max()
    ended = abs(one.rates[-1, 0] - other.rates[-1, 0]) / fastest
    return max(abs(each) for each in (float(ended), *(float(a / b - 1.0) for a, b in pairs)))


TOOLS = {
    "plain": Tool(),
    "taps": Tool(bar=Bar(restitution=0.9, friction=0.1), belt=Belt(damping_ratio=0.02)),
    "contact in time": Tool(contact=Contact("compliant")),
    "bent": Tool(bristle=Bristle(knee_angle_deg=30.0), bar=Bar(friction=0.3)),
}


@pytest.mark.parametrize("name", TOOLS)
def test_resumed_from_anywhere(name: str) -> None:
    """Wherever the steps were spent: the same events in the same order, the same strike and end."""
    whole = simulate(TOOLS[name], SETTINGS)
    names = [event.name for event in whole.events]
    for share in (0.2, 0.5, 0.85):
        few = dataclasses.replace(SETTINGS, maximum_steps=int(share * whole.cost.steps))
        stopped = simulate(TOOLS[name], few)
        assert stopped.stop_reason == "step budget spent"
        found = resume(stopped, SETTINGS)
        assert [event.name for event in found.events] == names
        assert found.stop_reason == whole.stop_reason
        assert difference(found, whole) < TWICE
        # Release and turning points magnify an error of the motion, by up to a thousand times.
        times = np.array([[a.time, b.time] for a, b in zip(found.events, whole.events, strict=True)])
        assert np.abs(times[:, 0] - times[:, 1]).max() < 1e3 * TWICE * whole.time[-1]
        assert (np.diff(found.time) >= 0.0).all()


def test_resumed_again_and_again() -> None:
    """From one event to the next; clock, hub, contact records and cost continue."""
    whole, run = simulate(Tool(), SETTINGS), simulate(Tool(), SETTINGS, stop_after="bar touch")
    for stop in ("bar release", "bar touch", "bar release", "largest retraction", "strike", "workpart touch", None):
        before = run
        run = resume(run, stop_after=stop)
        if stop is not None:
            assert run.stop_reason is StopReason.EVENT
            assert run.event_time(stop, last=True) == pytest.approx(run.time[-1], rel=1e-15)
        assert run.time[-1] >= before.time[-1]
        assert run.cost.steps > before.cost.steps
        np.testing.assert_array_equal(run.angles[: before.time.size], before.angles)
    assert difference(run, whole) < TWICE
    assert [event.name for event in run.events] == [event.name for event in whole.events]
    # Angle and time of the hub come from sums of a few parts: some roundings.
    np.testing.assert_allclose(run.hub_angle, run.hub_angle[0] + run.hub_speed * run.time, rtol=0.0, atol=1e-14)
    assert sum(each.impulse[0] for each in run.contacts) == pytest.approx(
        sum(each.impulse[0] for each in whole.contacts), rel=TWICE
    )


def test_a_second_strike_is_a_touch() -> None:
    run = resume(simulate(Tool(), SETTINGS, stop_after="strike"), stop_after="strike")
    assert [event.name for event in run.events].count("strike") == 1
    assert run.stop_reason == "end of the planned time"
    again = resume(simulate(Tool(), SETTINGS, stop_after="strike"), stop_after="workpart touch")
    assert again.stop_reason is StopReason.EVENT
    assert again.event_time("workpart touch", last=True) == again.time[-1]
    assert again.event_time("workpart touch") == pytest.approx(again.time[-1], rel=1e-15)


def test_the_next_touch_of_a_bar_still_in_contact() -> None:
    """In contact after the second touch, the run resumes past the release, and ends where there is no third one."""
    in_contact = resume(simulate(Tool(), SETTINGS, stop_after="bar touch"), stop_after="bar touch")
    assert in_contact.first_contact("bar") is not None
    run = resume(in_contact, stop_after="bar touch")
    assert [event.name for event in run.events].count("bar touch") == 2
    assert run.stop_reason == "end of the planned time"


def test_what_never_happened_is_noted_once() -> None:
    bare = Tool(workpart=Workpart(penetration=-0.01))
    stopped = simulate(bare, SETTINGS, stop_after="bar touch")
    assert [event.name for event in stopped.events] == ["bar touch", "workpart not reached"]
    run = resume(stopped)
    assert [event.name for event in run.events].count("workpart not reached") == 1
    assert run.event_time("workpart not reached") == run.time[-1]
    assert run.event_time("bar not touched") is None


def test_a_contact_in_time_keeps_its_clock() -> None:
    deep = Tool(contact=Contact("compliant", 1e-4))
    run, whole = resume(simulate(deep, SETTINGS, stop_after="largest retraction")), simulate(deep, SETTINGS)
    ours, theirs = run.first_contact("workpart"), whole.first_contact("workpart")
    assert ours is not None
    assert theirs is not None
    assert ours.history is not None
    assert theirs.history is not None
    assert ours.history.time[0] == pytest.approx(ours.time, rel=1e-15)
    assert ours.history.time[-1] == pytest.approx(theirs.history.time[-1], rel=TWICE)


def test_a_hub_at_rest_sets_no_end() -> None:
    """The bristle swings on for as long as a run takes, with the energy it has."""
    still = Tool(hub=Hub(speed=0.0), bar=None, workpart=None)
    first = simulate(still, SETTINGS, start_relative_angle=-0.5)
    run = resume(first)
    assert run.time[-1] == pytest.approx(2.0 * first.time[-1], rel=1e-12)
    assert run.total_energy[-1] == pytest.approx(first.total_energy[0], rel=TWICE)


def test_further_than_requested_at_first() -> None:
    run = resume(simulate(Tool(), SETTINGS), dataclasses.replace(SETTINGS, hub_turn=6.0))
    assert run.hub_angle[-1] - run.hub_angle[0] == pytest.approx(6.0, rel=1e-12)
    assert simulated_with(run) == (Tool(), dataclasses.replace(SETTINGS, hub_turn=6.0))


def test_more_accurately_than_before() -> None:
    """The error is that of the first part, and the estimate counts both."""
    rough = simulate(Tool(), Settings(accuracy=1e-4), stop_after="bar release")
    run = resume(rough, SETTINGS)
    assert difference(run, simulate(Tool(), SETTINGS)) < 2e-4
    assert run.cost.error_estimate is not None
    assert rough.cost.error_estimate is not None
    assert run.cost.error_estimate > rough.cost.error_estimate


def test_plain_steps_resume_without_an_estimate() -> None:
    """To first order: each run is off by some steps' share of the motion until the strike, 450 steps in all."""
    steps = Settings(step=1e-5)
    run, whole = resume(simulate(Tool(), steps, stop_after="bar release")), simulate(Tool(), steps, stop_after="strike")
    ours, theirs = run.first_contact("workpart"), whole.first_contact("workpart")
    assert run.cost.error_estimate is None
    assert ours is not None
    assert theirs is not None
    assert ours.time == pytest.approx(theirs.time, rel=5e-3)
    assert ours.rates_before[0] == pytest.approx(theirs.rates_before[0], rel=5e-3)


STOPS = ("bar touch", "bar release", "largest retraction", "highest relative speed", "strike", "workpart release")


@pytest.mark.parametrize("name", TOOLS)
def test_resumed_from_a_file_as_from_memory(name: str, tmp_path: Path) -> None:
    """To the bit; and as not interrupted to the accuracy, as no state carries cached impulses and step sizes."""
    whole = simulate(TOOLS[name], SETTINGS)
    for stop in (each for each in STOPS[1::3] if whole.event_time(each) is not None):
        run = simulate(TOOLS[name], SETTINGS, stop_after=stop)
        run.save(tmp_path / "run.npz")
        ours, loaded = resume(run), resume(Trajectory.load(tmp_path / "run.npz"))
        for part in ("time", "angles", "rates", "normal_force"):
            np.testing.assert_array_equal(getattr(ours, part), getattr(loaded, part))
        assert repr(ours.contacts[-1].impulse) == repr(loaded.contacts[-1].impulse)
        assert difference(ours, whole) < TWICE


def test_resumed_from_another_state_is_noticed() -> None:
    """Off by a hundred times the accuracy, of which the strike after a release still sees a tenth."""
    run = simulate(Tool(), SETTINGS, stop_after="bar release")
    pushed = dataclasses.replace(run, rates=run.rates * (1.0 + 1e-4))
    assert difference(resume(pushed), simulate(Tool(), SETTINGS)) > TWICE


JAMMED = Tool(workpart=Workpart(friction=0.6), bar=Bar(friction=0.2), bristle=Bristle(knee_angle_deg=20.0))

REFUSED = {
    "jam": lambda: resume(simulate(JAMMED, SETTINGS)),
    "end": lambda: resume(simulate(Tool(), SETTINGS)),
    "reference": lambda: resume(simulate_reference(Tool(), stop_after="strike")),
    "nothing": lambda: resume(None),  # type: ignore[arg-type]
    "stop": lambda: resume(simulate(Tool(), SETTINGS, stop_after="strike"), stop_after="lunch"),
    "settings": lambda: resume(simulate(Tool(), SETTINGS, stop_after="strike"), 1e-6),  # type: ignore[arg-type]
    "array": lambda: resume(simulate(Tool(), SETTINGS, stop_after="strike"), stop_after=np.zeros(2)),  # type: ignore[arg-type]
}


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("jam", "trajectory that stopped for jam"),
        ("end", "hub_turn = 4.71239: must be more than the turn so far"),
        ("reference", "one that simulate() returned"),
        ("nothing", "one that simulate() returned"),
        ("stop", "stop_after = 'lunch': must be one of bar touch"),
        ("settings", "settings = 1e-06: must be Settings or None"),
        ("array", "stop_after = array([0., 0.]): must be one of"),
    ],
)
def test_what_cannot_be_resumed_says_why(name: str, words: str) -> None:
    with pytest.raises(ValueError, match="must be") as refusal:
        REFUSED[name]()
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)
