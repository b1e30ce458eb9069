"""Rigid sustained contacts, against geometry and values by hand."""

import math

import pytest

from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.pairs import ClosedPair, WorkpartPair
from bristle_sim.scene.rigid import RigidContacts

ROD = Mechanism((Link.rod(2.0, 1.0),))
"""A rod that hangs from the origin: moment of inertia m/3 about the root, m/12 about the centre."""


def closed(
    mechanism: Mechanism, pair: WorkpartPair, state: State
) -> tuple[ClosedPair, RigidContacts]:
    """A closed contact, and the forces that keep it closed."""
    contact = ClosedPair(pair)
    rigid = RigidContacts(Scene(mechanism, Effects(pairs=(pair,))), [contact], paired=True)
    rigid.engage(state)
    return contact, rigid


@pytest.mark.parametrize(("rate", "sense"), [(0.5, 1), (-0.5, -1), (0.0, None)])
def test_friction_on_a_lone_link_acts_against_a_given_slip(rate: float, sense: int | None) -> None:
    """The tip of a rod at 0.7 slips by its rate times cos 0.7; at rest it has no sense."""
    state = State(0.0, (0.7,), (rate,))
    contact, rigid = closed(ROD, WorkpartPair(math.cos(0.7), 0.4, 0.4, 0.5), state)
    rigid.set_slip(state, contact, 1e-6)
    assert contact.slip == sense


def test_a_tip_without_slip_begins_to_slip_where_its_hub_carries_it() -> None:
    """Radial at 0.4 on a hub of radius 1 that turns by 2, the tip at rest on a plane: of either rounding the sense is that of its acceleration.

    With the root at (sin, -cos) psi and the rod at angle a, y = -cos psi - cos a stays, so a' = -2 sin psi/sin a = -2 at
    psi = a, and x' = 2 cos psi + a' cos a = 0 there. x'' = -4 sin psi + a'' cos a - a'^2 sin a with
    a'' sin a = -4 cos psi - a'^2 cos a: -8 (sin + cos^2/sin) = -8/sin 0.4 = -20.5.
    """
    mechanism = Mechanism((Link.rod(1.0, 1.0),), 1.0, 2.0, 0.4)
    part = WorkpartPair(2.0 * math.cos(0.4), 0.3, 0.3, 0.0)
    for rounding in (1e-8, -1e-8):
        state = State(0.0, (0.4,), (-2.0 + rounding,))
        contact, rigid = closed(mechanism, part, state)
        assert rigid.slip_acceleration(contact, state) == pytest.approx(
            -8.0 / math.sin(0.4), rel=1e-4
        )
        rigid.set_slip(state, contact, 1e-6)
        assert contact.slip == -1
