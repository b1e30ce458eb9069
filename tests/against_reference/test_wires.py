"""Wires of several links beyond their strikes, in several contacts at once: the scene against the independent solution.

The tolerance is ten times the requested accuracy, of angles in rad and of instants; the end of a whole pass with its
rebounds gets ten times that.
"""

from dataclasses import replace

import numpy as np
import pytest

from against_reference.test_tools import wire
from bristle_sim.parameters import Bar, Belt, Bristle, Contact, Tool, Workpart
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.simulate import simulate, time_scale
from bristle_sim.scene.tool import build_tool
from bristle_sim.settings import Settings, StopReason
from bristle_sim.trajectory import Trajectory

ACCURACY = 1e-6


def touches(run: Trajectory) -> list[float]:
    return [
        each.time for each in run.events if each.name.endswith(" touch") or each.name == "strike"
    ]


def overlapping(run: Trajectory) -> set[bool]:
    """Of pairs of sustained contacts at a time: whether they are with one obstacle."""
    lasting = [each for each in run.contacts if each.law == "sustained"]
    pairs = ((a, b) for a in lasting for b in lasting if a.time < b.time < a.time + a.duration)
    return {a.obstacle == b.obstacle for a, b in pairs}


def pressed(run: Trajectory) -> list[float]:
    """Return the impulse up to the end of the first lasting contact, the taps that end in it included.

    Which of the last taps is a contact of its own depends on the accuracy, but not this sum.
    """
    lasting = next(each for each in run.contacts if each.duration > 1e-5)
    taps = [each for each in run.contacts if each.time <= lasting.time]
    return np.sum([each.impulse for each in taps if each.obstacle == lasting.obstacle], axis=0)


LIMP = wire(4, modulus=8.5e7, nearness=0.7528, friction=0.3)
DAMPED = wire(3, modulus=3.2e10, damping=0.3)
STICKY = replace(wire(3, damping=0.3, friction=0.2, restitution=0.42), belt=Belt())

CASES = {
    "a limp wire wraps around a bar": (
        replace(LIMP, bar=replace(LIMP.bar, radius=0.005557), workpart=None), 1.2, {True}, 1.0,
    ),
    "a bar over the workpart meets the last link while the tip drags": (
        replace(
            DAMPED,
            bristle=replace(DAMPED.bristle, modulus=3.1996e10),
            bar=Bar(radius=0.00272879, horizontal=0.00957196, vertical=0.045664, friction=0.2),
            workpart=Workpart(penetration=0.00277574, friction=0.0, restitution=0.0),
        ), 1.9, {False}, 1.0,
    ),
    "an inelastic strike with friction stops the tip": (
        replace(
            DAMPED,
            bar=Bar(radius=0.0015, horizontal=0.0096, vertical=0.0465, friction=0.2),
            workpart=Workpart(penetration=0.0035, friction=0.2, restitution=0.0),
        ), 1.9, set(), 1.0,
    ),
    "stick breaks away as the wire bends": (
        replace(STICKY, workpart=Workpart(friction=0.8, restitution=0.0)), 3.0, set(), 1.0,
    ),
    "a whole pass: rebounds, drag, release, swing": (wire(2, damping=0.05), None, set(), 10.0),
}  # fmt: skip
"""Tool, hub's turn, contacts at a time, and by how much rebounds magnify the error at the end."""

LONG = (
    "a bar over the workpart meets the last link while the tip drags",
    "stick breaks away as the wire bends",
)


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.nightly] if name in LONG else []) for name in CASES],
)
def test_a_wire_in_lasting_contacts(name: str) -> None:
    tool, turn, together, magnified = CASES[name]
    turned = {} if turn is None else {"hub_turn": turn}
    scene = simulate(tool, Settings(accuracy=ACCURACY, maximum_steps=5_000_000, **turned))
    reference = simulate_reference(tool, accuracy=1e-8, **turned)
    assert scene.stop_reason == reference.stop_reason
    assert touches(scene)[:5] == pytest.approx(touches(reference)[:5], rel=10.0 * ACCURACY)
    assert scene.angles[-1] == pytest.approx(reference.angles[-1], abs=10.0 * magnified * ACCURACY)
    assert all(together <= overlapping(run) for run in (scene, reference))
    assert pressed(scene) == pytest.approx(pressed(reference), rel=10.0 * ACCURACY)


def test_a_contact_slides_over_a_joint_without_an_impact() -> None:
    """The ends of two links are one circle there: nothing jumps where the contact passes on, and no touch is recorded."""
    tool = wire(4, modulus=2.92e10, knee=-24.35, nearness=0.7863, friction=0.2395)
    run = simulate(tool, Settings(accuracy=ACCURACY, hub_turn=0.87))
    first, second = run.contacts[-2:]
    assert (first.law, first.outcome, second.law) == ("sustained", "bar", "sustained")
    assert second.time == pytest.approx(first.time + first.duration, rel=1e-12)
    assert second.rates_before == pytest.approx(first.rates_after, rel=1e-9)
    assert touches(run)[-1] < second.time


def test_a_link_touches_with_its_other_segment_while_the_next_link_is_in_contact() -> None:
    """A knee lies a hundredth of a link before the joint: the bar has passed that short segment's end, not the link."""
    tool = Tool().replace(
        hub_speed=340.0,
        bristle_length=0.05,
        wire_diameter=2.8e-4,
        wire_links=3,
        wire_modulus=1.24e11,
        wire_damping_ratio=0.18,
        knee_angle_deg=58.0,
        knee_position=0.664,
        belt_stiffness=0.0215,
        bar_radius=0.0061,
        bar_horizontal=0.0471,
        bar_vertical=-0.0329,
        bar_friction=0.15,
    )
    run = simulate(tool, Settings(accuracy=ACCURACY, hub_turn=0.45))
    reference = simulate_reference(tool, accuracy=1e-9, hub_turn=0.45)
    assert len(touches(reference)) == 4
    assert touches(run) == pytest.approx(touches(reference), rel=10.0 * ACCURACY)


@pytest.mark.parametrize(("knee", "friction"), [(0.0, 0.31), (30.0, 0.5), (-30.0, 0.5)])
def test_no_jump_out_of_a_dent(knee: float, friction: float) -> None:
    """A contact resolved in time may end inside the workpart; the tip stays there until it comes out by itself.

    Between two samples it moves no further than its largest speed takes it, but for curvature.
    """
    tool = Tool(bristle=Bristle(knee_angle_deg=knee), contact=Contact("compliant", 1e-4))
    run = simulate(replace(tool, workpart=Workpart(friction=friction)))
    assert run.tip[:, 1].min() < -run.tool.workpart_depth - 1e-4
    way = np.linalg.norm(np.diff(run.tip, axis=0), axis=1)
    time = np.diff(run.time)
    speed = np.linalg.norm(run.tip_velocity, axis=1)
    # An interval of sustained contact turns a belt's radian at most: the speed between its ends is less than twice theirs.
    assert (
        way <= 2.0 * np.maximum(speed[1:], speed[:-1]) * time + 1e-12 * np.hypot(*run.tip[0])
    ).all()


SPEEDS = [Tool().hub.speed * (1.0 + 1e-3 * share) for share in range(14)]


@pytest.mark.parametrize(
    ("links", "accuracy", "speeds"),
    [(4, 1e-3, SPEEDS[:1])]
    + [
        pytest.param(links, each, SPEEDS, marks=pytest.mark.nightly)
        for links in (2, 4, 6, 8)
        for each in (1e-2, 1e-3)
    ],
)
def test_a_wire_does_not_stutter(links: int, accuracy: float, speeds: list[float]) -> None:
    """It slips before it is released from stick. A stutter of release and touch takes any number of steps at one instant.

    The limit is twice the steps of intervals in which the fastest mode turns by two radians, repeated with 2, 4, ... 12 steps.
    """
    for speed in speeds:
        tool = Tool(hub=replace(Tool().hub, speed=speed), bristle=Bristle(links=links))
        scene, units = build_tool(tool)
        run = simulate(tool, Settings(accuracy=accuracy, hub_turn=1.5, maximum_steps=200_000))
        assert run.stop_reason is StopReason.END
        assert run.cost.steps < 2.0 * 42.0 * run.time[-1] / (2.0 * time_scale(scene) * units.time)


@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_a_thread_of_two_links(damping: float) -> None:
    """A wire of diameter 0 with a given mass has hinges without stiffness and without damping."""
    tool = Tool().replace(
        wire_diameter=0.0, bristle_mass=8e-5, wire_links=2, wire_damping_ratio=damping
    )
    run = simulate(tool, Settings(accuracy=1e-6), stop_after="strike")
    exact = simulate_reference(tool, accuracy=1e-9, stop_after="strike")
    assert run.event_time("strike") == pytest.approx(exact.event_time("strike"), rel=1e-5)


def test_all_impulses_of_taps_and_rest_are_recorded() -> None:
    """Both end the taps of a bouncing tip at other instants; the sums of impulse and work agree only if nothing is left out."""
    tool = Tool().replace(
        hub_speed=286.7,
        bristle_length=0.0273,
        wire_diameter=0.00118,
        belt_damping_ratio=0.28,
        friction=0.36,
        restitution=0.3,
        bar_friction=0.345,
        bar_restitution=0.53,
        belt_stiffness=0.0198,
        bar_radius=0.0043,
        bar_horizontal=0.0578,
        bar_vertical=-0.0071,
        penetration=0.0021,
        knee_angle_deg=-45.5,
        knee_position=0.83,
        wire_links=2,
        wire_damping_ratio=0.159,
    )
    runs = simulate(tool, Settings(accuracy=1e-7)), simulate_reference(tool, accuracy=1e-9)
    for obstacle in ("bar", "workpart"):
        impulses, expected = (
            np.sum([each.impulse for each in run.contacts if each.obstacle == obstacle], axis=0)
            for run in runs
        )
        assert impulses == pytest.approx(expected, abs=1e-6 * np.hypot(*expected))


@pytest.mark.parametrize("accuracy", [1e-8, pytest.param(1e-9, marks=pytest.mark.nightly)])
def test_slip_that_stops_and_returns_within_an_interval_is_not_missed(accuracy: float) -> None:
    """The tip drags, stops for 18 us while the wire swings back, and drags on; without the stop it leaves 1.3 us earlier."""
    tool = Tool().replace(
        hub_speed=499.0716158992311,
        bristle_length=0.03034353147389501,
        wire_diameter=0.0006387282034420392,
        friction=0.20411754630981072,
        restitution=0.026585921988601414,
        bar_radius=0.005904137397674605,
        bar_horizontal=0.05453486165359689,
        bar_vertical=0.022270192014409402,
        belt_stiffness=0.023877838147033096,
        penetration=0.006337786938014147,
        wire_links=2,
        wire_damping_ratio=0.007020825813729737,
    )
    scene = simulate(tool, Settings(accuracy=accuracy))
    reference = simulate_reference(tool, accuracy=1e-9)
    release = reference.event_time("workpart release")
    assert scene.event_time("workpart release") == pytest.approx(release, rel=1e-6)


def test_a_tip_that_sticks_slips_where_friction_is_exceeded_for_a_moment() -> None:
    """Links that vibrate by a radian in 89 us. The force in stick exceeds friction for less; the tip slips for 50 us."""
    wire = Tool().replace(
        hub_speed=0.0,
        friction=0.725,
        restitution=0.0,
        belt_stiffness=0.0617,
        wire_links=3,
        wire_modulus=8e9,
        wire_damping_ratio=0.05,
    )
    start = {
        "start_hub_angle": -0.135,
        "start_relative_angle": 0.828,
        "start_relative_rate": 21.4,
    }
    tool = replace(wire, bar=None)
    found = simulate(tool, Settings(accuracy=1e-6), **start)
    expected = simulate_reference(tool, accuracy=1e-8, **start)
    assert found.angles[-1] == pytest.approx(expected.angles[-1], rel=0.0, abs=1e-6)
    assert found.contacts[-1].impulse == pytest.approx(expected.contacts[-1].impulse, rel=1e-6)
