"""Rigid sustained contacts, against geometry and values by hand."""

import math

import pytest

from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.contact.gaps import Gaps, slip_acceleration
from bristle_sim.scene.contact.obstacles import BarObstacle, WorkpartObstacle
from bristle_sim.scene.contact.rigid import RigidContacts, rigid_contacts, sense_of_slip
from bristle_sim.scene.contact.sustained import Sustained
from bristle_sim.scene.mechanism import Link, Mechanism, State

ROD = Mechanism((Link.rod(2.0, 1.0),))
"""A rod that hangs from the origin: moment of inertia m/3 about the root, m/12 about the centre."""


def gaps_at(angle: float, rate: float) -> tuple[Gaps, State]:
    state = State(0.0, (angle,), (rate,))
    return Gaps(ROD), state


def on_workpart(angle: float, friction: float) -> RigidContacts:
    """The rod's tip on the workpart."""
    obstacle = WorkpartObstacle(math.cos(angle), friction, friction, 0.5)
    return rigid_contacts(Scene(ROD, Effects(obstacles=(obstacle,))), [obstacle], [None])


def beside_bar(angle: float, along: float) -> RigidContacts:
    """The rod, at an angle, against a bar of reach 0.1 at a distance along it, on the side of larger angles."""
    direction = (math.sin(angle), -math.cos(angle))
    across = (math.cos(angle), math.sin(angle))
    centre = (along * direction[0] + 0.1 * across[0], along * direction[1] + 0.1 * across[1])
    obstacle = BarObstacle(centre, 0.1, 0.0, 0.0, 0.5)
    return rigid_contacts(Scene(ROD, Effects(obstacles=(obstacle,))), [obstacle], [None])


class TestSetBack:
    """Newton's method ends after three rounds: 1e-3 off is 1e-6, 1e-12 and then rounding."""

    @pytest.mark.parametrize("off", [1e-3, -1e-3])
    def test_onto_the_workpart_and_a_bar(self, off: float) -> None:
        """The tip is at -cos of the angle, and does not move along the normal where the rate is 0."""
        for contact in (on_workpart(0.7, 0.0), beside_bar(0.7, 0.6)):
            found = contact.set_back(Gaps(ROD), State(1.5, (0.7 + off,), (0.2,)))
            assert found.time == 1.5
            assert found.angles[0] == pytest.approx(0.7, abs=1e-13)
            assert found.rates[0] == pytest.approx(0.0, abs=1e-13)


@pytest.mark.parametrize(("rate", "sense"), [(0.5, 1), (-0.5, -1), (0.0, None)])
def test_friction_on_a_lone_link_acts_against_a_given_slip(rate: float, sense: int | None) -> None:
    """The tip of a rod at 0.7 slips by its rate times cos 0.7; at rest it has no sense."""
    state = State(0.0, (0.7,), (rate,))
    assert sense_of_slip(Gaps(ROD), WorkpartObstacle(math.cos(0.7), 0.4, 0.4, 0.5), state, 1e-6) == sense


def test_a_tip_without_slip_begins_to_slip_where_its_hub_carries_it() -> None:
    """Radial at 0.4 on a hub of radius 1 that turns by 2, the tip at rest on a plane: of either rounding the sense is that of its acceleration.

    With the root at (sin, -cos) psi and the rod at angle a, y = -cos psi - cos a stays, so a' = -2 sin psi/sin a = -2 at
    psi = a, and x' = 2 cos psi + a' cos a = 0 there. x'' = -4 sin psi + a'' cos a - a'^2 sin a with
    a'' sin a = -4 cos psi - a'^2 cos a: -8 (sin + cos^2/sin) = -8/sin 0.4 = -20.5.
    """
    mechanism = Mechanism((Link.rod(1.0, 1.0),), 1.0, 2.0, 0.4)
    part = WorkpartObstacle(2.0 * math.cos(0.4), 0.3, 0.3, 0.0)
    for rounding in (1e-8, -1e-8):
        state = State(0.0, (0.4,), (-2.0 + rounding,))
        assert slip_acceleration(Gaps(mechanism), part, state) == pytest.approx(-8.0 / math.sin(0.4), rel=1e-4)
        assert sense_of_slip(Gaps(mechanism), part, state, 1e-6) == -1


def test_record_of_a_sustained_contact() -> None:
    """Slip of a tip at 0.7 is the rate times cos 0.7; the normal velocity is 0 by definition."""
    obstacle = WorkpartObstacle(math.cos(0.7), 0.4, 0.4, 0.5)
    first, last = State(1.0, (0.7,), (0.5,)), State(1.5, (0.7,), (-0.25,))
    contact = Sustained(obstacle)
    contact.begin(first)
    contact.add(0.0, (3.0, -1.0, 0.0, -0.2), 0.5)
    record = contact.record(Gaps(ROD), last, "released")
    assert record is not None
    assert contact.record(Gaps(ROD), first, "released") is None
    assert (record.obstacle, record.law, record.outcome) == ("workpart", "sustained", "released")
    assert (record.time, record.duration, record.impulse) == (1.0, 0.5, (3.0, -1.0))
    assert record.compressive_work == (0.0, -0.2)
    assert record.compressive_impulse is record.restitutive_work is None
    assert record.velocity_before == (0.0, pytest.approx(0.5 * math.cos(0.7), rel=1e-15))
    assert record.velocity_after == (0.0, pytest.approx(-0.25 * math.cos(0.7), rel=1e-15))
    assert (record.angles, record.rates_before, record.rates_after) == ((0.7,), (0.5,), (-0.25,))
