"""Same input, same bits; a run that was interrupted goes on as if it had not been, to the accuracy asked for."""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import math
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pymunk
import pytest

from bristle_sim.benchmarks.hard_cases import repeatability
from bristle_sim.benchmarks.hard_cases.case import HardCase
from bristle_sim.benchmarks.hard_cases.repeatability import bits, difference, guards
from bristle_sim.parameters import Bar, Belt, Bristle, Contact, Hub, Tool, Workpart
from bristle_sim.reference import simulate_reference
from bristle_sim.scenario_cli import main
from bristle_sim.scene.energetic_contact import EnergeticContact
from bristle_sim.scene.resume import resume, simulated_with
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import ContactAtEnd, Trajectory

SETTINGS = Settings(accuracy=1e-6)

TWICE = 2e-6
"""Two runs, each within the accuracy asked for."""


@pytest.mark.parametrize("case", repeatability.cases(full=False), ids=lambda case: case.name)
def test_promise(case: HardCase) -> None:
    finding = case.measure()
    assert finding.ok, finding.reached


def measured(name: str) -> bool:
    return next(case for case in repeatability.cases(full=False) if case.name == name).measure().ok


def test_a_run_that_depends_on_those_before_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The last bit of the accuracy asked for is enough."""
    asked = [SETTINGS.accuracy]

    def drifting(tool: Tool, settings: Settings, **others: object) -> Trajectory:
        asked.append(math.nextafter(asked[-1], 1.0))
        return simulate(tool, dataclasses.replace(settings, accuracy=asked[-1]), **others)  # type: ignore[arg-type]

    monkeypatch.setattr(repeatability, "simulate", drifting)
    assert not measured("energetic: again, after another run")
    assert not measured("four threads at a time")


def test_a_file_that_loses_a_bit_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    load = Trajectory.load

    def blurred(path: Path) -> Trajectory:
        found = load(path)
        return dataclasses.replace(found, rates=np.nextafter(found.rates, math.inf))

    monkeypatch.setattr(Trajectory, "load", blurred)
    assert not measured("energetic: saved and loaded")
    assert not measured("energetic: stopped at an event, loaded, gone on")


def test_going_on_from_another_state_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Off by a hundred times the accuracy, of which the strike after a release still sees a tenth."""

    def pushed(run: Trajectory) -> Trajectory:
        return resume(dataclasses.replace(run, rates=run.rates * (1.0 + 1e-4)))

    monkeypatch.setattr(repeatability, "resume", pushed)
    assert not measured("energetic: stopped at an event, loaded, gone on")


def test_bits_are_those_of_every_number_but_the_cost() -> None:
    run = simulate(Tool(bar=None), SETTINGS, stop_after="highest relative speed", start_relative_angle=-0.5)
    other = dataclasses.replace(run, cost=dataclasses.replace(run.cost, wall_s=9.0, cpu_s=9.0))
    assert bits(other) == bits(run)
    for name in ("time", "angles", "potential_energy"):
        array = getattr(run, name).copy()
        array.flat[-1] = math.nextafter(array.flat[-1], math.inf)
        assert bits(dataclasses.replace(run, **{name: array})) != bits(run)
    event = dataclasses.replace(run.events[0], time=math.nextafter(run.events[0].time, 1.0))
    assert bits(dataclasses.replace(run, events=(event, *run.events[1:]))) != bits(run)


def test_asserts_that_guard_are_found() -> None:
    source = (
        "assert x is not None\nassert isinstance(x, int)\nassert x > 0\nassert isinstance(x, int) and x\n"
        "assert x.pop() is not None\nassert go()\nassert x is None\n"
    )
    assert guards(source) == [3, 4, 5, 6, 7]


def bodies() -> list[tuple[float, float, float]]:
    """Rods that fall on a floor in a space of the engine's own."""
    space = pymunk.Space()
    space.gravity = (0.0, -9.81)
    floor = pymunk.Segment(space.static_body, (-5.0, -1.0), (5.0, -1.0), 1.0)
    rods = [pymunk.Body(1.0, 1.0 / 12.0) for _ in range(3)]
    shapes = [pymunk.Segment(body, (0.0, -0.5), (0.0, 0.5), 0.01) for body in rods]
    for index, body in enumerate(rods):
        body.position, body.angle = (2.0 * index - 2.0, 0.6), 0.3 * (index + 1)
    for shape, kind in zip((floor, *shapes), (1, 2, 2, 2), strict=True):
        shape.collision_type = kind
    space.add(floor, *rods, *shapes)
    contact = EnergeticContact(space, 1, 2, friction=0.4, restitution=0.6)
    for _ in range(400):
        contact.step(1e-3)
    return [(body.position.x, body.position.y, body.angle) for body in rods]


def test_impacts_in_another_space_repeat_too() -> None:
    first = repr(bodies())
    simulate(Tool(), SETTINGS, stop_after="bar touch")
    with ThreadPoolExecutor(2) as pool:
        assert [repr(found) for found in pool.map(lambda _: bodies(), range(2))] == [first, first]
    assert repr(bodies()) == first


SCRIPTS = Path(__file__).parents[2] / "scenarios"

ASKED = {
    "cue_and_impact": (),
    "oblique_impact": ("--set", "contact=compliant"),
    "single_pendulum": (),
    "double_pendulum": ("--set", "mass_ratio=700"),
}

PROGRAM = """
import runpy, sys
for name, *arguments in {asked}:
    script = runpy.run_path(f"{folder}/{{name}}.py")["SCENARIO"]
    assert not __debug__ or sys.exit("asserts are on")
    sys.modules["bristle_sim.scenario_cli"].main(script, ["--json", "-", *arguments])
    print("---")
"""


def documents(text: str) -> list[dict[str, object]]:
    """The scripts' JSON without what it cost in time."""
    found = [json.loads(each) for each in text.split("---") if each.strip()]
    for each in found:
        del each["cost"]["wall_s"]
    return found


def test_scripts_answer_the_same_in_other_processes(capsys: pytest.CaptureFixture[str]) -> None:
    """Without asserts and docstrings, and with other hashes."""
    asked = [(name, *arguments) for name, arguments in ASKED.items()]
    for name, *arguments in asked:
        spec = importlib.util.spec_from_file_location(name, SCRIPTS / f"{name}.py")
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        main(module.SCENARIO, ["--json", "-", *arguments])
        print("---")
    ours = documents(capsys.readouterr().out)
    done = subprocess.run(
        [sys.executable, "-OO", "-c", PROGRAM.format(asked=asked, folder=SCRIPTS)],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
        env=os.environ | {"PYTHONHASHSEED": "7"},
    )
    assert documents(done.stdout) == ours
    assert [each["scenario"] for each in ours] == list(ASKED)


TOOLS = {
    "plain": Tool(),
    "taps": Tool(bar=Bar(restitution=0.9, friction=0.1), belt=Belt(damping_ratio=0.02)),
    "contact in time": Tool(contact=Contact("compliant")),
    "bent": Tool(bristle=Bristle(knee_angle_deg=30.0), bar=Bar(friction=0.3)),
}


@pytest.mark.parametrize("name", TOOLS)
def test_going_on_from_anywhere(name: str) -> None:
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


def test_going_on_again_and_again() -> None:
    """From one event to the next; the clock, hub, ledger and cost go on."""
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


def test_the_state_of_contact_at_the_end_is_kept() -> None:
    """In flight before the bar, on it after the second touch, leaving it at the release and the workpart at the strike."""
    found = {stop: simulate(Tool(), SETTINGS, stop_after=stop).contact_at_end for stop in ("bar release", "strike")}
    assert simulate(Tool(), dataclasses.replace(SETTINGS, hub_turn=0.1)).contact_at_end == ContactAtEnd()
    assert simulate(Tool(), dataclasses.replace(SETTINGS, hub_turn=0.6)).contact_at_end == ContactAtEnd(
        "sustained contact", "bar"
    )
    assert found["bar release"] == ContactAtEnd("separating", "bar")
    assert found["strike"] == ContactAtEnd("separating", "workpart")


def test_the_next_touch_of_a_bar_that_still_holds() -> None:
    """Held after the second touch, the run goes on past the release, and ends where there is no third one."""
    held = resume(simulate(Tool(), SETTINGS, stop_after="bar touch"), stop_after="bar touch")
    assert held.first_contact("bar") is not None
    run = resume(held, stop_after="bar touch")
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


def test_further_than_asked_for_at_first() -> None:
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


def test_plain_steps_go_on_without_an_estimate() -> None:
    """To first order: each run is off by some steps' share of the motion until the strike, 450 steps in all."""
    steps = Settings(step=1e-5)
    run, whole = resume(simulate(Tool(), steps, stop_after="bar release")), simulate(Tool(), steps, stop_after="strike")
    ours, theirs = run.first_contact("workpart"), whole.first_contact("workpart")
    assert run.cost.error_estimate is None
    assert ours is not None
    assert theirs is not None
    assert ours.time == pytest.approx(theirs.time, rel=5e-3)
    assert ours.rates_before[0] == pytest.approx(theirs.rates_before[0], rel=5e-3)


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
        ("end", "hub_turn = 4.71239: more than the turn so far"),
        ("reference", "one that simulate() returned"),
        ("nothing", "one that simulate() returned"),
        ("stop", "stop_after = 'lunch': must be one of bar touch"),
        ("settings", "settings = 1e-06: Settings or None are allowed"),
        ("array", "stop_after = array([0., 0.]): must be one of"),
    ],
)
def test_what_cannot_go_on_says_why(name: str, words: str) -> None:
    with pytest.raises(ValueError, match=r"allowed|must be") as refusal:
        REFUSED[name]()
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)
