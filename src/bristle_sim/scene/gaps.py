"""Gaps between a mechanism's links and pairs in a given state, and the nearest state in which they are closed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.scene.mechanism import Complexes, Mechanism, Pose, State, Vector, cross
from bristle_sim.scene.pairs import ClosestApproach, ContactPair

AT_JOINT = 1e-9  # fraction of a link within which a foot on it is at its end

GAP_ROUNDING = 1e-11  # a gap of the scene's unit below this is closed


class Gaps:
    """Gaps, touches and poses of a mechanism's links at any state."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism

    def closest(self, pair: ContactPair, state: State, piece: int | None = None) -> ClosestApproach:
        """Return the closest approach of link and pair; a named piece restricts it to that part of the link."""
        return pair.closest(self.mechanism.poses(state), state.rates, piece)

    def gap(self, pair: ContactPair, state: State) -> float:
        """Return the distance of link and pair, negative inside."""
        return self.closest(pair, state).gap

    def along(self, pair: ContactPair, state: State) -> float:
        """Return the place of a corner along the workpart, +x."""
        poses = self.mechanism.poses(state)
        return poses[pair.link].joint[0] + pair.closest(poses, state.rates).arm[0]

    def gap_and_rate(self, pair: ContactPair, state: State) -> tuple[float, float]:
        """Return the distance of link and pair, and its rate."""
        touch = self.closest(pair, state)
        return touch.gap, touch.velocity[0]

    def poses(self, state: State) -> list[Pose]:
        """Return the position and motion of every link."""
        return self.mechanism.poses(state)


LEAST_LEVER = 1e-6
"""Shortest lever of the contact normal, as a fraction of the link, with which turning a link can set it back."""

CLOSED_GAP = 1e-10
"""A gap below this fraction of the link counts as closed: closing it changes the rate by as little, less than any accuracy."""

NEWTON_ROUNDS = 3  # rounds of Newton's method that set links back: an error of 1e-3 is 1e-6, 1e-12 and then rounding


def contact_row(
    mechanism: Mechanism,
    turn: Complexes,
    pair: ContactPair,
    touch: ClosestApproach,
    direction: Vector,
) -> Array:
    """Return d(relative velocity of a contact along a direction)/d(rates), shape (links,); ``turn`` is e^{i angle} of each link.

    A link's rate moves the contact by the lever of the link's tip, for a link that carries the touching one, or of the contact itself.
    """
    row = np.zeros(len(turn))
    for link, arm, sign in (
        (pair.link, touch.arm, 1.0),
        (pair.partner, touch.partner_arm, -1.0),
    ):
        if link is not None and arm is not None:
            carriers = slice(link - link % mechanism.wire_links, link)
            reaches = mechanism.constants.tips[carriers] * turn[carriers]
            row[carriers] += (sign * 1j * complex(direction[0], -direction[1]) * reaches).real
            row[link] += sign * cross(arm, direction)
    return row


def set_back(
    gaps: Gaps,
    pairs: Sequence[ContactPair],
    state: State,
    pieces: Sequence[int | None] | None = None,
    slips: Sequence[int | None] = (),
) -> State:
    """Return the nearest state in which all contacts are closed and stay closed.

    By Newton's method; nearest in the norm of the kinetic energy: the change is M^-1 J^T (J M^-1 J^T)^-1 times the error of the
    gaps and of their rates. Contacts that stick get no slip velocity either.
    """
    pieces = pieces or [None] * len(pairs)
    mechanism = gaps.mechanism
    for _ in range(NEWTON_ROUNDS):
        poses = mechanism.poses(state)
        turn = np.exp(1j * np.array(state.angles))
        touches = [
            each.closest(poses, state.rates, piece)
            for each, piece in zip(pairs, pieces, strict=True)
        ]
        stuck = [index for index, each in enumerate(slips) if each == 0]
        across = [
            contact_row(mechanism, turn, o, t, t.normal)
            for o, t in zip(pairs, touches, strict=True)
        ]
        along = [
            contact_row(mechanism, turn, pairs[i], touches[i], touches[i].tangent) for i in stuck
        ]
        mass = mechanism.mass_matrix(turn)
        angles = _nearest(mass, np.array(across), [touch.gap for touch in touches])
        speeds = [touch.velocity[0] for touch in touches] + [touches[i].velocity[1] for i in stuck]
        rates = _nearest(mass, np.array([*across, *along]), speeds)
        state = State(
            state.time,
            tuple(a - b for a, b in zip(state.angles, angles, strict=True)),
            tuple(a - b for a, b in zip(state.rates, rates, strict=True)),
        )
    return state


def _nearest(mass: Array, rows: Array, amounts: Sequence[float]) -> list[float]:
    """Return the smallest change, in the norm of the mass matrix, whose product with the rows equals the amounts."""
    response = np.linalg.solve(mass, rows.T)
    found = np.linalg.lstsq(rows @ response, np.array(amounts), rcond=1e-12)[0]
    changes: list[float] = (response @ found).tolist()
    return changes


def turned_back(gaps: Gaps, pair: ContactPair, state: State, piece: int | None = None) -> State:
    """Turn a single link back onto a pair."""
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
"""Time (scene units) after which the touching piece, and a single link's slip, are looked up again."""


def slip_acceleration(gaps: Gaps, pair: ContactPair, state: State) -> float:
    """Return the tangential acceleration of the contact point of a single link that stays on a pair."""
    slips = []
    for time in (0.0, MOMENT):
        angles = tuple(
            angle + time * rate for angle, rate in zip(state.angles, state.rates, strict=True)
        )
        placed = turned_back(gaps, pair, State(state.time + time, angles, state.rates))
        slips.append(gaps.closest(pair, placed).velocity[1])
    return (slips[1] - slips[0]) / MOMENT


def opening_rate(first: ClosestApproach, second: ClosestApproach) -> float:
    """Return the rate at which the clearance between two contacts on one link grows; negative means that they wedge it.

    Each normal velocity is drift + lever * rate. With levers of opposite signs, both can be positive for the same rate only if
    the sum of drift / abs(lever), in which the rate cancels, is positive. Infinite for levers of the same sign.
    """
    levers = [cross(touch.arm, touch.normal) for touch in (first, second)]
    if levers[0] * levers[1] >= 0.0:
        return math.inf
    return first.velocity[0] / abs(levers[0]) + second.velocity[0] / abs(levers[1])
