"""A contact point: how impulses there change the links' rates, and how the rates move it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.scene.mechanism import Complexes, Mechanism, State, Vector
from bristle_sim.scene.pairs import ClosestApproach, ContactPair

ROUNDING = 64.0 * math.ulp(1.0)
"""Ratio of a lever to the contact point's distance from the joint, and of the motion in stick to
the motion by a normal impulse, below which it is rounding error: the point cannot move so."""


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
                row[carriers] += factor * mechanism.tips[carriers] * turn[carriers]
                row[link] += factor * arm
    return rows.real, -rows.imag


class ContactPoint(NamedTuple):
    """The response of a contact point, and of the links' rates, to an impulse at this point.

    Attributes:
        touch: closest approach of link and obstacle.
        inverse_mass: contact-space inverse mass matrix K by rows, order (normal, tangential).
        response: changes of the links' rates per unit normal impulse, and per unit tangential
            impulse.
        in_stick: changes of the links' rates per unit normal impulse while the point does not slip.
        stick_compliance: change of the normal velocity per unit normal impulse while the point does
            not slip; 0 if the point cannot move.
    """

    touch: ClosestApproach
    inverse_mass: tuple[Vector, Vector]
    response: Sequence[Sequence[float]]
    in_stick: Sequence[float]
    stick_compliance: float


def contact_at(mechanism: Mechanism, state: State, pair: ContactPair) -> ContactPoint:
    """Return the closest approach of a pair in a state, and its response to an impulse there.

    With the mass matrix M = L L^T and the Jacobian J of the contact velocities, K = J M^-1 J^T. The
    motion in stick is the part of the normal's column of L^-1 J^T that is orthogonal to the
    tangent's column. It is found by orthogonal factorization with the largest rows first, which
    keeps the digits of the small rows of heavy links (Cox and Higham 1998).
    """
    touch = pair.closest(mechanism.poses(state), state.rates)
    if mechanism.single_link:
        both = 1j * touch.arm * touch.normal.conjugate()
        lever = both.real
        along = -both.imag if abs(both.imag) > ROUNDING * abs(touch.arm) else 0.0
        inertia = mechanism.links[0].inertia_about_joint
        turning = lever / inertia
        rubbing = along / inertia
        rows = ((lever * turning, lever * rubbing), (lever * rubbing, along * rubbing))
        free = 0.0 if along else turning  # without tangential motion every impulse acts as in stick
        return ContactPoint(touch, rows, ((turning,), (rubbing,)), (free,), lever * free)
    turn = np.exp(1j * np.array(state.angles))
    levers = np.concatenate(contact_rows(mechanism, turn, [pair], [touch]))
    levers[1, abs(levers[1]) <= ROUNDING * np.hypot(*levers)] = 0.0
    to_scaled = np.linalg.inv(np.linalg.cholesky(mechanism.mass_matrix(turn)))
    columns = to_scaled @ levers.T
    stick = columns[:, 0].copy()
    if levers[1].any():
        order = np.argsort(-abs(columns).max(axis=1))
        basis, triangle = np.linalg.qr(columns[order, ::-1])
        stick[order] = basis[:, 1] * triangle[1, 1]
        if np.linalg.norm(stick) <= ROUNDING * np.linalg.norm(columns[:, 0]):
            stick[:] = 0.0  # as of a straight chain, whose tip moves across it only
    first, second = (columns.T @ columns).tolist()
    return ContactPoint(
        touch,
        inverse_mass=(tuple(first), tuple(second)),
        response=(columns.T @ to_scaled).tolist(),
        in_stick=(stick @ to_scaled).tolist(),
        stick_compliance=float(stick @ stick),
    )
