"""Gaps between links and obstacles in a given state, and the nearest state in which these gaps are
closed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.scene.mechanism import Complexes, Mechanism, State, cross
from bristle_sim.scene.pairs import ClosedPair, ClosestApproach, ContactPair

# largest distance between a contact and a link's end, over the link's length, at which the contact
# counts as a contact of that end
AT_JOINT = 1e-9

GAP_ROUNDING = 1e-11  # largest gap that counts as closed, in engine units


class Gaps:
    """Computes gaps, closest approaches and positions of a mechanism's links in any state."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism

    def closest(self, pair: ContactPair, state: State, piece: int | None = None) -> ClosestApproach:
        """Return the closest approach of a pair; ``piece`` restricts it to one straight segment of
        the link, by index.
        """
        return pair.closest(self.mechanism.poses(state), state.rates, piece)

    def gap(self, pair: ContactPair, state: State) -> float:
        """Return the distance between a pair's link and obstacle, in engine units; it is negative
        where they overlap.
        """
        return pair.closest(self.mechanism.poses(state), state.rates).gap

    def along(self, pair: ContactPair, state: State) -> float:
        """Return the x coordinate of the pair's contact point (along the workpart), in engine
        units.
        """
        poses = self.mechanism.poses(state)
        return (poses[pair.link].joint + pair.closest(poses, state.rates).arm).real


LEAST_LEVER = 1e-6
"""Shortest lever of the contact normal about the link's joint, over the link's length, with which a
rotation of the link can close a gap."""

CLOSED_GAP = 1e-10
"""Gap, over the link's length, below which Newton's method ends: a further iteration would change
the angular velocity by less than any requested accuracy."""

# iterations of Newton's method: an error of 1e-3 falls to 1e-6, 1e-12 and then rounding error
NEWTON_ROUNDS = 3


def contact_rows(
    mechanism: Mechanism,
    turn: Complexes,
    contacts: Sequence[ClosedPair],
    touches: Sequence[ClosestApproach],
) -> tuple[Array, Array]:
    """Return the Jacobians of the contacts' relative velocities, along the normals and along the
    tangents.

    Each Jacobian d(velocity)/d(angular velocities) has the shape (contacts, links).

    Args:
        mechanism: the mechanism.
        turn: e^{i angle} of each link, with its absolute angle.
        contacts: the closed contacts.
        touches: closest approach of each contact.

    The angular velocity of the touching link enters with the arm from its joint to the contact
    point. The angular velocity of a link nearer the root enters with the arm from that link's joint
    to its tip. The lever of the normal n about the start of an arm r is Re(i conj(n) r); the lever
    of the tangent is -Im(i conj(n) r).
    """
    rows = np.zeros((len(contacts), len(turn)), complex)
    for row, (pair, _, _), touch in zip(rows, contacts, touches, strict=True):
        across = 1j * touch.normal.conjugate()
        for link, arm, factor in (
            (pair.link, touch.arm, across),
            (pair.partner, touch.partner_arm, -across),
        ):
            if link is not None and arm is not None:
                carriers = slice(link - link % mechanism.wire_links, link)
                row[carriers] += factor * mechanism.constants.tips[carriers] * turn[carriers]
                row[link] += factor * arm
    return rows.real, -rows.imag


def set_back(gaps: Gaps, contacts: Sequence[ClosedPair], state: State) -> State:
    """Return the nearest state in which all contacts are closed and their gaps do not change, by
    Newton's method.

    The distance between states is measured by the mass matrix M. With the Jacobian J of the
    contacts and their gaps g, the angles change by -M^-1 J^T (J M^-1 J^T)^-1 g. The angular
    velocities change by the same expression with the normal velocities for g. In contacts that
    stick the slip velocity is removed too.
    """
    mechanism = gaps.mechanism
    stuck = [index for index, each in enumerate(contacts) if each.slip == 0]
    for _ in range(NEWTON_ROUNDS):
        turn = np.exp(1j * np.array(state.angles))
        touches = [gaps.closest(each.pair, state, each.piece) for each in contacts]
        normals, tangents = contact_rows(mechanism, turn, contacts, touches)
        speeds, slips = np.array([touch.velocity for touch in touches]).T
        mass = mechanism.mass_matrix(turn)
        angles = _nearest(mass, normals, [touch.gap for touch in touches])
        rates = _nearest(mass, np.array([*normals, *tangents[stuck]]), [*speeds, *slips[stuck]])
        state = State(
            state.time,
            tuple(a - b for a, b in zip(state.angles, angles, strict=True)),
            tuple(a - b for a, b in zip(state.rates, rates, strict=True)),
        )
    return state


def _nearest(mass: Array, rows: Array, amounts: Sequence[float]) -> list[float]:
    """Return the change of smallest norm, measured by the mass matrix, whose product with ``rows``
    is ``amounts``.
    """
    response = np.linalg.solve(mass, rows.T)
    found = np.linalg.lstsq(rows @ response, np.array(amounts), rcond=1e-12)[0]
    changes: list[float] = (response @ found).tolist()
    return changes


def turned_back(gaps: Gaps, pair: ContactPair, state: State, piece: int | None = None) -> State:
    """Return the state of a single link after a rotation that closes a pair's gap and stops the
    gap's change.
    """
    (angle,), (rate,) = state.angles, state.rates
    for _ in range(NEWTON_ROUNDS):
        placed = State(state.time, (angle,), (rate,))
        touch = pair.closest(gaps.mechanism.poses(placed), placed.rates, piece)
        lever = cross(touch.arm, touch.normal)
        if abs(lever) < LEAST_LEVER:
            return state
        angle -= touch.gap / lever
        rate -= touch.velocity[0] / lever
        if abs(touch.gap) < CLOSED_GAP:
            break
    return State(state.time, (angle,), (rate,))


MOMENT = 1e-6
"""Time step, in engine units, after which the slip velocity of a single link is computed again, to
obtain its acceleration."""


def slip_acceleration(gaps: Gaps, pair: ContactPair, state: State) -> float:
    """Return the tangential acceleration of the contact point of a single link that stays on its
    obstacle, in engine units.
    """
    slips = []
    for time in (0.0, MOMENT):
        angles = tuple(
            angle + time * rate for angle, rate in zip(state.angles, state.rates, strict=True)
        )
        placed = turned_back(gaps, pair, State(state.time + time, angles, state.rates))
        slips.append(gaps.closest(pair, placed).velocity[1])
    return (slips[1] - slips[0]) / MOMENT


def opening_rate(first: ClosestApproach, second: ClosestApproach) -> float:
    """Return the rate at which the clearance between two contacts of one link grows; a negative
    rate wedges the link.

    Each contact's normal velocity is drift + lever * rate, where the drift is the part from the
    motion of the joint and the rate is the link's angular velocity. If the levers have opposite
    signs, one rate can make both velocities positive only if the sum of drift / abs(lever) is
    positive; the rate cancels in this sum, which is returned. If the levers have the same sign, the
    result is infinite.
    """
    levers = [cross(touch.arm, touch.normal) for touch in (first, second)]
    if levers[0] * levers[1] >= 0.0:
        return math.inf
    return first.velocity[0] / abs(levers[0]) + second.velocity[0] / abs(levers[1])
