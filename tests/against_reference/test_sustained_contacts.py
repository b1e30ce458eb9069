"""Sustained contacts: friction opposes slip from the first instant, and a release is located to the requested accuracy."""

from __future__ import annotations

import math

import numpy as np
import pytest

import bristle_sim as bs

ACCURACIES = (1e-3, 1e-4, 1e-6, 1e-9)


def drags(tool: bs.Tool, accuracy: float) -> tuple[bs.Trajectory, list[tuple[float, float]]]:
    run = bs.simulate(tool, bs.Settings(accuracy=accuracy))
    lasting = [each for each in run.contacts if each.law == "sustained"]
    # Coulomb friction takes energy; rounding of a work is far below 1e-12 of the strike's 10 mJ.
    assert all(each.compressive_work[1] <= 1e-14 for each in lasting)
    return run, [each.impulse for each in lasting]


@pytest.mark.parametrize("accuracy", ACCURACIES)
def test_a_drag_that_begins_without_slip_is_rubbed_against_its_acceleration(accuracy: float):
    """e* = 0, a critically damped wire that no bar has touched: model, drag impulse (3.349, -1.038) mN s, to its digits."""
    tool = bs.Tool(
        bar=None,
        belt=bs.Belt(damping_ratio=1.0),
        workpart=bs.Workpart(friction=0.31, restitution=0.0),
    )
    run, ((normal, tangential),) = drags(tool, accuracy)
    assert run.stop_reason == "end of the planned time"
    # The printed digits, and the errors of the drag's ten intervals or so.
    assert (1e3 * normal, 1e3 * tangential) == pytest.approx(
        (3.349, -1.038), rel=2e-4 + 10.0 * accuracy
    )


@pytest.mark.parametrize("accuracy", ACCURACIES)
def test_stiction_of_a_radial_strike_is_no_jam(accuracy: float):
    """mu = 0.6 > tan(23.4 deg): the strike does not rebound; the reference drags on to the end."""
    tool = bs.Tool(bar=None, workpart=bs.Workpart(friction=0.6))
    run, ((normal, tangential),) = drags(tool, accuracy)
    assert run.stop_reason == "end of the planned time"
    # The reference's impulse. Which tap is the last one before the drag depends on the accuracy: 1e-4 of the impulse.
    assert (normal, tangential) == pytest.approx(
        (1.0516e-3, -6.3096e-4), rel=2e-4 + 10.0 * accuracy
    )


def test_a_release_over_the_wires_end_is_where_the_contact_passes_it():
    """The force jumps below zero where the bar passes from the flank to the wire's end: 2.722468766417335 ms, in closed form."""
    bristle = bs.Bristle(0.032889167757901405, 0.00029612070505255847, 0.001215294931018804)
    bar = bs.Bar(
        0.0020542860355168184, 0.0747134429170983, 0.011478158629806539, 0.26996925711305286, 0.0
    )
    tool = bs.Tool(
        hub=bs.Hub(142.81187342154342, 0.045641125392908044),
        belt=bs.Belt(0.012111023738675635),
        bristle=bristle,
        bar=bar,
        workpart=bs.Workpart(
            penetration=0.0036757717105358285, friction=0.4054280176822556, restitution=0.0
        ),
    )
    for accuracy in (1e-7, 3e-9, 1.5e-9, 1e-9):
        run = bs.simulate(tool, bs.Settings(accuracy=accuracy), stop_after="bar release")
        # An angle is right to the accuracy at 394.82 rad/s.
        assert run.event_time("bar release") == pytest.approx(
            0.002722468766417335, abs=accuracy / 394.82
        )


def event_names_and_times(run: bs.Trajectory) -> tuple[list[str], list[float]]:
    return [event.name for event in run.events], [event.time for event in run.events]


def test_a_wire_leaves_the_bar_where_its_end_would_be_drawn_to_it_for_an_instant():
    """As the bar passes to the wire's end, the force jumps from 0.85 N to a pull that lasts for 0.03 ms; then it would push again.

    A rigid contact does not pull: the wire's end leaves, and comes back with 0.05 m/s. The passage from one side of the knee to
    the other is no release.
    """
    tool = bs.Tool().replace(
        hub_speed=344.0,
        bristle_length=0.0405,
        knee_angle_deg=27.5,
        bar_radius=0.00405,
        penetration=0.0055,
    )
    run = bs.simulate(tool, bs.Settings(accuracy=1e-9))
    names, times = event_names_and_times(run)
    expected_names, expected_times = event_names_and_times(bs.simulate_reference(tool))
    assert names == expected_names
    assert names[:5] == ["bar touch", "bar touch", "bar release", "bar touch", "bar release"]
    # The wire's end opens by 0.7 um for 0.1 ms, which magnifies an error of its speed.
    assert times == pytest.approx(expected_times, rel=1e-6, abs=0.0)


def test_a_wire_that_rebounds_from_the_bar_behind_its_knee_has_been_released_in_front_of_it():
    """A contact that passes over the knee is no release, unless the wire rebounds there."""
    tool = bs.Tool().replace(
        hub_speed=275.0,
        bristle_length=0.0442,
        knee_angle_deg=17.0,
        bar_restitution=0.1,
        bar_radius=0.0044,
    )
    for run in (bs.simulate(tool), bs.simulate_reference(tool)):
        resting = next(each for each in run.contacts if each.law == "sustained")
        rebound = next(
            each for each in run.contacts if each.time > resting.time and each.law == "energetic"
        )
        assert (resting.outcome, rebound.outcome) == ("bar", "rebound")
        assert run.event_time("bar release") == rebound.time == resting.time + resting.duration


def test_the_largest_retraction_is_the_only_event_of_its_name():
    """A bent wire swings to 38.94 degrees first, and to 47 degrees before the strike."""
    run = bs.simulate(bs.Tool(bristle=bs.Bristle(knee_angle_deg=-30.0)))
    time = [event.time for event in run.events if event.name == "largest retraction"]
    before = run.retraction[run.time <= run.event_time("strike")]
    assert len(time) == 1
    assert float(run.at(time[0]).retraction) == pytest.approx(before.max(), rel=1e-9)


@pytest.mark.parametrize("restitution", [0.0, 0.4])
def test_friction_beyond_the_engines_reach_is_solved_for(restitution: float):
    """At mu = 2.7 the engine's iterations would not converge; the contacts are solved for with the joint instead."""
    tool = bs.Tool(
        bar=None, belt=bs.Belt(damping_ratio=0.1), workpart=bs.Workpart(2.7, None, restitution)
    )
    run, impulses = drags(tool, 1e-6)
    reference = bs.simulate_reference(tool)
    lasting = [each for each in reference.contacts if each.law == "sustained"]
    assert run.stop_reason == reference.stop_reason
    assert len(impulses) == len(lasting) > 0
    # The taps before a drag are included: which of them is the last one depends on the accuracy.
    found, expected = (
        np.sum([each.impulse for each in one.contacts], axis=0) for one in (run, reference)
    )
    assert found == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("accuracy", ACCURACIES[2:])
def test_slip_of_an_undeflected_wire_ends_with_its_approach(accuracy: float):
    """mu_2 < tan gamma < mu_1: the strike rebounds. An error of the slip, let alone, would end it in stiction: a false jam."""
    tool = bs.Tool(
        bar=None, workpart=bs.Workpart(friction=0.6, restitution_friction=0.1, restitution=0.3)
    )
    strike = bs.simulate(tool, bs.Settings(accuracy=accuracy), stop_after="strike").first_contact(
        "workpart"
    )
    # (2.48) for a radial wire that turns with the hub, R = 1.
    reach = tool.hub.radius + tool.bristle.length
    cosine = 1.0 - tool.workpart.penetration / reach
    sine = math.sqrt(1.0 - cosine**2)
    compression, restitution = sine + 0.6 * cosine, sine - 0.1 * cosine
    bristle = tool.bristle
    hub = tool.hub
    speed = (1.0 + hub.radius / bristle.length) * hub.speed * bristle.mass * bristle.length / 3.0
    impulse = (
        speed
        * (restitution + 0.3 * math.sqrt(compression * restitution))
        / (compression * restitution)
    )
    assert strike.outcome == "rebound"
    assert strike.impulse[0] == pytest.approx(impulse, rel=10.0 * accuracy)


def test_friction_of_the_bar_turns_round_where_slip_does():
    """A damped wire slides out along the bar, then back: the impulse of friction is that of the reference."""
    tool = bs.Tool(
        hub=bs.Hub(384.0, 0.031),
        belt=bs.Belt(0.0041, damping_ratio=1.4),
        bristle=bs.Bristle(length=0.035, mass=1.11e-5, wire_diameter=0.00045),
        bar=bs.Bar(0.0029, 0.0594, 0.0272, friction=0.15),
        workpart=None,
    )
    row = bs.simulate_row(
        tool, bristles=2, pitch=0.5 * math.pi, neighbour_friction=0.0, neighbour_restitution=1.0
    )
    *scenes, reference = (
        next(each for each in run.contacts if each.law == "sustained")
        for run in (bs.simulate(tool), *row, bs.simulate_reference(tool, accuracy=1e-9))
    )
    # As above; without the friction of the way back the tangential impulse would be a hundredth of it.
    for scene in scenes:
        assert scene.impulse == pytest.approx(reference.impulse, rel=2e-4)


def test_the_first_link_of_a_wire_does_not_stick_to_the_bar():
    """The hub's motion alone moves it along the bar: its slip reverses, and the second link touches with it.

    The instant and the impulses of the drag are the reference's to ten times the accuracy of 1e-6.
    """
    tool = bs.Tool().replace(
        hub_speed=505.0,
        bristle_length=0.045,
        wire_diameter=1.45e-3,
        wire_links=2,
        wire_modulus=6e10,
        belt_stiffness=0.096,
        bar_friction=0.5,
        bar_radius=2.6e-3,
        bar_horizontal=0.0455,
        bar_vertical=-0.0127,
    )
    run = bs.simulate(tool, stop_after="bar release")
    reference = bs.simulate_reference(tool, accuracy=1e-9, stop_after="bar release")
    assert run.event_time("bar release") == pytest.approx(
        reference.event_time("bar release"), rel=1e-5
    )
    drag, expected = (
        next(each for each in one.contacts if each.law == "sustained") for one in (run, reference)
    )
    assert drag.impulse == pytest.approx(expected.impulse, rel=1e-5)


def test_the_work_of_friction_on_a_wire_of_two_links_is_that_of_the_slip_under_its_forces():
    """The first drag of a pass at 1e-4: its friction impulse and work are those of the reference."""
    tool = bs.Tool(
        bar=None,
        workpart=bs.Workpart(friction=0.6, restitution=0.0),
        bristle=bs.Bristle(links=2),
    )
    drag, expected = (
        next(each for each in run.contacts if each.law == "sustained")
        for run in (
            bs.simulate(tool, bs.Settings(accuracy=1e-4, hub_turn=1.3)),
            bs.simulate_reference(tool, accuracy=1e-8, hub_turn=1.3),
        )
    )
    assert drag.impulse[1] == pytest.approx(expected.impulse[1], rel=1e-4)
    assert drag.compressive_work[1] == pytest.approx(expected.compressive_work[1], rel=1e-4)


def test_a_tip_of_two_links_whose_slip_stops_sticks_before_it_slips_back():
    """Where slip reversed at once instead, friction would jam the wire. The impulses are the reference's."""
    tool = bs.Tool(
        hub=bs.Hub(speed=100.0),
        bar=None,
        workpart=bs.Workpart(friction=0.9, restitution=0.0),
        bristle=bs.Bristle(links=2, knee_angle_deg=-20.0),
    )
    run = bs.simulate(tool, bs.Settings(accuracy=1e-4, hub_turn=1.35))
    drag = next(each for each in run.contacts if each.law == "sustained")
    assert (run.stop_reason, drag.outcome) == ("end of the planned time", "release")
    reference = bs.simulate_reference(tool, accuracy=1e-8, hub_turn=1.35)
    expected = next(each for each in reference.contacts if each.law == "sustained")
    assert drag.impulse == pytest.approx(expected.impulse, rel=1e-4)


def test_a_link_whose_slip_stops_as_another_is_released_does_not_slip_with_its_friction():
    """Two links rub on the bar. The one stops and the other leaves: friction then works against its slip, never with it."""
    tool = bs.Tool().replace(
        hub_speed=1476.92,
        bristle_length=0.0566387,
        wire_diameter=2.52137e-4,
        wire_links=3,
        wire_modulus=7.51055e10,
        wire_damping_ratio=0.060782,
        knee_angle_deg=25.2957,
        knee_position=0.704169,
        belt_stiffness=3.91473,
        belt_damping_ratio=0.134891,
        bar_radius=2e-4,
        bar_horizontal=0.0610263,
        bar_vertical=0.0178397,
        bar_friction=0.989372,
        bar_restitution=0.106622,
    )
    run = bs.simulate(tool, bs.Settings(hub_turn=0.53))
    work = [contact.work[1] for contact in run.contacts if contact.law == "sustained"]
    assert len(work) > 4
    assert max(work) <= 1e-9 * run.kinetic_energy.max()  # sums of several hundred steps


def test_a_tip_that_slips_back_after_an_elastic_strike_leaves_the_workpart_where_friction_would_lock_it():
    """No force keeps the tip on the workpart in this sense of slip, and none is needed: it is drawn off.

    The instants of all events are the reference's, to ten times the accuracy of 1e-6.
    """
    tool = bs.Tool().replace(
        hub_speed=77.9807,
        bristle_length=0.0132874,
        wire_diameter=3.34468e-4,
        belt_stiffness=2.54765e-4,
        belt_damping_ratio=0.0150117,
        friction=0.25,
        restitution=0.0,
        penetration=1.828929e-3,
        tangential_compliance=1.94465,
        gravity=300.0,
        bar_radius=0.00396019,
        bar_horizontal=0.0341019,
        bar_vertical=-0.0130142,
    )
    run = bs.simulate(tool)
    reference = bs.simulate_reference(tool, accuracy=1e-9)
    assert run.stop_reason == reference.stop_reason == "end of the planned time"
    names, times = event_names_and_times(run)
    expected_names, expected_times = event_names_and_times(reference)
    assert names == expected_names
    assert times == pytest.approx(expected_times, rel=1e-5)


def test_a_sticking_tip_whose_slip_friction_would_lock_leaves_the_workpart():
    """The tangential force reaches the friction cone while the tip is pressed on with 0.65 N.

    In slip a normal force would draw the tip in, so slip has no stable force. Without the force the tip opens.
    """
    tool = bs.Tool().replace(
        hub_speed=186.0,
        bristle_length=0.0451,
        wire_diameter=0.000414,
        wire_links=2,
        wire_damping_ratio=0.111,
        belt_stiffness=0.0723,
        belt_damping_ratio=0.246,
        friction=0.849,
        restitution=0.0,
        bar_restitution=0.635,
        bar_radius=0.00358,
        bar_horizontal=0.0642,
        bar_vertical=0.0222,
        penetration=0.00934,
    )
    run = bs.simulate(tool)
    reference = bs.simulate_reference(tool, accuracy=1e-8)
    assert run.stop_reason == reference.stop_reason == "end of the planned time"
    first, second = (
        next(
            each for each in ran.contacts if each.law == "sustained" and each.obstacle == "workpart"
        )
        for ran in (run, reference)
    )
    assert first.outcome == second.outcome == "release"
    # Ten accuracies of the time scale of the belt, 1 ms.
    assert first.duration == pytest.approx(second.duration, rel=0.0, abs=1e-8)


def test_each_point_of_a_wire_that_touches_the_workpart_is_released():
    """The knee drags, the tip strikes without a rebound and turns the wire off its knee, and drags on alone."""
    tool = bs.Tool().replace(
        hub_speed=399.0,
        bristle_length=0.0228,
        wire_diameter=3.15e-4,
        belt_stiffness=0.04,
        belt_damping_ratio=0.431,
        friction=0.0455,
        restitution=0.0,
        bar_radius=6.64e-3,
        bar_horizontal=0.0232,
        bar_vertical=0.042,
        penetration=6.62e-3,
        knee_angle_deg=-54.1,
        knee_position=0.806,
    )
    words = ["strike", "workpart touch", "workpart release", "workpart release"]
    runs = (bs.simulate(tool, bs.Settings(accuracy=1e-8)), bs.simulate_reference(tool))
    for run in runs:
        events = [each for each in run.events if each.name in words]
        assert [each.name for each in events] == words
        assert events[1].time == events[2].time
    times = [[each.time for each in run.events if each.name in words] for run in runs]
    assert times[0] == pytest.approx(times[1], abs=1e-9)
