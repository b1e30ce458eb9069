"""Gaps between a mechanism's links and pairs in a given state, and the nearest state in which they are closed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.scene.mechanism import Complexes, Mechanism, Pose, State, cross
from bristle_sim.scene.pairs import ClosedPair, ClosestApproach, ContactPair

# largest distance from a link's end, over the link's length, at which a contact is at that end
AT_JOINT = 1e-9

GAP_ROUNDING = 1e-11  # largest gap that counts as closed, in the scene's unit of length


class Gaps:
    """Gaps, closest approaches and poses of a mechanism's links in any state."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism

    def closest(self, pair: ContactPair, state: State, piece: int | None = None) -> ClosestApproach:
        """Return the closest approach of a pair; ``piece`` restricts it to one straight piece of
        the link.
        """
        return pair.closest(self.mechanism.poses(state), state.rates, piece)

    def gap(self, pair: ContactPair, state: State) -> float:
        """Return the distance between a pair's link and obstacle, negative where they overlap."""
        return self.closest(pair, state).gap

    def along(self, pair: ContactPair, state: State) -> float:
        """Return the x coordinate of the pair's contact point, along the workpart."""
        poses = self.mechanism.poses(state)
        return poses[pair.link].joint[0] + pair.closest(poses, state.rates).arm[0]

    def gap_and_rate(self, pair: ContactPair, state: State) -> tuple[float, float]:
        """Return a pair's gap and its rate of change."""
        touch = self.closest(pair, state)
        return touch.gap, touch.velocity[0]

    def poses(self, state: State) -> list[Pose]:
        """Return the position and motion of every link."""
        return self.mechanism.poses(state)


LEAST_LEVER = 1e-6
"""Shortest lever of the contact normal, over the link's length, at which turning the link can close
a gap."""

CLOSED_GAP = 1e-10
"""Gap, over the link's length, below which no further round of Newton's method is needed: it would
change the rate by less than any accuracy."""

# rounds of Newton's method: an error of 1e-3 falls to 1e-6, 1e-12 and then rounding
NEWTON_ROUNDS = 3


def contact_rows(
    mechanism: Mechanism,
    turn: Complexes,
    contacts: Sequence[ClosedPair],
    touches: Sequence[ClosestApproach],
) -> tuple[Array, Array]:
    """Return the rows d(relative velocity)/d(rates) of the contacts along their normals and along
    their tangents, each of shape (contacts, links).

    The rate of the touching link acts by the lever of the contact point about the link's joint; the
    rate of a link that carries it acts by the lever of the link's tip. With points as complex
    numbers, the lever of the normal n about the start of an arm r is Re(i conj(n) r), that of the
    tangent -Im(i conj(n) r). ``turn`` is e^{i angle} of each link.
    """
    rows = np.zeros((len(contacts), len(turn)), complex)
    for row, (pair, _, _), touch in zip(rows, contacts, touches, strict=True):
        across = 1j * complex(*touch.normal).conjugate()
        for link, arm, factor in (
            (pair.link, touch.arm, across),
            (pair.partner, touch.partner_arm, -across),
        ):
            if link is not None and arm is not None:
                carriers = slice(link - link % mechanism.wire_links, link)
                row[carriers] += factor * mechanism.constants.tips[carriers] * turn[carriers]
                row[link] += factor * complex(*arm)
    return rows.real, -rows.imag


def set_back(gaps: Gaps, contacts: Sequence[ClosedPair], state: State) -> State:
    """Return the nearest state in which all contacts are closed and stay closed, by Newton's
    method.

    Nearest is meant in the norm of the kinetic energy: the change is M^-1 J^T (J M^-1 J^T)^-1 times
    the gaps and their rates. In contacts that stick the slip velocity is removed too.
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
    """Return the smallest change, in the norm of the mass matrix, whose product with ``rows`` is
    ``amounts``.
    """
    response = np.linalg.solve(mass, rows.T)
    found = np.linalg.lstsq(rows @ response, np.array(amounts), rcond=1e-12)[0]
    changes: list[float] = (response @ found).tolist()
    return changes


def turned_back(gaps: Gaps, pair: ContactPair, state: State, piece: int | None = None) -> State:
    """Return the state of a single link turned until the pair's gap is closed and stays closed."""
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
"""Time, in scene units, after which the touching piece and a single link's slip are computed again,
to tell how they change."""


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
    """Return the rate at which the clearance between two contacts of one link grows; a negative
    rate wedges the link.

    Each contact's normal velocity is drift + lever * rate. With levers of opposite signs, one rate
    can make both velocities positive only if the sum of drift / abs(lever), in which the rate
    cancels, is positive. The result is infinite for levers of the same sign.
    """
    levers = [cross(touch.arm, touch.normal) for touch in (first, second)]
    if levers[0] * levers[1] >= 0.0:
        return math.inf
    return first.velocity[0] / abs(levers[0]) + second.velocity[0] / abs(levers[1])
