"""The engine's own contact keeps a link on an obstacle: as a load, with the corrections and the record that takes."""

from __future__ import annotations

import math

import pymunk

from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact_laws import contact_at
from bristle_sim.scene.event_functions import EventFunction
from bristle_sim.scene.mechanism import Mechanism, State, Vector
from bristle_sim.scene.obstacles import Obstacle, Touch
from bristle_sim.scene.stepping import Advance
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import ContactRecord

__all__ = [
    "ELBOW",
    "LEAST_GRIP",
    "MOST_GRIP",
    "STILL",
    "EngineContact",
    "elbow",
    "locking",
    "opening_rate",
    "set_back",
    "sustained_contact_record",
]

MOMENT = 1e-6
"""Time after which the piece that touches is looked up again, in the scene's unit."""

LEAST_LEVER = 1e-6
"""With a lever of the contact normal shorter than this fraction of the link, turning the link cannot set it back."""


class EngineContact:
    """The engine's own contact as a load: it acts by itself, and is lost once its force is gone."""

    def __init__(self, scene: Scene, obstacle: Obstacle) -> None:
        """Prepare the contact for the obstacle that the scene's last link is to stay on."""
        self.scene = scene
        self.obstacle = obstacle
        self.piece = 0
        self._in_flight = scene.space.iterations
        self._sums = [0.0, 0.0, 0.0]
        self._last = self._step = 0.0
        self._due = False

    def grip(self, state: State) -> float:
        """Return the fraction of a free link's response that joints and friction leave, (K_nn - mu sign(v_t) K_nt)/K_free.

        Where it is not positive, friction or geometry locks the link: no force keeps it there.
        """
        touch, response = self._response(state)
        slip = math.copysign(1.0, touch.velocity[1]) if abs(touch.velocity[1]) > STILL else 0.0
        normal, coupling, free = response
        return (normal - self.obstacle.friction * slip * coupling) / free

    def _response(self, state: State) -> tuple[Touch, tuple[float, float, float]]:
        """Return the touch, and what a push gives: K_nn, K_nt, and K_nn of the last link if it were free."""
        mechanism, link = self.scene.mechanism, self.scene.mechanism.links[-1]
        pose = mechanism.poses(state)[-1]
        joint, centre = pose.joint, pose.centre
        if len(mechanism.links) == 1:
            touch = self.obstacle.touch(pose, state.rates[-1])
            lever, along = _cross(touch.arm, touch.normal), _cross(touch.arm, touch.tangent)
            normal, coupling = (lever * each / link.inertia_about_joint for each in (lever, along))
        else:
            touch, space = contact_at(self.scene, state, self.obstacle)
            normal, coupling = space.inverse_mass[0].tolist()
        arm = (joint[0] + touch.arm[0] - centre[0], joint[1] + touch.arm[1] - centre[1])
        return touch, (normal, coupling, 1.0 / link.mass + _cross(arm, touch.normal) ** 2 / link.inertia)

    def engage(self, state: State) -> float:
        """Let the engine's contact act, with as many iterations as the state needs; returns the grip.

        Each iteration corrects the contact as if the link were free, then the joints: it leaves 1 - grip of the error.
        """
        grip = self.grip(state)
        left = min(max(abs(1.0 - grip), 1e-3), 1.0 - 1e-6)
        rounds = max(self._in_flight, min(math.ceil(SOLVED / math.log(left)), MOST_ITERATIONS))
        self.piece = self._next_piece(state)
        self.scene.engage(
            self.obstacle, friction=self.obstacle.friction, elasticity=0.0, iterations=rounds, piece=self.piece
        )
        return grip

    def _next_piece(self, state: State) -> int:
        """Return the piece that touches from now on: at a corner two do, a moment later one."""
        angles = tuple(angle + MOMENT * rate for angle, rate in zip(state.angles, state.rates, strict=True))
        later = State(state.time + MOMENT, angles, state.rates)
        return self.obstacle.touch(self.scene.mechanism.poses(later)[-1], later.rates[-1]).piece

    def begin(self) -> None:
        """Forget what was added up."""
        self._sums, self._due = [0.0, 0.0, 0.0], False

    def apply(self, step: float) -> None:
        """Add up what the engine, which acts by itself, did in the step before."""
        if self._due:
            self._add()
        elif step != self._step:
            self.scene.warm_up(step)
        self._due, self._step = True, step

    def totals(self, step: float) -> list[float]:
        """Return the normal force of the last step, normal and tangential impulse, and friction's work."""
        if self._due:
            self._add()
        return [self._last / step, *self._sums]

    def fails(self, totals: list[float]) -> bool:
        """Return whether the contact would have to pull."""
        return totals[0] <= 0.0

    def _add(self) -> None:
        self._last, rub = self.scene.contact_impulse()
        self._sums[0] += self._last
        if self.obstacle.friction:
            self._sums[1] += rub
            self._sums[2] += rub * self._slip()
        self._due = False

    def _slip(self) -> float:
        """Return the tangential velocity of the link where it touches, as the bodies are."""
        body = self.scene.links[-1]
        found = [0.0]

        def look(arbiter: pymunk.Arbiter) -> None:
            points, first = arbiter.contact_point_set, arbiter.shapes[0].body is body
            for each in points.points:
                velocity = body.velocity_at_world_point(each.point_a if first else each.point_b)
                outwards = -1.0 if first else 1.0
                found[0] = outwards * velocity.dot((points.normal.y, -points.normal.x))

        body.each_arbiter(look)
        return found[0]


def _cross(arm: Vector, direction: Vector) -> float:
    return arm[0] * direction[1] - arm[1] * direction[0]


STILL = 1e-9
"""Slip below this fraction of the scene's unit is rest: friction then has no direction."""

SOLVED = math.log(1e-17)
"""Iterations leave this fraction of the error: rounding."""

MOST_ITERATIONS = 40_000
"""Iterations of the engine's solver in a step: enough for the least grip."""

LEAST_GRIP, MOST_GRIP = 1e-3, 1.99
"""With less, the force that keeps the link there grows beyond bounds: a jam. With more, each iteration overshoots twofold."""


ELBOW = "other piece of the wire"


def elbow(contact: EngineContact) -> EventFunction:
    """Watch another piece of a bent wire meet the obstacle that this one is on."""

    def beside(at: Advance) -> float:
        return contact.obstacle.gap_beside(contact.scene.mechanism.poses(at.state)[-1], contact.piece)

    return EventFunction(ELBOW, beside, falling=True)


def locking(contact: EngineContact) -> EventFunction:
    """Watch the grip get too small: friction locks the link, or without it the link meets the obstacle end-on."""
    jams = contact.obstacle.friction > 0.0
    final = StopReason.JAM if jams else StopReason.NO_GRIP
    return EventFunction(
        "locking", lambda at: contact.grip(at.state) - LEAST_GRIP, True, "jam" if jams else None, final=final
    )


def set_back(mechanism: Mechanism, obstacle: Obstacle, state: State, piece: int | None = None) -> State:
    """Turn the last link by Newton's method so that it touches the obstacle and keeps touching it."""
    angles, rates = list(state.angles), list(state.rates)
    for _ in range(3):
        placed = State(state.time, tuple(angles), tuple(rates))
        touch = obstacle.touch(mechanism.poses(placed)[-1], rates[-1], piece)
        lever = _cross(touch.arm, touch.normal)
        if abs(lever) < LEAST_LEVER:
            return state
        angles[-1] -= touch.gap / lever
        rates[-1] -= touch.velocity[0] / lever
    return State(state.time, tuple(angles), tuple(rates))


def opening_rate(first: Touch, second: Touch, rate: float) -> float:
    """Return how fast two contacts of a link that turns about its joint leave it free between them, whatever its rate.

    Each normal velocity is drift + lever * rate. With levers of opposite signs both are positive for some rate only if
    this sum of drift / abs(lever) is; below 0 they close on the link as a wedge does. Infinite for levers of one sign.
    """
    levers = [_cross(touch.arm, touch.normal) for touch in (first, second)]
    if levers[0] * levers[1] >= 0.0:
        return math.inf
    drifts = (touch.velocity[0] - lever * rate for touch, lever in zip((first, second), levers, strict=True))
    return sum(drift / abs(lever) for drift, lever in zip(drifts, levers, strict=True))


def sustained_contact_record(
    mechanism: Mechanism, obstacle: Obstacle, first: State, last: State, sums: tuple[float, ...], outcome: str
) -> ContactRecord:
    """Return the contact record of a sustained touch; ``sums`` are normal and tangential impulse and friction's work."""

    def slip(state: State) -> float:
        return obstacle.touch(mechanism.poses(state)[-1], state.rates[-1]).velocity[1]

    normal, tangential, work = sums
    return ContactRecord(
        obstacle=obstacle.name,
        law="sustained",
        outcome=outcome,
        time=first.time,
        duration=last.time - first.time,
        impulse=(normal, tangential),
        compressive_impulse=None,
        compressive_work=(0.0, work),
        restitutive_work=None,
        velocity_before=(0.0, slip(first)),
        velocity_after=(0.0, slip(last)),
        angles=first.angles,
        rates_before=first.rates,
        rates_after=last.rates,
    )
