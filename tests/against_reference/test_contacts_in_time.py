"""Contacts resolved in time in whole passes, beside a bar, in a row, at the end of a run, against the independent solution.

Each computes the spring's stiffness from the requested duration at its own first touch. Instants and the angle at the
end are compared to ten times the requested accuracy, of the time scale of the belt, 1 ms, and of 1 rad.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

import bristle_sim as bs
from against_reference.test_tools import wire
from bristle_sim.reference import simulate_reference, simulate_row_reference

ACCURACY = 1e-6


def timed(
    duration: float, friction: float = 0.31, restitution: float = 0.42, compliance: float = 0.0
) -> bs.Tool:
    part = bs.Workpart(friction=friction, restitution=restitution)
    return bs.Tool(contact=bs.Contact("compliant", duration, compliance), workpart=part)


def touches(run: bs.Trajectory) -> list[float]:
    return [each.time for each in run.contacts if each.obstacle == "workpart"]


@pytest.mark.parametrize(
    ("duration", "friction", "restitution", "compliance"),
    [
        *itertools.product((2e-3,), (0.31, 0.6), (0.42, 0.0), (0.0, 1.21)),
        (5e-4, 0.31, 0.42, 0.0),
        (5e-4, 0.6, 0.0, 1.21),
        *(
            pytest.param(5e-4, *each, marks=pytest.mark.nightly)
            for each in itertools.product((0.31, 0.6), (0.42, 0.0), (0.0, 1.21))
            if each not in ((0.31, 0.42, 0.0), (0.6, 0.0, 1.21))
        ),
        *itertools.product((1e-4,), (0.31,), (0.42,), (0.0, 1.21)),
        *(
            pytest.param(3e-5, 0.31, 0.42, compliance, marks=pytest.mark.nightly)
            for compliance in (0.0, 1.21)
        ),
        (5e-4, 0.31, 0.8, 0.1),
        (1e-4, 1.0, 0.0, 0.0),
    ],
)
def test_a_whole_pass(
    duration: float, friction: float, restitution: float, compliance: float
) -> None:
    """Also elastic along the surface, eta^2 = 1.21 for steel; and with e* = 0 pressed in deeper and deeper by the belt."""
    tool = timed(duration, friction, restitution, compliance)
    run = bs.simulate(tool, bs.Settings(accuracy=ACCURACY))
    exact = simulate_reference(tool, accuracy=1e-8)
    assert run.stop_reason == exact.stop_reason
    assert touches(run) == pytest.approx(touches(exact), abs=10.0 * ACCURACY * 1e-3)
    assert run.angles[-1, 0] == pytest.approx(exact.angles[-1, 0], abs=10.0 * ACCURACY)


@pytest.mark.parametrize(("duration", "compliance"), [(5e-5, 1.6), (1e-5, 1.6), (1e-4, 0.0)])
def test_the_reference_is_accurate_where_unloading_is_stiff(
    duration: float, compliance: float
) -> None:
    """With e* = 0.03 unloading is 1,100 times as stiff as loading, and magnifies errors of the deepest penetration."""
    tool = timed(duration, restitution=0.03, compliance=compliance)
    coarse, fine = (
        simulate_reference(tool, accuracy=each, stop_after="workpart release").first_contact(
            "workpart"
        )
        for each in (ACCURACY, 1e-11)
    )
    assert coarse is not None
    assert fine is not None
    error = coarse.rates_after[0] - fine.rates_after[0]
    assert abs(error) < 0.1 * ACCURACY * abs(fine.rates_before[0])


def test_a_wire_whose_tip_is_pressed_into_its_dent_again_and_again() -> None:
    """With e* = 0 and two links each contact begins as the last one ends. None of them is rigid."""
    tool = timed(2e-4, restitution=0.0).replace(wire_links=2, wire_damping_ratio=0.1)
    run = bs.simulate(tool, bs.Settings(accuracy=ACCURACY, hub_turn=1.9))
    exact = simulate_reference(tool, accuracy=1e-8, hub_turn=1.9)
    assert len(touches(run)) > 5
    assert touches(run) == pytest.approx(touches(exact), abs=10.0 * ACCURACY * 1e-3)
    assert run.angles[-1] == pytest.approx(exact.angles[-1], abs=10.0 * ACCURACY)


@pytest.mark.parametrize("accuracy", [1e-6, 1e-7, 1e-8])
def test_a_stick_that_begins_on_the_friction_cone(accuracy: float) -> None:
    """Reverse slip stops just before the tip leaves; the margin of the cone rises from zero, give or take rounding."""
    tool = bs.Tool().replace(
        hub_speed="2104.4rpm",
        hub_radius="39.886mm",
        belt_stiffness=0.030004,
        belt_damping_ratio=0.743,
        bristle_length="20.301mm",
        bristle_mass="108.23mg",
        wire_diameter="0.31799mm",
        bar_radius="4.3913mm",
        bar_horizontal="56.761mm",
        bar_vertical="30.014mm",
        friction=0.040232,
        restitution=0.62381,
        penetration="0.79745mm",
        contact="compliant",
        contact_duration="0.49676ms",
        tangential_compliance=1.1075,
    )
    found, exact = (
        run.first_contact("workpart")
        for run in (
            bs.simulate(tool, bs.Settings(accuracy=accuracy), stop_after="workpart release"),
            simulate_reference(tool, accuracy=1e-9, stop_after="workpart release"),
        )
    )
    assert found is not None
    assert exact is not None
    assert found.phases[-2:] == ("restitution stick", "restitution slip")
    assert found.rates_after == pytest.approx(exact.rates_after, rel=10.0 * accuracy)


@pytest.mark.parametrize("friction", [0.113, 0.121, 0.126])
def test_a_foot_that_stops_at_an_instant_known_to_rounding(friction: float) -> None:
    """Its velocity there is rounding of either sign, more than that of a slip velocity: so stiff is the spring."""
    tool = bs.Tool().replace(
        hub_speed="662.75rpm",
        hub_radius="40.672mm",
        belt_stiffness=0.005839,
        bristle_length="48.62mm",
        bristle_mass="366.53mg",
        wire_diameter="1.525mm",
        bar_radius="1.3795mm",
        bar_horizontal="62.05mm",
        bar_vertical="46.233mm",
        bar_friction=1.0,
        bar_restitution=0.66822,
        friction=friction,
        restitution=0.83317,
        penetration="7.1882mm",
        contact="compliant",
        contact_duration="0.018444ms",
        tangential_compliance=1.875,
    )
    exact = simulate_reference(tool, accuracy=1e-9, stop_after="workpart release")
    run = bs.simulate(tool, bs.Settings(accuracy=ACCURACY), stop_after="workpart release")
    assert exact.stop_reason == run.stop_reason == "requested event"
    assert run.rates[-1] == pytest.approx(exact.rates[-1], rel=10.0 * ACCURACY)


def test_a_wire_that_touches_more_slowly_than_the_error() -> None:
    """At an accuracy of 1e-3 the fourth touch approaches by less than the error; it begins a spring, like the other three."""
    tool = timed(6.4585e-5).replace(wire_links=4, wire_damping_ratio=0.016)
    run = bs.simulate(tool, bs.Settings(accuracy=1e-3, hub_turn=1.335))
    exact = simulate_reference(tool, accuracy=1e-6, hub_turn=1.335)
    assert touches(run) == pytest.approx(touches(exact), abs=10.0 * 1e-3 * 1e-3)
    assert {each.law for each in run.contacts if each.obstacle == "workpart"} == {"compliant"}


@pytest.mark.parametrize("restitution", [0.42, 0.0])
def test_a_run_that_ends_with_its_strike(restitution: float) -> None:
    """Both end when the contact of the strike is over, and record it."""
    tool = timed(5e-5, restitution=restitution)
    run = bs.simulate(tool, bs.Settings(accuracy=ACCURACY), stop_after="strike")
    exact = simulate_reference(tool, accuracy=1e-8, stop_after="strike")
    strike, expected = (each.first_contact("workpart") for each in (run, exact))
    assert strike is not None
    assert expected is not None
    assert exact.stop_reason is run.stop_reason is bs.StopReason.EVENT
    assert expected.outcome == strike.outcome == ("rebound" if restitution else "no rebound")
    assert strike.duration == pytest.approx(expected.duration, rel=10.0 * ACCURACY)
    assert strike.impulse == pytest.approx(expected.impulse, rel=10.0 * ACCURACY)
    assert exact.time[-1] == pytest.approx(expected.time + expected.duration, rel=1e-12)


@pytest.mark.parametrize(
    ("duration", "friction", "followed", "hub_turn"),
    [(1e-4, 0.6, 7, 1.575), (1e-5, 0.31, 9, 1.878)],
)
def test_the_hops_of_a_pass(
    duration: float, friction: float, followed: int, hub_turn: float
) -> None:
    """Up to those so low, 1e-10 of the wire's length, that an error of the accuracy decides how many there are."""
    tool = timed(duration, friction)
    run = bs.simulate(tool, bs.Settings(accuracy=ACCURACY, hub_turn=hub_turn))
    exact = simulate_reference(tool, hub_turn=hub_turn, accuracy=1e-8)
    assert len(touches(exact)) == followed
    assert touches(run) == pytest.approx(touches(exact), abs=10.0 * ACCURACY * 1e-3)


def test_of_a_wire() -> None:
    """Strikes, the later ones in the dent of the first; each contact returns e*^2 of the work it took."""
    tool = replace(wire(3, modulus=5e10, damping=0.1), contact=bs.Contact("compliant", 7.1e-5))
    run = bs.simulate(tool, bs.Settings(accuracy=ACCURACY, hub_turn=1.27, maximum_steps=5_000_000))
    exact = simulate_reference(tool, hub_turn=1.27, accuracy=1e-8)
    found, expected = (
        [each for each in one.contacts if each.obstacle == "workpart"][:3] for one in (run, exact)
    )
    assert [each.time for each in found] == pytest.approx(
        [each.time for each in expected], rel=10.0 * ACCURACY
    )
    assert [each.impulse[0] for each in found] == pytest.approx(
        [each.impulse[0] for each in expected], rel=1e-6
    )
    for each in (*found, *expected):
        assert each.restitutive_work[0] == pytest.approx(
            -(0.42**2) * each.compressive_work[0], rel=1e-5
        )


def test_a_slip_that_hardly_begins() -> None:
    """The tip of two links at 2600 rpm slides back for 0.2 us at no more than 23 nm/s, sticks, and slides forward again."""
    bristle = replace(bs.Tool().bristle, links=2)
    tool = replace(
        timed(1e-4), bristle=bristle, hub=bs.Hub(speed=272.27), belt=bs.Belt(damping_ratio=0.05)
    )
    exact = simulate_reference(tool, accuracy=1e-10, stop_after="workpart release")
    expected = exact.first_contact("workpart")
    for accuracy in (1e-6, 1e-9):
        run = bs.simulate(tool, bs.Settings(accuracy=accuracy), stop_after="workpart release")
        found = run.first_contact("workpart")
        assert found.time + found.duration == pytest.approx(
            expected.time + expected.duration, abs=accuracy * 1e-3
        )
        assert found.impulse == pytest.approx(expected.impulse, rel=accuracy)


def test_in_a_row() -> None:
    """Each wire has springs of its own, and their neighbours are struck by it or not."""
    row = {
        "bristles": 2,
        "pitch": math.radians(25.0),
        "neighbour_friction": 0.2,
        "neighbour_restitution": 0.5,
    }
    runs = bs.simulate_row(timed(1e-4), bs.Settings(hub_turn=1.6), **row)
    exact = simulate_row_reference(timed(1e-4), hub_turn=1.6, accuracy=1e-8, **row)
    for run, other in zip(runs, exact, strict=True):
        assert len(touches(run)) >= 1
        assert run.event_time("strike") == touches(run)[0]
        assert touches(run) == pytest.approx(touches(other), abs=10.0 * ACCURACY * 1e-3)


def test_wires_of_a_row_touch_a_surface_of_one_stiffness() -> None:
    """The requested duration is that of the row's first contact, with which the other wire's is not equally long."""
    row = {
        "bristles": 2,
        "pitch": 0.16,
        "neighbour_friction": 0.3,
        "neighbour_restitution": 0.5,
        "stop_after": "strike",
    }
    tool = bs.Tool(contact=bs.Contact("compliant", 5e-5))
    runs = bs.simulate_row(tool, bs.Settings(accuracy=ACCURACY), **row)
    exact = simulate_row_reference(tool, accuracy=1e-8, **row)
    for run, other in zip(runs, exact, strict=True):
        found, expected = (each.first_contact("workpart") for each in (run, other))
        assert found.rates_after == pytest.approx(expected.rates_after, rel=10.0 * ACCURACY)
        assert found.duration == pytest.approx(expected.duration, rel=10.0 * ACCURACY)


def test_a_dent_lasts_while_a_neighbour_moves() -> None:
    """Wires 60 deg apart do not meet: each hops over its dent as the lone wire does, and does not touch its flank."""
    tool = timed(5e-4, friction=0.6, restitution=0.0, compliance=1.21)
    lone = touches(simulate_reference(tool, accuracy=1e-8))
    pitch = math.radians(60.0)
    row = simulate_row_reference(tool, accuracy=1e-8, bristles=2, pitch=pitch)
    for number, run in enumerate(row):
        later = number * pitch / tool.hub.speed
        assert touches(run) == pytest.approx([time + later for time in lone], rel=1e-9)


def test_a_wire_of_a_row_is_pressed_on_by_its_belt() -> None:
    """Without restitution the spring is compressed anew after each contact, in a row as alone; the wires do not meet."""
    tool = timed(2e-4, friction=0.66, restitution=0.0)
    lone = bs.simulate(tool, bs.Settings(accuracy=ACCURACY, hub_turn=2.2))
    row = {"pitch": 0.6856, "neighbour_friction": 0.2, "neighbour_restitution": 0.5}
    settings = bs.Settings(accuracy=ACCURACY, hub_turn=2.2 - row["pitch"])
    run = bs.simulate_row(tool, settings, bristles=2, **row)[0]
    assert len(touches(lone)) == 4
    assert touches(run) == pytest.approx(touches(lone), abs=10.0 * ACCURACY * 1e-3)
    assert {each.law for each in run.contacts if each.obstacle == "workpart"} == {"compliant"}


def test_a_foot_that_stops_within_rounding_sticks() -> None:
    """Its slip of 8e-13 m/s ends in 3e-19 s, less than the rounding of 4.6 ms."""
    row = {"bristles": 2, "pitch": math.radians(45.420981826242766), "hub_turn": 1.0}
    row |= {"neighbour_friction": 0.2, "neighbour_restitution": 0.5}
    tool = timed(0.00020292782842972338, 0.5065475194192931, 0.8, 0.3)
    tool = replace(tool, belt=bs.Belt(damping_ratio=0.05))
    for run in simulate_row_reference(tool, accuracy=1e-8, **row):
        assert run.stop_reason is bs.StopReason.END


@pytest.mark.parametrize("restitution", [0.42, 0.0])
def test_beside_a_bar(restitution: float) -> None:
    """A bar 0.3 mm beside the wire is met 9.4 us after the touch, while the spring acts.

    The impact throws the tip off the workpart, which is a rebound even without restitution there.
    """
    full = bs.simulate(timed(1e-3))
    strike = full.first_contact("workpart")
    at = full.at(strike.time)
    before = full.at(strike.time - 2e-5)
    root = at.centre_line[0]
    tip = at.centre_line[-1]
    along = (tip - root) / np.linalg.norm(tip - root)
    centre = (
        root + 0.8 * (tip - root) + np.array([-along[1], along[0]]) * (1e-3 + 0.355e-3 + 0.3e-3)
    )
    bar = bs.Bar(
        radius=1e-3, horizontal=float(-centre[0]), vertical=float(-centre[1]), restitution=0.2
    )
    start = {
        "start_hub_angle": float(before.hub_angle),
        "start_relative_angle": float(before.relative_angle),
        "start_relative_rate": float(before.rates[0] - before.hub_speed),
    }
    tool = replace(timed(1e-3, restitution=restitution), bar=bar)
    run = bs.simulate(tool, **start)
    exact = simulate_reference(tool, accuracy=1e-8, **start)
    for name in ("strike", "bar touch", "workpart release"):
        assert run.event_time(name) == pytest.approx(
            exact.event_time(name), abs=10.0 * ACCURACY * 1e-3
        )
    first, second = (each.first_contact("workpart") for each in (run, exact))
    assert first.impulse == pytest.approx(second.impulse, rel=1e-5)
    assert first.outcome == second.outcome == "rebound"


def test_at_the_end_of_a_run() -> None:
    """A run that is planned to end in a contact ends there, and its record and samples have the force."""
    full = bs.simulate(timed(1e-3), stop_after="strike")
    strike = full.first_contact("workpart")
    end = strike.time + 0.2 * strike.duration
    run = bs.simulate(timed(1e-3), bs.Settings(hub_turn=end * full.hub_speed))
    record = run.first_contact("workpart")
    assert run.time[-1] == pytest.approx(end, rel=1e-14)
    assert record.outcome == "end of the planned time"
    assert record.history.time[-1] == pytest.approx(end, rel=1e-12)
    assert run.normal_force[-1] == pytest.approx(record.history.normal_force[-1], rel=1e-12)
    assert run.normal_force[-1] > 1.0


def test_a_history_stays_within_the_friction_cone() -> None:
    for knee, friction, penetration in ((20.0, 0.31, 0.0045), (40.0, 0.7, 0.007)):
        part = bs.Workpart(friction=friction, restitution=0.0, penetration=penetration)
        contact = bs.Contact("compliant", 2e-4)
        run = bs.simulate(
            bs.Tool(bristle=bs.Bristle(knee_angle_deg=knee), workpart=part, contact=contact)
        )
        for history in (each.history for each in run.contacts if each.history is not None):
            excess = np.abs(history.tangential_force) - friction * history.normal_force
            assert excess.max() <= 1e-12 * history.normal_force.max()


@pytest.mark.parametrize(("angle", "position"), [(-70.0, 0.9), (-80.0, 0.6), (-90.0, 0.9)])
def test_the_knee_of_a_bent_wire_meets_the_workpart(angle: float, position: float) -> None:
    run = bs.simulate(bs.Tool(bristle=bs.Bristle(knee_angle_deg=angle, knee_position=position)))
    height = run.centre_line[:, :, 1] + run.tool.workpart_depth
    assert height.min() >= -1e-7 * run.tool.bristle.length
    assert height[:, 1].min() <= 1e-7 * run.tool.bristle.length


@pytest.mark.parametrize("friction", [0.5, 0.6, 0.9])
def test_a_radial_wire_that_friction_would_hold(friction: float) -> None:
    """Slip and approach end together but for an error: in stiction no restitution belongs to the requested duration."""
    tool = timed(1.7e-4, friction).replace(bar=None)
    law = simulate_reference(replace(tool, contact=bs.Contact()), stop_after="strike").contacts[0]
    assert law.outcome == "stiction"
    exact = simulate_reference(tool, stop_after="workpart release").first_contact("workpart")
    for accuracy in (1e-3, 1e-4, 1e-6, 1e-8):
        run = bs.simulate(tool, bs.Settings(accuracy=accuracy), stop_after="workpart release")
        contact = run.first_contact("workpart")
        assert contact.impulse == pytest.approx(exact.impulse, rel=10.0 * accuracy)
        assert contact.duration == pytest.approx(exact.duration, rel=10.0 * accuracy)


@pytest.mark.parametrize("solve", [bs.simulate, simulate_reference])
def test_a_second_point_that_touches_beside_the_first_is_no_second_strike(solve) -> None:
    """Knee and tip of a bent wire meet the workpart within one contact of 1 ms; the wire strikes once."""
    tool = timed(1e-3).replace(knee_angle_deg=-40.0, knee_position=0.85)
    run = solve(tool, stop_after="workpart release")
    names = [each.name for each in run.events if each.name in {"strike", "workpart touch"}]
    assert names == ["strike", "workpart touch"]


def test_a_tip_that_has_left_its_dent_strikes_the_surface() -> None:
    """The first contact leaves a dent of 1 % of the length; the hop over it ends at the height of the workpart."""
    tool = bs.Tool().replace(contact="compliant", contact_duration=1e-4)
    run = bs.simulate(tool, bs.Settings(hub_turn=2.5))
    first, second = [each for each in run.contacts if each.obstacle == "workpart"][:2]
    assert first.outcome == "rebound"
    height = np.interp(second.time, run.time, run.tip[:, 1]) + tool.workpart_depth
    assert height == pytest.approx(0.0, abs=1e-6 * tool.bristle.length)


@pytest.mark.parametrize("restitution", [0.32924, 0.35, 0.4])
@pytest.mark.parametrize("accuracy", [1e-3, 1e-4, 1e-5])
def test_a_wire_that_comes_to_rest_in_the_rigid_limit_does_not_sink(
    restitution: float, accuracy: float
):
    """After its last small rebound the wire rests on the surface; a series of further contacts would dig it in by a hundredth of its length."""
    tool = bs.Tool(
        belt=bs.Belt(stiffness=0.07, damping_ratio=0.2),
        workpart=bs.Workpart(penetration=0.0072, friction=0.2334, restitution=restitution),
        contact=bs.Contact("compliant"),
    )
    run = bs.simulate(tool, bs.Settings(accuracy=accuracy))
    depth = -tool.workpart_depth - run.centre_line[:, -1, 1].min()
    assert depth < accuracy * tool.bristle.length
    # Each rebound has restitution times the speed of the one before, so a dozen reach the accuracy.
    assert len(run.contacts) < 20 + math.log(accuracy) / math.log(restitution)


@pytest.mark.parametrize(("duration", "accuracy"), [(2e-6, 1e-6), (1e-5, 1e-4), (5e-5, 1e-3)])
def test_a_wire_that_comes_to_rest_on_its_spring_spends_no_budget(duration: float, accuracy: float):
    """The wire bounces a few dozen times before it drags along; a search for ever shorter hops would take half a million steps."""
    run = bs.simulate(timed(duration), bs.Settings(accuracy=accuracy, hub_turn=3.0))
    assert run.stop_reason == "end of the planned time"
    assert run.cost.steps < 100_000
