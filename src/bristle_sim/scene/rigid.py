"""Rigid sustained contacts: two ways to keep them closed, and a load that sums their forces.

A lone link has one degree of freedom: one contact at a time fixes its motion, which follows from geometry and hub alone. The
engine's own contact keeps it closed; the linear solve that several links need would make a pass 1.9 to 2.2 times as
expensive. Contacts of several links, and of a lone one whose friction is too high for the engine's iterations, are solved
for together with the joints (:mod:`bristle_sim.scene.solver`). :func:`rigid_contacts` alone decides between the
two.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from operator import mul

import numpy as np

from bristle_sim.scene.build import Scene
from bristle_sim.scene.engine import LOG_SOLVED, MOST_ITERATIONS
from bristle_sim.scene.gaps import MOMENT, Gaps, contact_row, set_back, slip_acceleration, turned_back
from bristle_sim.scene.load import NUMBERS, sums_of
from bristle_sim.scene.mechanism import State, cross
from bristle_sim.scene.pairs import ClosedPair, ContactPair

LEAST_SLIP = 1e-9  # slip, in the scene's unit, below which it has no sense, however accurate the run is

LEAST_ACCELERATION = 1e-7  # of slip, in the scene's unit, below which it is rounding of its difference over MOMENT


class RigidContacts(ABC):
    """The rigid contacts of a smooth motion; the motion ends when the force of one of them vanishes.

    Attributes:
        scene: of the contacts.
        pairs: the pairs in contact.
        pieces: for each contact, the touching straight piece of its link.
        slips: for each contact, the sense of slip that friction opposes until an event changes it. 0 sticks; None is without
            friction, or a lone link that does not slip.
    """

    symmetric = True  # they act alike forwards and backwards in time

    def __init__(self, scene: Scene, pairs: Sequence[ContactPair], slips: Sequence[int | None]) -> None:
        self.scene, self.pairs, self.slips = scene, tuple(pairs), list(slips)
        self.pieces: list[int | None] = [None] * len(pairs)
        self._pushes: Sequence[float] = ()

    @abstractmethod
    def engage(self, gaps: Gaps, state: State) -> float:
        """Let the contacts act from a state on; return the least compliance in slip."""

    @abstractmethod
    def set_back(self, gaps: Gaps, state: State) -> State:
        """Return the nearest state in which all contacts are closed and stay so; those that stick do not slip either."""

    @abstractmethod
    def begin(self, step: float) -> Callable[[], None]:
        """Reset the sums; return a callback to run before each step, which notes the previous step's impulses."""

    @abstractmethod
    def totals(self) -> list[float]:
        """Return the numbers of each contact's :class:`Sums`, with the last step."""

    def lasts(self) -> float:
        """Return the fraction of the last interval after which the first force vanishes, by the pushes in its steps."""
        pushes = self._pushes
        count = next((index for index, push in enumerate(pushes) if push <= 0.0), len(pushes))
        if count < 2:
            return 0.5 * count / max(len(pushes), 1)
        before, last = pushes[count - 2 : count]
        return (count - 1.0 + min(last / (before - last), 1.0) if last < before else count) / len(pushes)

    def normal(self, totals: Sequence[float]) -> Sequence[float]:
        """Return the contacts' normal forces from the totals."""
        return totals[: NUMBERS * len(self.pairs) : NUMBERS]

    def fails(self, totals: Sequence[float]) -> bool:
        """Whether a contact would have to pull."""
        return min(self.normal(totals)) <= 0.0

    def spare_friction(self, totals: Sequence[float], index: int) -> float:
        """Return the margin of a contact's tangential force to the limit of friction."""
        sums = sums_of(totals, index)
        return self.pairs[index].friction * sums.normal - abs(sums.tangential)

    def breaks_away(self, totals: Sequence[float]) -> int | None:
        """Return the index of the first sticking contact whose force exceeds the friction limit, or None."""
        stuck = (index for index, slip in enumerate(self.slips) if slip == 0)
        return next((index for index in stuck if self.spare_friction(totals, index) < 0.0), None)

    def compliance_in_slip(self, gaps: Gaps, state: State, index: int = 0) -> float:
        """Return the gain of v_n per unit normal impulse in slip, K_nn - mu sign(v_t) K_nt, over that of a free link.

        Where it is not positive, friction or geometry locks the link: no force keeps it there.
        """
        pair, mechanism = self.pairs[index], self.scene.mechanism
        touch, poses = gaps.closest(pair, state), gaps.poses(state)
        slip: float | None = self.slips[index]
        if slip is None:
            slip = math.copysign(1.0, touch.velocity[1]) if abs(touch.velocity[1]) > LEAST_SLIP else 0.0
        if mechanism.lone:
            lever, along = cross(touch.arm, touch.normal), cross(touch.arm, touch.tangent)
            inertia = mechanism.links[0].inertia_about_joint
            normal, coupling = lever * lever / inertia, lever * along / inertia
        else:
            directions = (touch.normal, touch.tangent)
            rows = np.array([contact_row(mechanism, poses, pair, touch, each) for each in directions])
            normal, coupling = (rows @ np.linalg.solve(mechanism.mass_matrix(poses), rows[0])).tolist()
        free = 0.0
        for number, arm in ((pair.link, touch.arm), (pair.partner, touch.partner_arm)):
            if number is not None and arm is not None:
                link, pose = mechanism.links[number], poses[number]
                to_centre = (pose.joint[0] + arm[0] - pose.centre[0], pose.joint[1] + arm[1] - pose.centre[1])
                free += 1.0 / link.mass + cross(to_centre, touch.normal) ** 2 / link.inertia
        return (normal - pair.friction * slip * coupling) / free

    def _next_piece(self, pair: ContactPair, state: State) -> int:
        """Return the piece that touches a moment from now; at a corner two pieces touch."""
        if pair.partner is None and not self.scene.mechanism.links[pair.link].knees:
            return 0
        angles = tuple(angle + MOMENT * rate for angle, rate in zip(state.angles, state.rates, strict=True))
        later = State(state.time + MOMENT, angles, state.rates)
        return pair.closest(self.scene.mechanism.poses(later), later.rates).piece


class EngineContact(RigidContacts):
    """The engine's own contact of a lone link."""

    def __init__(self, scene: Scene, pairs: Sequence[ContactPair], slips: Sequence[int | None]) -> None:
        super().__init__(scene, pairs, slips)
        (self._pair,) = pairs
        self._record = scene.contacts.record(self._pair, slips=self._pair.friction > 0.0)
        self._step, self._normal = 0.0, (0.0, 0.0)

    def engage(self, gaps: Gaps, state: State) -> float:
        """Activate the contact from a state on; return its compliance in slip.

        Each of the engine's iterations corrects the contact as if the link were free, then the joint: it leaves 1 - this
        fraction of the error. Their number is chosen to suit the state.
        """
        pair, contacts, compliance = self._pair, self.scene.contacts, self.compliance_in_slip(gaps, state)
        touch, self.pieces = gaps.closest(pair, state), [piece := self._next_piece(pair, state)]
        left = min(max(abs(1.0 - compliance), 1e-3), 1.0 - 1e-6)
        rounds = max(contacts.in_flight, min(math.ceil(LOG_SOLVED / math.log(left)), MOST_ITERATIONS))
        contacts.engage(pair, friction=pair.friction, elasticity=0.0, iterations=rounds, piece=piece)
        self._normal = touch.normal
        if (slip := self.slips[0]) is not None:
            contacts.direct_friction(slip, touch.tangent)
        return compliance

    def set_back(self, gaps: Gaps, state: State) -> State:
        """Turn the link back onto the pair."""
        return turned_back(gaps, self._pair, state, self.pieces[0])

    def begin(self, step: float) -> Callable[[], None]:
        """Reset the record of the contact's impulses; return the callback that notes the previous step's."""
        if step != self._step:
            self.scene.engine.warm_up(step)
        self._step = step
        self._record.begin()
        return self._record.note

    def totals(self) -> list[float]:
        """Return the contact's numbers."""
        found = self._record.read(self._normal) or [(0.0, 0.0, 0.0)]
        pushes, rubs, slips = zip(*found, strict=True)
        self._pushes = pushes
        force = pushes[-1] / self._step, rubs[-1] / self._step
        return [*force, sum(pushes), sum(rubs), 0.0, sum(map(mul, rubs, slips)), 0.0]


class SolvedContacts(RigidContacts):
    """Contacts of several links; their forces are solved for together with the joints.

    In steps that are symmetric in time (``paired``) odd and even ones have errors in the force that cancel in the mean of two.
    """

    def __init__(
        self, scene: Scene, pairs: Sequence[ContactPair], slips: Sequence[int | None], *, paired: bool
    ) -> None:
        super().__init__(scene, pairs, slips)
        self._paired, self._step = paired, 0.0
        self._steps: list[list[tuple[float, float, float]]] = []

    def engage(self, gaps: Gaps, state: State) -> float:
        """Let the contacts act from a state on; return the least compliance in slip."""
        self.pieces = [self._next_piece(each, state) for each in self.pairs]
        self.scene.keep_closed([ClosedPair(*each) for each in zip(self.pairs, self.pieces, self.slips, strict=True)])
        return min(self.compliance_in_slip(gaps, state, index) for index in range(len(self.pairs)))

    def set_back(self, gaps: Gaps, state: State) -> State:
        """Set links back onto the pairs; contacts that stick do not slip either."""
        return set_back(gaps, self.pairs, state, self.pieces, self.slips)

    def begin(self, step: float) -> Callable[[], None]:
        """Reset the record of the impulses; return the callback that notes the previous step's."""
        solver, steps = self.scene.joint_solver, list[list[tuple[float, float, float]]]()
        self._step, self._steps = step, steps

        def note() -> None:
            steps.append(solver.impulses)

        return note

    def totals(self) -> list[float]:
        """Return the numbers of each contact; where it has to pull in the interval, the last pull is its force."""
        found, steps = list[float](), [*self._steps[1:], self.scene.joint_solver.impulses]
        self._pushes = [min(push for push, _, _ in step) for step in steps]
        for each in zip(*steps, strict=True):
            pushes, rubs, slips = zip(*each, strict=True)
            normal, along = map(_means, (pushes, rubs)) if self._paired else (pushes, rubs)
            force = ([push for push in normal if push < 0.0] or normal)[-1] / self._step, along[-1] / self._step
            found += [*force, sum(pushes), sum(rubs), 0.0, sum(map(mul, rubs, slips)), 0.0]
        return found


def _means(numbers: Sequence[float]) -> Sequence[float]:
    """Return the means of the first two numbers, the next two, and so on."""
    return [0.5 * (first + second) for first, second in zip(numbers[::2], numbers[1::2], strict=True)]


def rigid_contacts(
    scene: Scene, pairs: Sequence[ContactPair], slips: Sequence[int | None], *, paired: bool = True
) -> RigidContacts:
    """Return the contacts of a scene, by the engine or by the linear solve."""
    if scene.engine.solves_contacts:
        return SolvedContacts(scene, pairs, slips, paired=paired)
    return EngineContact(scene, pairs, slips)


def sense_of_slip(gaps: Gaps, pair: ContactPair, state: State, error: float) -> int | None:
    """Return the sense of slip that friction opposes in a new contact; 0 sticks, None is at rest.

    The sense of a slip velocity within the run's error is unknown. Several links then stick until friction no longer suffices.
    A lone link slips in the direction of its contact point's acceleration; if that is zero too, it is at rest.
    """
    slip, least = gaps.closest(pair, state).velocity[1], max(LEAST_SLIP, error)
    if abs(slip) <= least:
        if not gaps.mechanism.lone:
            return 0
        slip, least = slip_acceleration(gaps, pair, state), LEAST_ACCELERATION
    return int(math.copysign(1.0, slip)) if abs(slip) > least else None
