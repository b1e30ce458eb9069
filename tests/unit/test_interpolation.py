"""The motion between samples: of a run in closed form, of runs sampled more closely, stopped there, or more accurate."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from bristle_sim.parameters import Contact, Hub, Tool
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings
from bristle_sim.trajectory import Trajectory
from bristle_sim.trajectory.interpolation import integral
from bristle_sim.trajectory.records import SAMPLED
from swinging_bristle import AMPLITUDE, FREQUENCY, HUB_START, STRIKE, make_trajectory, swing


@pytest.fixture(scope="module")
def swung() -> Trajectory:
    """A run in closed form."""
    return make_trajectory()


@pytest.fixture(scope="module")
def run() -> Trajectory:
    """A whole pass of the default tool."""
    return simulate(Tool())


def test_motion_between_samples_is_the_polynomial_that_theory_bounds(swung: Trajectory):
    """Hermite's polynomial through n samples and slopes is off by |f^(2n)|/(2n)! times the squared product of the distances.

    From the ends inwards those are least for n = 8 samples, h, 2h, ...; with n = 4 alone it would be below 1e-9 rad.
    """
    time = np.linspace(0.0, STRIKE, 1001)[1:-1]
    found = swung.at(time)
    assert (
        np.abs(found.retraction + swing(time)[0][0]).max() < 1e-13 * 10.0
    )  # rounding of angles near 1, of 15 terms
    assert np.abs(found.relative_rate - swing(time)[0][1]).max() < 1e-9 * AMPLITUDE * FREQUENCY
    assert (
        np.abs(found.hub_angle - (HUB_START + 261.8 * time)).max() < 1e-12
    )  # linear: rounding alone


def test_forces_and_energies_have_their_kinks_where_contacts_begin_and_end():
    """A ramp that sets in with a sustained contact is met exactly by splines that end there; a force is none outside."""
    run = make_trajectory()
    begin, end = run.time[[20, 40]]
    held = dataclasses.replace(run.contacts[0], time=begin, duration=end - begin, law="sustained")
    ramp = np.clip(run.time - begin, 0.0, end - begin)
    run = dataclasses.replace(run, contacts=(held,), potential_energy=ramp, normal_force=1.0 + ramp)
    time = np.setdiff1d(np.linspace(*run.time[[0, -1]], 700), run.time)
    found = run.at(time)
    inside = (time > begin) & (time < end)
    assert (
        np.abs(found.potential_energy - np.clip(time - begin, 0.0, end - begin)).max() < 1e-15
    )  # rounding of 1e-3 s
    assert found.normal_force[inside] == pytest.approx(1.0 + time[inside] - begin, rel=1e-14)
    assert not found.normal_force[~inside].any()


def test_a_course_keeps_every_sample_and_both_sides_of_an_impact(swung: Trajectory):
    course = swung.course(points=500)
    assert (np.diff(course.time) >= 0.0).all()
    for name in SAMPLED:
        at_samples = getattr(course, name)[np.isin(course.time, swung.time)]
        np.testing.assert_allclose(
            at_samples, getattr(swung, name), rtol=1e-12, atol=1e-15, err_msg=name
        )
    assert swung.course(until=1e-3).time[-1] <= 1e-3
    for until in (0.0, np.nan):
        with pytest.raises(ValueError, match="until = "):
            swung.course(until=until)


@pytest.mark.parametrize(
    "tool",
    [Tool(hub=Hub(speed=400.0)), Tool(bristle=dataclasses.replace(Tool().bristle, length=0.03))],
    ids=["fast hub", "bar passes the wire's end"],
)
def test_motion_between_samples_is_that_of_a_run_stopped_there(tool: Tool):
    """Both have accuracy 1e-6: of rates relative to the largest, of angles relative to a radian."""
    run = simulate(tool)
    strike = run.event_time("strike")
    assert strike is not None
    release = run.event_time("bar release", last=True, before=strike)
    assert release is not None
    close = np.random.default_rng(2).uniform(release - 3e-4, release, 8)
    for time in (
        *close,
        0.5 * release,
        release + 2e-5,
        0.5 * (release + strike),
        strike - 1e-7,
        strike + 1e-7,
    ):
        stopped = simulate(tool, Settings(hub_turn=tool.hub.speed * time))
        found = run.at(stopped.time[-1])
        np.testing.assert_allclose(found.angles, stopped.angles[-1], rtol=0.0, atol=1e-6)
        np.testing.assert_allclose(
            found.rates, stopped.rates[-1], rtol=0.0, atol=1e-6 * np.abs(run.rates).max()
        )
        size = np.abs(run.centre_line).max()
        np.testing.assert_allclose(
            found.centre_line, stopped.centre_line[-1], rtol=0.0, atol=1e-6 * size
        )


def test_a_hop_of_one_interval_has_samples_enough_for_a_fine_run():
    """Between the third and the fourth touch of the workpart; a polynomial through both ends and the middle is off by 2e-8."""
    fine = Settings(accuracy=1e-8)
    run = simulate(Tool(), fine)
    touches = [contact.time for contact in run.contacts if contact.obstacle == "workpart"]
    for part in (0.1, 0.3, 0.7, 0.9):
        time = touches[2] + part * (touches[3] - touches[2])
        turn = run.hub_speed * time
        stopped = simulate(Tool(), dataclasses.replace(fine, hub_turn=turn))
        found = run.at(stopped.time[-1])
        off = np.abs(found.rates - stopped.rates[-1]).max()
        assert off <= 1e-8 * np.abs(run.rates).max()


def test_motion_at_an_impact_has_two_sides(run: Trajectory):
    strike = run.first_contact("workpart")
    assert strike is not None
    before, after = run.at(strike.time, side="before"), run.at(strike.time)
    # Rounding of units and of the polynomial.
    assert before.rates[0] == pytest.approx(strike.rates_before[0], rel=1e-12)
    assert after.rates[0] == pytest.approx(strike.rates_after[0], rel=1e-12)
    assert before.angles[0] == pytest.approx(strike.angles[0], rel=1e-12)
    assert before.angles == pytest.approx(after.angles, rel=1e-12)
    # The tip's normal velocity is vertical.
    assert before.tip_velocity == pytest.approx(
        [strike.velocity_before[1], strike.velocity_before[0]], rel=1e-9
    )


def test_motion_in_a_contact_resolved_in_time_is_that_of_a_more_accurate_run():
    """Whose record tells the tip's velocity in the contact, at instants between the samples of the other run."""
    tool = Tool(contact=Contact("compliant", 1e-4))
    run = simulate(tool)
    fine = simulate(tool, Settings(accuracy=1e-9), stop_after="strike")
    own = run.first_contact("workpart")
    strike = fine.first_contact("workpart")
    assert own is not None
    assert strike is not None
    history = strike.history
    assert history is not None
    time = history.time + (own.time - strike.time)
    inside = slice(1, -1)
    during = run.at(time[inside])
    speed = np.hypot(*strike.velocity_before)
    # Both have accuracy 1e-6 or better, relative to the approach and to the depth.
    np.testing.assert_allclose(
        during.tip_velocity[:, 1], history.normal_velocity[inside], rtol=0.0, atol=1e-6 * speed
    )
    np.testing.assert_allclose(
        during.tip_velocity[:, 0], history.tangential_velocity[inside], rtol=0.0, atol=1e-6 * speed
    )
    np.testing.assert_allclose(
        during.normal_force,
        history.normal_force[inside],
        rtol=0.0,
        atol=1e-6 * history.normal_force.max(),
    )
    depth = during.tip[:, 1] - run.at(own.time).tip[1]
    np.testing.assert_allclose(
        -depth, history.penetration[inside], rtol=0.0, atol=1e-6 * history.penetration.max()
    )


def test_three_samples_an_instant_apart_have_the_integral_of_a_parabola():
    """Three samples of 2 + s - 6 s^2, with s in 1e-18 s: the integral is 2 s + s^2/2 - 2 s^3."""
    s = np.array([0.0, 1.0, 4.0])
    expected = 2.0 * s + 0.5 * s**2 - 2.0 * s**3
    found = integral(1e-18 * s, 2.0 + s - 6.0 * s**2)
    assert found == pytest.approx(1e-18 * expected, rel=1e-14, abs=0.0)


@pytest.mark.parametrize(
    "time", [-1e-9, 1.0, np.nan, [0.0, np.inf], "1 ms", 1j, [[0.0], [0.0, 0.001]]]
)
def test_motion_outside_the_run_is_refused(run: Trajectory, time):
    with pytest.raises(
        ValueError, match=r"^time = [^\n]*: must be from 0.0 to 0\.0\d+, within the run \(in s\)$"
    ):
        run.at(time)


def test_an_instant_just_past_the_end_differs_from_the_end_in_the_message(run: Trajectory):
    past = np.nextafter(run.time[-1], np.inf)
    with pytest.raises(ValueError, match=f"^time = {past}: must be from 0.0 to {run.time[-1]},"):
        run.at(past)


@pytest.mark.parametrize("points", [-1, 2.5, "3", 10**9])
def test_the_number_of_points_of_a_course_is_checked(run: Trajectory, points):
    with pytest.raises(ValueError, match=r"^points = [^\n]*: must be a whole number from 0 to"):
        run.course(points=points)
