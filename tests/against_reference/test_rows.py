"""Rows of bristles that touch each other: passes that are the lone one's, and touches whose balances are made by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bristle_sim.parameters import Bristle, Tool
from bristle_sim.reference import simulate_row_reference
from bristle_sim.reference.mechanics import Chain
from bristle_sim.reference.run import AHEAD
from bristle_sim.scene.tool import simulate, simulate_row
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import Trajectory

ACCURACY = 1e-6

SHORT = Settings(accuracy=ACCURACY, hub_turn=1.6)

ELASTIC = {"neighbour_friction": 0.0, "neighbour_restitution": 1.0}


def row(bristles: int, pitch_deg: float, tool: Tool | None = None, **changes: float) -> tuple[Trajectory, ...]:
    surface = ELASTIC | changes
    return simulate_row(tool or Tool(), SHORT, bristles=bristles, pitch=math.radians(pitch_deg), **surface)


@pytest.mark.parametrize("links", [1, 2])
def test_wide_apart_each_pass_is_the_lone_one(links: int) -> None:
    """The lone pass, a pitch of the hub's turn later; ten times the requested accuracy."""
    tool = Tool(bristle=Bristle(links=links))
    lone = simulate(tool, SHORT)
    runs = row(2, 50.0, tool)
    assert [each.stop_reason for each in runs] == ["end of the planned time"] * 2
    for number, run in enumerate(runs):
        later = number * math.radians(50.0) / 261.8
        assert run.event_time("wire touch") is None
        for name in ("bar touch", "strike"):
            expected = lone.event_time(name)
            found = run.event_time(name)
            assert found is not None
            assert expected is not None
            assert found - later == pytest.approx(expected, rel=10.0 * ACCURACY)
        first, second = run.first_contact("workpart"), lone.first_contact("workpart")
        assert first is not None
        assert second is not None
        assert first.impulse == pytest.approx(second.impulse, rel=100.0 * ACCURACY)
        instants = np.linspace(1e-3, 4e-3, 20)
        assert run.at(instants + later).relative_angle == pytest.approx(
            lone.at(instants).relative_angle, abs=10.0 * ACCURACY
        )


def test_two_wires_that_bend_are_on_the_bar_at_once() -> None:
    """Each is released by itself, and strikes as the lone one does, a pitch later; rates relative to some 1e3 rad/s."""
    pitch, tool = math.radians(25.3), Tool(bristle=Bristle(links=2))
    lone = simulate(tool, stop_after="strike").contacts[-1]
    for number, run in enumerate(simulate_row(tool, bristles=2, pitch=pitch, stop_after="strike", **ELASTIC)):
        strike = run.first_contact("workpart")
        assert strike is not None
        assert strike.time - number * pitch / 261.8 == pytest.approx(lone.time, rel=10.0 * ACCURACY)
        assert strike.rates_before == pytest.approx(lone.rates_before, rel=0.0, abs=10.0 * ACCURACY * 1e3)


def test_one_bristle_is_the_lone_one_to_the_last_digit() -> None:
    (run,), lone = row(1, 0.0), simulate(Tool(), SHORT)
    assert np.array_equal(run.angles, lone.angles)
    assert run.events == lone.events


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_a_touch_of_neighbours_is_one_impact_of_both(friction: float) -> None:
    """Equal impulses; I times the change of each rate is the impulse's moment about the root, of geometry made anew.

    An elastic impact without friction keeps the energy.
    """
    runs = row(2, 10.0, neighbour_friction=friction)
    touches = [next(each for each in run.contacts if each.obstacle == "wire") for run in runs]
    assert touches[0].time == touches[1].time == runs[0].event_time("wire touch") == runs[1].event_time("wire touch")
    assert touches[0].impulse == touches[1].impulse
    bristle, inertia = Tool().bristle, Tool().bristle.inertia_about_root
    roots = [-math.pi / 2.0 + 261.8 * touches[0].time - number * math.radians(10.0) for number in range(2)]
    angles = [each.angles[0] for each in touches]
    places = [0.0275 * np.array([math.sin(root), -math.cos(root)]) for root in roots]
    lines = [0.027 * np.array([math.sin(angle), -math.cos(angle)]) for angle in angles]
    # The end of the bristle that the bar holds back is on the follower's flank.
    end = places[0] + lines[0]
    along = lines[1] / 0.027
    foot = places[1] + ((end - places[1]) @ along) * along
    normal = (end - foot) / np.hypot(*(foot - end))
    assert np.hypot(*(foot - end)) == pytest.approx(bristle.wire_diameter, rel=ACCURACY)
    push, rub = touches[0].impulse
    impulse = push * normal + rub * np.array([normal[1], -normal[0]])
    contact = end - 0.5 * bristle.wire_diameter * normal
    for each, place, sign in zip(touches, places, (1.0, -1.0), strict=True):
        arm = contact - place
        moment = sign * (arm[0] * impulse[1] - arm[1] * impulse[0])
        assert inertia * (each.rates_after[0] - each.rates_before[0]) == pytest.approx(moment, rel=ACCURACY)
    if friction:
        assert abs(rub) == pytest.approx(friction * push, rel=1e-9)
    else:
        assert touches[0].velocity_after[0] == pytest.approx(-touches[0].velocity_before[0], rel=1e-9)


def test_wires_that_stay_in_contact() -> None:
    """Inelastic neighbours press on each other for a while; their impulses on each other are equal and they do not overlap."""
    damped = replace(Tool(), belt=replace(Tool().belt, damping_ratio=0.05))
    runs = row(2, 10.0, damped, neighbour_friction=0.3, neighbour_restitution=0.0)
    lasting = [[each for each in run.contacts if (each.obstacle, each.law) == ("wire", "sustained")] for run in runs]
    assert lasting[0]
    for first, second in zip(*lasting, strict=True):
        assert first.impulse == second.impulse
        assert first.impulse[0] > 0.0
    assert runs[0].event_time("wire release") is not None
    assert np.array_equal(runs[0].time, runs[1].time)


@pytest.mark.parametrize("accuracy", [1e-7, 1e-11])
def test_wires_that_the_bar_folds_flat_on_each_other_jam(accuracy: float) -> None:
    """Parallel, the wires would touch at their roots, where no force turns them, and the hub turns on."""
    row = {"bristles": 2, "pitch": math.radians(1.6), "neighbour_friction": 0.31, "neighbour_restitution": 0.42}
    scene, reference = simulate_row(Tool(), SHORT, **row), simulate_row_reference(Tool(), accuracy=accuracy, **row)
    for runs in (scene, reference):
        assert [run.stop_reason for run in runs] == [StopReason.JAM] * 2
        assert runs[0].angles[-1] == pytest.approx(runs[1].angles[-1], abs=10.0 * ACCURACY)
    # A step of the reference that fails within so many radians of its fastest motion is the jam.
    early = AHEAD / Chain.of(Tool(), 0.0).fastest_rate
    assert reference[0].time[-1] == pytest.approx(scene[0].time[-1], abs=early)


def test_records_are_of_the_bristles_that_take_part() -> None:
    """Three in a row: the foremost and the last do not touch each other."""
    runs = row(3, 12.0)
    for run in runs:
        assert run.angles.shape[1] == 1
        assert all(len(each.angles) == 1 for each in run.contacts)
    partners = [{each.neighbour for each in run.contacts if each.obstacle == "wire"} for run in runs]
    assert partners == [{2}, {1, 3}, {2}]
    times = [{each.time for each in run.events if each.name == "wire touch"} for run in runs]
    assert times[0] | times[2] == times[1]


def test_refusals() -> None:
    with pytest.raises(ValueError, match=r"^pitch = 0\.01: must be one at which bristles are clear of each other"):
        simulate_row(Tool(), bristles=2, pitch=0.01, **ELASTIC)
    with pytest.raises(ValueError, match=r"^bristles = 0\.0: must be a whole number from 1 to 100"):
        simulate_row(Tool(), bristles=0, pitch=0.1, **ELASTIC)


@pytest.mark.parametrize("pitch", [0.0, 0.01])
def test_wires_in_each_other_at_the_start_are_refused(pitch: float) -> None:
    """Also where they coincide, and no direction is the normal's."""
    with pytest.raises(ValueError, match="must be one at which bristles are clear of each other at the start"):
        simulate_row(Tool(), bristles=2, pitch=pitch, neighbour_friction=0.0, neighbour_restitution=1.0)


@pytest.mark.parametrize("bristles", [2.0, True, 0])
def test_a_number_of_bristles_is_a_whole_one(bristles: int) -> None:
    with pytest.raises(ValueError, match=f"bristles = {bristles}: must be a whole number"):
        simulate_row_reference(Tool(), bristles=bristles, pitch=0.3)
