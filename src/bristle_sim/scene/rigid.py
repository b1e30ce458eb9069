"""Rigid sustained contacts: their forces, impulses and work, and when they must open or slip.

The solver of the joints keeps these contacts closed. A single link has one degree of freedom, so
one contact at a time fixes its motion, which follows from the geometry and the hub's motion alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import mul

import numpy as np

from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact import NUMBERS, sums_of
from bristle_sim.scene.gaps import (
    MOMENT,
    Gaps,
    contact_rows,
    set_back,
    slip_acceleration,
    turned_back,
)
from bristle_sim.scene.mechanism import State, cross
from bristle_sim.scene.pairs import ClosedPair, ContactPair

LEAST_SLIP = 1e-9
"""Least slip velocity whose sense is known, in scene units, however accurate the simulation is."""

LEAST_ACCELERATION = 1e-7
"""Least slip acceleration whose sense is known, in scene units. A smaller one is rounding error of
the difference quotient over the time ``MOMENT``."""


class RigidContacts:
    """The rigid contacts of a smooth motion, whose forces are solved for together with the joints.

    The motion ends when the normal force of a contact reaches zero. With ``paired`` true each force
    is the mean of two time-symmetric steps, in which the errors of odd and even steps cancel.

    Attributes:
        scene: the scene.
        closed: the contacts. Each has a sense of slip, which stays the same until the next event;
            friction acts against it. The sense is None for a contact without friction, and for the
            contact of a single link that does not slip.
    """

    symmetric = True  # rigid contacts act alike forwards and backwards in time

    def __init__(self, scene: Scene, closed: Sequence[ClosedPair], *, paired: bool) -> None:
        self.scene = scene
        self.closed = list(closed)
        self._solver = scene.engine.joint_solver
        self._paired = paired and self._solver.reversible
        self._step = 0.0

    def engage(self, state: State) -> None:
        """Let the contacts act from a state on."""
        self.closed = [
            each._replace(piece=self._next_piece(each.pair, state)) for each in self.closed
        ]
        self.scene.engine.keep_closed(self.closed)

    def set_back(self, gaps: Gaps, state: State) -> State:
        """Return the nearest state in which all contacts are closed and the sticking contacts have
        zero slip velocity.
        """
        if self.scene.mechanism.single_link:
            (contact,) = self.closed
            return turned_back(gaps, contact.pair, state, contact.piece)
        return set_back(gaps, self.closed, state)

    def begin(self, step: float) -> None:
        """Clear the impulses of the last interval; the solver records new ones in each step."""
        self._step = step
        self._solver.impulses = []

    def totals(self) -> list[float]:
        """Return the forces, impulses and work of all contacts in one list, in the order of
        ``Sums``.

        The normal force is that of the last step. For a contact that would have had to pull in one
        or more steps, the normal force is that of the last step in which it would have pulled.
        """
        found = list[float]()
        for each in zip(*self._solver.impulses, strict=True):
            pushes, rubs, slips = zip(*each, strict=True)
            normal, along = map(_means, (pushes, rubs)) if self._paired else (pushes, rubs)
            force = (
                ([push for push in normal if push < 0.0] or normal)[-1] / self._step,
                along[-1] / self._step,
            )
            found += [*force, sum(pushes), sum(rubs), 0.0, sum(map(mul, rubs, slips)), 0.0]
        return found

    def normal(self, totals: Sequence[float]) -> Sequence[float]:
        """Return the contacts' normal forces from the list that ``totals`` returns."""
        return totals[: NUMBERS * len(self.closed) : NUMBERS]

    def fails(self, totals: Sequence[float]) -> bool:
        """Return whether a contact would have to pull to stay closed."""
        return min(self.normal(totals)) <= 0.0

    def spare_friction(self, totals: Sequence[float], index: int) -> float:
        """Return the friction limit of a contact minus the magnitude of its tangential force."""
        sums = sums_of(totals, index)
        return self.closed[index].pair.friction * sums.normal - abs(sums.tangential)

    def breaks_away(self, totals: Sequence[float]) -> int | None:
        """Return the index of the first sticking contact whose tangential force exceeds the
        friction limit, or None.
        """
        stuck = (index for index, each in enumerate(self.closed) if each.slip == 0)
        return next((index for index in stuck if self.spare_friction(totals, index) < 0.0), None)

    def compliance_in_slip(self, gaps: Gaps, state: State, index: int) -> float:
        """Return the relative compliance of a contact in slip.

        It is the change of the normal velocity per unit normal impulse, K_nn - mu sign(v_t) K_nt,
        divided by the same change without joints and friction. K is the contact-space inverse mass
        matrix, mu the coefficient of friction and v_t the slip velocity. If the relative compliance
        is not positive, friction or geometry locks the link: no force keeps the contact closed.
        """
        pair, _, sense = self.closed[index]
        mechanism = self.scene.mechanism
        touch = gaps.closest(pair, state)
        poses = mechanism.poses(state)
        if sense is None and abs(touch.velocity[1]) > LEAST_SLIP:
            sense = int(math.copysign(1.0, touch.velocity[1]))
        if mechanism.single_link:
            lever = cross(touch.arm, touch.normal)
            along = cross(touch.arm, touch.tangent)
            inertia = mechanism.links[0].inertia_about_joint
            normal = lever * lever / inertia
            coupling = lever * along / inertia
        else:
            turn = np.exp(1j * np.array(state.angles))
            rows = np.concatenate(contact_rows(mechanism, turn, [self.closed[index]], [touch]))
            normal, coupling = (
                rows @ np.linalg.solve(mechanism.mass_matrix(turn), rows[0])
            ).tolist()
        free = 0.0
        for number, arm in ((pair.link, touch.arm), (pair.partner, touch.partner_arm)):
            if number is not None and arm is not None:
                link = mechanism.links[number]
                pose = poses[number]
                lever = cross(pose.joint + arm - pose.centre, touch.normal)
                free += 1.0 / link.mass + lever**2 / link.inertia
        return (normal - pair.friction * (sense or 0) * coupling) / free

    def _next_piece(self, pair: ContactPair, state: State) -> int:
        """Return the index of the straight segment of a link that touches an instant later.

        At a corner two segments touch; the instant decides between them.
        """
        if pair.partner is None and len(self.scene.mechanism.links[pair.link].corners) == 2:
            return 0
        angles = tuple(
            angle + MOMENT * rate for angle, rate in zip(state.angles, state.rates, strict=True)
        )
        later = State(state.time + MOMENT, angles, state.rates)
        return pair.closest(self.scene.mechanism.poses(later), later.rates).piece


def _means(numbers: Sequence[float]) -> Sequence[float]:
    """Return the mean of each pair of successive values: first and second, third and fourth, ..."""
    return [
        0.5 * (first + second) for first, second in zip(numbers[::2], numbers[1::2], strict=True)
    ]


def sense_of_slip(gaps: Gaps, pair: ContactPair, state: State, error: float) -> int | None:
    """Return the sense of slip that friction opposes in a new contact.

    If the slip velocity is smaller than its error, its sense is unknown. A contact of several links
    then sticks until friction no longer suffices. A single link slips in the direction of its
    contact point's acceleration; if the acceleration is zero too, the link is at rest.

    Args:
        gaps: gaps of the mechanism.
        pair: the two bodies in contact.
        state: the state at the touch.
        error: error of a velocity, in scene units.

    Returns:
        1 or -1 in slip, 0 in stick, None for a single link at rest.
    """
    slip = gaps.closest(pair, state).velocity[1]
    least = max(LEAST_SLIP, error)
    if abs(slip) <= least:
        if not gaps.mechanism.single_link:
            return 0
        slip = slip_acceleration(gaps, pair, state)
        least = LEAST_ACCELERATION
    return int(math.copysign(1.0, slip)) if abs(slip) > least else None
