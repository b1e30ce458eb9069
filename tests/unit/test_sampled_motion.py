"""Interpolation of a trajectory between its samples, against the closed form."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from bristle_sim.parameters import Tool
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import Trajectory
from bristle_sim.trajectory.sampled_motion import SampledMotion
from swinging_bristle import AMPLITUDE, FREQUENCY, HUB_START, STRIKE, make_trajectory, swing

FIELDS = [each.name for each in dataclasses.fields(Trajectory)]


@pytest.fixture(scope="module")
def run() -> Trajectory:
    return make_trajectory()


def test_motion_between_samples_is_the_cubic_that_theory_bounds(run):
    time = np.linspace(0.0, STRIKE, 1001)[1:-1]
    step = STRIKE / 59.0
    # Hermite's cubic is off by at most h^4/384 max|f''''|, here A w^4; twice that leaves room for rounding.
    bound = 2.0 * step**4 / 384.0 * AMPLITUDE * FREQUENCY**4
    assert np.abs(SampledMotion(run).retraction(time) + swing(time)[0][0]).max() < bound
    assert (
        np.abs(SampledMotion(run).hub_angle(time) - (HUB_START + 261.8 * time)).max() < 1e-12
    )  # linear: rounding alone


def test_motion_has_both_speeds_of_an_impact(run):
    motion = SampledMotion(run)
    before, after = (float(np.hypot(*run.tip_velocity[at])) for at in (59, 60))
    assert before > after
    assert motion.tip_speed(math.nextafter(STRIKE, 0.0)) == pytest.approx(before, rel=1e-9)  # samples are met: rounding
    assert motion.tip_speed(STRIKE) == pytest.approx(after, rel=1e-9)


def test_motion_stays_at_its_ends_outside_the_run(run):
    motion = SampledMotion(run)
    assert motion.retraction(-1.0) == run.retraction[0]
    assert motion.retraction([5.0, 6.0]) == pytest.approx(run.retraction[-1], rel=1e-12)
    assert motion.centre_line(5.0) == pytest.approx(run.centre_line[-1], rel=1e-12)


def test_motion_needs_two_instants(run):
    arrays = {name: getattr(run, name)[:1] for name in FIELDS if isinstance(getattr(run, name), np.ndarray)}
    single = Trajectory(**arrays, hub_speed=1.0, events=(), contacts=(), stop_reason=StopReason.END, cost=run.cost)
    with pytest.raises(ValueError, match="two instants are needed"):
        SampledMotion(single)


def test_course_keeps_every_sample_and_both_sides_of_the_impact(run):
    motion = SampledMotion(run)
    course = motion.course(points=500)
    assert np.isin(run.time, course.time).all()
    assert np.count_nonzero(course.time == STRIKE) == 2
    assert (np.diff(course.time) >= 0.0).all()
    energy = motion.along(course.time, run.total_energy)
    # Both go through the samples; between them only their spacing differs.
    assert energy[np.searchsorted(course.time, run.time[:59])] == pytest.approx(run.total_energy[:59], rel=1e-12)


def test_course_ends_where_asked_and_refuses_an_end_before_the_start(run):
    assert SampledMotion(run).course(until=1e-3).time[-1] <= 1e-3
    for until in (0.0, math.nan):
        with pytest.raises(ValueError, match="until = "):
            SampledMotion(run).course(until=until)


def test_energies_between_samples_are_as_smooth_as_the_motion():
    """Belt energy (k A^2/4)(1 + cos 2wt): a cubic spline is off by 5/384 h^4 (2w)^4 of its half size (de Boor 2001)."""
    run = make_trajectory(samples=24)
    motion = SampledMotion(run)
    time = motion.course().time
    before = time < STRIKE
    size = 0.5 * Tool().belt.stiffness * AMPLITUDE**2
    expected = size * np.cos(FREQUENCY * time[before]) ** 2
    step = STRIKE / 23.0
    # At its ends the not-a-knot condition leaves some ten times that.
    bound = 10.0 * 5.0 / 384.0 * (2.0 * FREQUENCY * step) ** 4 * 0.5 * size
    assert np.abs(motion.along(time, run.potential_energy)[before] - expected).max() < bound


def test_energies_have_their_kinks_where_contacts_begin_and_end():
    """A ramp that sets in with a sustained contact is met exactly by splines that end there."""
    run = make_trajectory()
    begin = float(run.time[20])
    held = dataclasses.replace(run.contacts[0], time=begin, duration=float(run.time[40]) - begin, law="sustained")
    motion = SampledMotion(dataclasses.replace(run, contacts=(held,)))
    time = motion.course().time
    ramp = np.clip(run.time - begin, 0.0, held.duration)
    expected = np.clip(time - begin, 0.0, held.duration)
    assert np.abs(motion.along(time, ramp) - expected).max() < 1e-15  # s; rounding of 1e-3
