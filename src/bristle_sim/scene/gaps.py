"""Gaps between links and obstacles in a given state, and how the links' rates change them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.scene.mechanism import Complexes, Mechanism, State, cross
from bristle_sim.scene.pairs import ClosestApproach, ContactPair

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


def contact_rows(
    mechanism: Mechanism,
    turn: Complexes,
    pairs: Sequence[ContactPair],
    touches: Sequence[ClosestApproach],
) -> tuple[Array, Array]:
    """Return the Jacobians of the contacts' relative velocities, along the normals and along the
    tangents.

    Each Jacobian d(velocity)/d(angular velocities) has the shape (pairs, links).

    Args:
        mechanism: the mechanism.
        turn: e^{i angle} of each link, with its absolute angle.
        pairs: the pairs in contact.
        touches: closest approach of each pair.

    The angular velocity of the touching link enters with the arm from its joint to the contact
    point. The angular velocity of a link nearer the root enters with the arm from that link's joint
    to its tip. The lever of the normal n about the start of an arm r is Re(i conj(n) r); the lever
    of the tangent is -Im(i conj(n) r).
    """
    rows = np.zeros((len(pairs), len(turn)), complex)
    for row, pair, touch in zip(rows, pairs, touches, strict=True):
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
