"""Sustained contacts: what each adds up to, and what keeps them closed, the engine's own contact or the solver of the joints."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact.forces import EngineForces, SolvedForces
from bristle_sim.scene.contact.gaps import MOMENT, Gaps, contact_row, set_back, slip_acceleration
from bristle_sim.scene.contact.obstacles import Held, Obstacle
from bristle_sim.scene.engine import LOG_SOLVED, MOST_ITERATIONS
from bristle_sim.scene.events.functions import Slip
from bristle_sim.scene.mechanism import Link, Pose, State, Vector, cross
from bristle_sim.trajectory import ContactRecord

STILL = 1e-9
"""Slip below this fraction of the scene's unit is rest: friction then has no direction."""

LEAST_ACCELERATION = 1e-7
"""Acceleration of slip, in the scene's unit, below which it is rounding of its difference over ``MOMENT``."""

MOST_GRIP = 1.99
"""With more, each iteration of the engine's solver overshoots twofold."""


@dataclass(slots=True, eq=False)
class Sustained:
    """A contact that stays closed until its normal force has fallen to zero.

    Attributes:
        obstacle: the pair in contact.
        start: state at which it began; None before.
        sums: normal and tangential impulse and friction's work since.
        force: normal force at the end of the last interval; None before.
        vanishes_in: after what time from then it would vanish, by the parabola that has the interval's forces and impulse.
        slip: sense of the slip that friction acts against; 0 sticks, None until it is looked up.
        stopped: sense of the slip that has stopped just now; 0 where none has.
    """

    obstacle: Obstacle
    start: State | None = None
    sums: tuple[float, ...] = (0.0, 0.0, 0.0)
    force: float | None = None
    vanishes_in: float = math.inf
    slip: int | None = None
    stopped: int = 0

    def begin(self, state: State) -> None:
        """Begin a smooth motion in contact, the first one or another."""
        self.start = self.start or state
        self.force, self.vanishes_in = None, math.inf

    def look_up_slip(self, gaps: Gaps, state: State, error: float) -> None:
        """Find the sense of slip that friction acts against.

        A slip velocity within the run's error has no sense. Several links then stick until friction does not suffice. A
        single link slips the way that its contact point is accelerated, which follows from geometry and hub alone; where
        that is zero too the link is at rest.
        """
        if self.slip is None and self.obstacle.friction:
            slip, least = gaps.touch(self.obstacle, state).velocity[1], max(STILL, error)
            if abs(slip) <= least and len(state.angles) > 1:
                self.slip = 0
                return
            if abs(slip) <= least:
                slip, least = slip_acceleration(gaps, self.obstacle, state), LEAST_ACCELERATION
            if abs(slip) > least:
                self.slip = int(math.copysign(1.0, slip))

    def turn(self, sense: int) -> None:
        """Slip in another sense, or stick, from now on."""
        self.stopped, self.slip = (self.slip or 0) if sense == 0 else 0, sense

    def add(self, force: float, sums: Iterable[float], length: float) -> None:
        """Add up what the contact did in an interval, and note the force at its end."""
        added = tuple(sums)
        self.sums = tuple(a + b for a, b in zip(self.sums, added, strict=True))
        if length > 0.0:
            mean = added[0] / length
            first = 2.0 * mean - force if self.force is None else self.force
            bend = 3.0 * (first + force) - 6.0 * mean
            slope = force - first + bend
            square = slope * slope - 4.0 * bend * force
            falls = math.sqrt(square) - slope if square >= 0.0 else 0.0
            self.vanishes_in = 2.0 * length * force / falls if falls > 0.0 else math.inf
        self.force = force

    def record(self, gaps: Gaps, last: State, outcome: str) -> ContactRecord | None:
        """Return the contact record; None for a contact that took no time."""
        first = self.start
        if first is None or last.time <= first.time:
            return None
        normal, tangential, work = self.sums
        before, after = (gaps.touch(self.obstacle, state).velocity[1] for state in (first, last))
        return ContactRecord(
            obstacle=self.obstacle.name,
            law="sustained",
            outcome=outcome,
            time=first.time,
            duration=last.time - first.time,
            impulse=(normal, tangential),
            compressive_impulse=None,
            compressive_work=(0.0, work),
            restitutive_work=None,
            velocity_before=(0.0, before),
            velocity_after=(0.0, after),
            angles=first.angles,
            rates_before=first.rates,
            rates_after=last.rates,
        )


class SustainedContacts:
    """What keeps some pairs closed: of a lone link the engine's own contact, of several links the solver of their joints.

    Attributes:
        scene: of the contacts.
        obstacles: the pairs in contact.
        pieces: which straight piece of its link touches, for each of them.
        slips: sense of the slip that friction acts against until an event changes it, for each of them: 0 sticks; None where
            there is no friction, or a single link that does not slip.
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
            self.scene.hold([Held(*each) for each in zip(self.obstacles, self.pieces, self.slips, strict=True)])
            return min(grips)
        left = min(max(abs(1.0 - grips[0]), 1e-3), 1.0 - 1e-6)
        rounds = max(self.scene.contacts.in_flight, min(math.ceil(LOG_SOLVED / math.log(left)), MOST_ITERATIONS))
        self.solvable = grips[0] <= MOST_GRIP
        obstacle = self.obstacles[0]
        self.scene.contacts.engage(
            obstacle, friction=obstacle.friction, elasticity=0.0, iterations=rounds, piece=self.pieces[0] or 0
        )
        if (slip := self.slips[0]) is not None:
            self.scene.contacts.direct_friction(slip, gaps.touch(obstacle, state).tangent)
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


def _free_response(link: Link, pose: Pose, arm: Vector, normal: Vector) -> float:
    """Return the velocity that a unit impulse at an arm from the joint gives a link that is free."""
    to_centre = (pose.joint[0] + arm[0] - pose.centre[0], pose.joint[1] + arm[1] - pose.centre[1])
    return 1.0 / link.mass + cross(to_centre, normal) ** 2 / link.inertia
