"""The motion in a contact passes its record, and goes on freely before and after."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bristle_sim.parameters import Surface
from bristle_sim.render.contact_motion import ContactMotion, contact_motion
from bristle_sim.studies.impacts import Impacts
from impact_cases import TRAPEZOIDAL, bristle, rods


def test_motion_passes_the_record(pendulum: Impacts, pendulum_motion: ContactMotion) -> None:
    history = pendulum.strikes["compliant"].contact.history
    assert history is not None
    for name in ("normal_velocity", "tangential_velocity", "normal_force", "tangential_force"):
        np.testing.assert_array_equal(getattr(pendulum_motion, name)[2:-2], getattr(history, name))


def test_motion_before_and_after_is_free(strike: Impacts, strike_motion: ContactMotion) -> None:
    contact = strike.strikes["compliant"].contact
    start, end = strike_motion.time[0], strike_motion.time[-1]
    assert start < 0.0 < strike_motion.touch_end < end
    assert strike_motion.touch_end == pytest.approx(contact.duration)
    for instant, velocity in ((start, contact.velocity_before), (end, contact.velocity_after)):
        assert strike_motion.at("normal_force", instant) == 0.0
        assert strike_motion.at("normal_velocity", instant) == pytest.approx(velocity[0])
        assert strike_motion.at("tangential_velocity", instant) == pytest.approx(velocity[1])
    assert strike_motion.at("depth", start) == pytest.approx(contact.velocity_before[0] * -start)
    risen = strike_motion.at("depth", strike_motion.touch_end) - strike_motion.at("depth", end)
    assert risen == pytest.approx(contact.velocity_after[0] * (end - strike_motion.touch_end))


def test_motion_of_one_degree_of_freedom_is_on_one_line(strike_motion: ContactMotion) -> None:
    """The bristle's tip moves along (cos gamma, -sin gamma) all the time (eq. 2.24)."""
    depth = strike_motion.along * math.tan(math.radians(23.4))
    # The way along is summed by the trapezoidal rule.
    np.testing.assert_allclose(strike_motion.depth, depth, atol=TRAPEZOIDAL * np.ptp(strike_motion.depth))


def test_phases_of_the_motions(strike_motion: ContactMotion, pendulum_motion: ContactMotion) -> None:
    assert [phase.caption for phase in strike_motion.phases] == [
        "the tip arrives",
        "compression slip",
        "restitution reverse slip",
        "rebound",
    ]
    assert [phase.caption for phase in pendulum_motion.phases][1:-1] == [
        "compression slip",
        "restitution slip",
        "restitution reverse slip",
    ]
    stop = pendulum_motion.slip_stop
    assert stop == pendulum_motion.phases[3].start
    arrival = pendulum_motion.tangential_velocity[0]
    assert abs(pendulum_motion.at("tangential_velocity", stop)) < 1e-6 * arrival
    # Friction opposes slip: its jump there is twice mu times the normal force.
    jump = np.diff(pendulum_motion.tangential_force).max()
    assert jump == pytest.approx(2.0 * 0.5 * pendulum_motion.at("normal_force", stop), rel=1e-6)


def test_motion_that_ends_in_stick_and_in_stiction() -> None:
    sticking = contact_motion(rods(Surface(friction=0.7, restitution=0.5)).strikes["compliant"].contact)
    assert sticking.phases[-2].caption == "restitution stick"
    stuck = contact_motion(bristle(friction=0.6).strikes["compliant"].contact)
    assert stuck.phases[-1].caption == "stiction: the tip stays"
    assert stuck.at("depth", stuck.time[-1]) == stuck.at("depth", stuck.touch_end)
    assert stuck.at("normal_force", stuck.time[-1]) > 0.0


def test_no_motion_of_an_instantaneous_contact(strike: Impacts) -> None:
    with pytest.raises(ValueError, match="there is no motion in time"):
        contact_motion(strike.strikes["energetic"].contact)
