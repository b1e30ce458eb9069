"""Sustained contacts keep links on what they touch: what lets them act, and the corrections that takes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact_forces import EngineForces, SolvedForces
from bristle_sim.scene.engine import MOST_ITERATIONS, SOLVED
from bristle_sim.scene.event_functions import Slip
from bristle_sim.scene.gaps import Gaps
from bristle_sim.scene.mechanism import Link, Mechanism, Pose, State, Vector, cross
from bristle_sim.scene.obstacles import Obstacle, Touch
from bristle_sim.scene.sustained_contact import STILL

MOMENT = 1e-6
"""Time after which the piece that touches is looked up again, in the scene's unit."""

LEAST_LEVER = 1e-6
"""With a lever of the contact normal shorter than this fraction of the link, turning the link cannot set it back."""

MOST_GRIP = 1.99
"""With more, each iteration of the engine's solver overshoots twofold."""

CLOSED = 1e-10
"""Closing a gap below this fraction of the link changes the rate by as little, less than any accuracy leaves it."""

NEWTON = 3
"""Rounds of Newton's method that set links back: an error of 1e-3 is 1e-6, 1e-12 and then rounding."""


class SustainedContacts:
    """What keeps some pairs closed: of a lone link the engine's own contact, of several links the solver of their joints.

    Attributes:
        scene: of the contacts.
        obstacles: the pairs in contact.
        pieces: which straight piece of its link touches, for each of them.
        slips: sense of the slip that friction acts against until an event changes it, for each of them: 0 sticks. A single
            link's follows from its geometry, and is left to the engine.
        solvable: whether the engine's iterations tend to a solution.
        forces: of the contacts, as a load.
    """

    def __init__(self, scene: Scene, obstacles: Sequence[Obstacle], slips: Sequence[int | None] = (None,)) -> None:
        """Prepare the contacts."""
        self.scene = scene
        self.obstacles = tuple(obstacles)
        self.pieces: list[int | None] = [None] * len(obstacles)
        self.slips = list(slips)
        self.solvable = True
        self.forces = (EngineForces if len(scene.links) == 1 else SolvedForces)(scene, obstacles)

    def grip(self, gaps: Gaps, state: State, index: int = 0) -> float:
        """Return the fraction of a free link's response that joints and friction leave, (K_nn - mu sign(v_t) K_nt)/K_free.

        Where it is not positive, friction or geometry locks the link: no force keeps it there.
        """
        obstacle, mechanism = self.obstacles[index], self.scene.mechanism
        touch, poses = gaps.touch(obstacle, state), gaps.poses(state)
        slip: float | None = self.slips[index]
        if slip is None:
            slip = math.copysign(1.0, touch.velocity[1]) if abs(touch.velocity[1]) > STILL else 0.0
        if len(mechanism.links) == 1:
            lever, along = cross(touch.arm, touch.normal), cross(touch.arm, touch.tangent)
            normal, coupling = (lever * each / mechanism.links[0].inertia_about_joint for each in (lever, along))
        else:
            directions = (touch.normal, touch.tangent)
            rows = np.array([contact_row(mechanism, poses, obstacle, touch, each) for each in directions])
            normal, coupling = (rows @ np.linalg.solve(mechanism.mass_matrix(poses), rows[0])).tolist()
        free = _free_response(mechanism.links[obstacle.link], poses[obstacle.link], touch.arm, touch.normal)
        if obstacle.partner is not None and touch.partner_arm is not None:
            partner = mechanism.links[obstacle.partner], poses[obstacle.partner]
            free += _free_response(*partner, touch.partner_arm, touch.normal)
        return (normal - obstacle.friction * slip * coupling) / free

    def engage(self, gaps: Gaps, state: State) -> float:
        """Let the contacts act from a state on; returns the least grip.

        On a single link each of the engine's iterations corrects the contact as if the link were free, then the joint: it
        leaves 1 - grip of the error, and there are as many as the state needs.
        """
        grips = [self.grip(gaps, state, index) for index in range(len(self.obstacles))]
        self.pieces = [self._next_piece(each, state) for each in self.obstacles]
        if isinstance(self.forces, SolvedForces):
            from bristle_sim.scene.wire_velocities import Held

            self.scene.hold([Held(*each) for each in zip(self.obstacles, self.pieces, self.slips, strict=True)])
            return min(grips)
        left = min(max(abs(1.0 - grips[0]), 1e-3), 1.0 - 1e-6)
        rounds = max(self.scene.contacts.in_flight, min(math.ceil(SOLVED / math.log(left)), MOST_ITERATIONS))
        self.solvable = grips[0] <= MOST_GRIP
        obstacle = self.obstacles[0]
        self.scene.contacts.engage(
            obstacle, friction=obstacle.friction, elasticity=0.0, iterations=rounds, piece=self.pieces[0] or 0
        )
        return grips[0]

    def _next_piece(self, obstacle: Obstacle, state: State) -> int:
        """Return the piece that touches from now on: at a corner two do, a moment later one."""
        if obstacle.partner is None and not self.scene.mechanism.links[obstacle.link].knees:
            return 0
        angles = tuple(angle + MOMENT * rate for angle, rate in zip(state.angles, state.rates, strict=True))
        later = State(state.time + MOMENT, angles, state.rates)
        return obstacle.touch_between(self.scene.mechanism.poses(later), later.rates).piece

    def breaks_away(self, totals: Sequence[float]) -> Slip | None:
        """Return the slip of a contact that cannot stick, by the totals of the forces, if there is one."""
        for index, obstacle in enumerate(self.obstacles):
            if self.slips[index] == 0 and self.forces.spare_friction(totals, index) < 0.0:
                return Slip(obstacle, self.forces.driven(totals, index))
        return None

    def set_back(self, gaps: Gaps, state: State) -> State:
        """Return the nearest state in which all contacts are closed and stay so."""
        return set_back(gaps, self.obstacles, state, self.pieces, self.slips)


def contact_row(
    mechanism: Mechanism, poses: Sequence[Pose], obstacle: Obstacle, touch: Touch, direction: Vector
) -> Array:
    """Return d(relative velocity of a contact along a direction)/d(rates), shape (links,)."""
    row = mechanism.row(poses, obstacle.link, touch.arm, direction)
    if obstacle.partner is not None and touch.partner_arm is not None:
        row -= mechanism.row(poses, obstacle.partner, touch.partner_arm, direction)
    return row


def _free_response(link: Link, pose: Pose, arm: Vector, normal: Vector) -> float:
    """Return the velocity that a unit impulse at an arm from the joint gives a link that is free."""
    to_centre = (pose.joint[0] + arm[0] - pose.centre[0], pose.joint[1] + arm[1] - pose.centre[1])
    return 1.0 / link.mass + cross(to_centre, normal) ** 2 / link.inertia


def set_back(
    gaps: Gaps,
    obstacles: Sequence[Obstacle],
    state: State,
    pieces: Sequence[int | None] | None = None,
    slips: Sequence[int | None] = (),
) -> State:
    """Return the nearest state at which links touch what they are in contact with, and keep touching it.

    By Newton's method; nearest in the norm of the kinetic energy, a change of M^-1 J^T (J M^-1 J^T)^-1 times what the gaps
    and their rates are off. Contacts that stick do not slip either.
    """
    pieces = pieces or [None] * len(obstacles)
    if len(state.angles) == 1:
        return _turned_back(gaps, obstacles[0], state, pieces[0])
    mechanism = gaps.mechanism
    for _ in range(NEWTON):
        poses = mechanism.poses(state)
        touches = [each.touch_between(poses, state.rates, piece) for each, piece in zip(obstacles, pieces, strict=True)]
        stuck = [index for index, each in enumerate(slips) if each == 0]
        across = [contact_row(mechanism, poses, o, t, t.normal) for o, t in zip(obstacles, touches, strict=True)]
        along = [contact_row(mechanism, poses, obstacles[i], touches[i], touches[i].tangent) for i in stuck]
        mass = mechanism.mass_matrix(poses)
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
    """Return the smallest change, in the norm of the mass, that the rows turn into the amounts."""
    response = np.linalg.solve(mass, rows.T)
    found = np.linalg.lstsq(rows @ response, np.array(amounts), rcond=1e-12)[0]
    changes: list[float] = (response @ found).tolist()
    return changes


def _turned_back(gaps: Gaps, obstacle: Obstacle, state: State, piece: int | None) -> State:
    """Turn a single link back onto an obstacle."""
    (angle,), (rate,) = state.angles, state.rates
    for _ in range(NEWTON):
        placed = State(state.time, (angle,), (rate,))
        touch = obstacle.touch_between(gaps.mechanism.poses(placed), placed.rates, piece)
        lever = cross(touch.arm, touch.normal)
        if abs(lever) < LEAST_LEVER:
            return state
        angle -= touch.gap / lever
        rate -= touch.velocity[0] / lever
        if abs(touch.gap) < CLOSED:
            break
    return State(state.time, (angle,), (rate,))


def opening_rate(first: Touch, second: Touch, rate: float) -> float:
    """Return how fast two contacts of a link that turns about its joint leave it free between them, whatever its rate.

    Each normal velocity is drift + lever * rate. With levers of opposite signs both are positive for some rate only if
    this sum of drift / abs(lever) is; below 0 they close on the link as a wedge does. Infinite for levers of one sign.
    """
    levers = [cross(touch.arm, touch.normal) for touch in (first, second)]
    if levers[0] * levers[1] >= 0.0:
        return math.inf
    drifts = (touch.velocity[0] - lever * rate for touch, lever in zip((first, second), levers, strict=True))
    return sum(drift / abs(lever) for drift, lever in zip(drifts, levers, strict=True))
