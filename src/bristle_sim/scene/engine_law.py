"""The impact law of the physics engine, for comparison with the energetic law."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pymunk

from bristle_sim.scene.build import SHAPE_MARGIN, Scene
from bristle_sim.scene.impacts import ContactLaw
from bristle_sim.scene.mechanism import State, xy
from bristle_sim.scene.pairs import ContactPair, WorkpartPair
from bristle_sim.trajectory import ContactRecord

# Length of the step in which the engine resolves an impact, in scene time units. It is so short
# that forces and motion in the step have less effect than rounding error.
ENGINE_STEP = 1e-12
# Half the width and half the depth of the workpart's shape, in link lengths. No mechanism reaches
# the other edges of this shape.
HALF_PLANE = 1e3
# Number of iterations of the engine's solver in the step of an impact; the engine's default.
ENGINE_ITERATIONS = 10


@dataclass(frozen=True)
class EngineLaw(ContactLaw):
    """The impact law of the physics engine, for comparison.

    The engine solves iteratively for the impulses. Its ``elasticity`` is Newton's coefficient of
    restitution. The tangential impulse is at most the coefficient of friction times the normal
    impulse. The law has no phases and only one coefficient of friction. It may increase the energy
    of bodies that are joined in a chain.
    """

    name = "engine"

    def resolve(self, scene: Scene, state: State, pair: ContactPair) -> tuple[State, ContactRecord]:
        """Let the engine resolve an impact with the workpart, in one very short step.

        The workpart's shape in the engine extends beyond its surface by ``SHAPE_MARGIN``, so that
        the engine detects the touch. The link's shape is not enlarged, so the lever of friction is
        exact. The engine's elasticity and friction are the pair's coefficients.

        Returns:
            The state after the impact and the contact record, in engine units.
        """
        assert isinstance(pair, WorkpartPair), "the bar has the energetic law"
        scene.place(state)
        mechanism = scene.mechanism
        space = scene.space
        link = mechanism.links[pair.link]
        middle = -pair.depth - HALF_PLANE
        face = ((-HALF_PLANE, middle), (HALF_PLANE, middle))
        part = pymunk.Segment(space.static_body, *face, HALF_PLANE + SHAPE_MARGIN)
        tip = pymunk.Circle(
            scene.links[pair.link], 0.0, xy(link.corners[pair.corner] - link.centre)
        )
        tip.friction = tip.elasticity = 1.0
        part.friction = pair.friction
        part.elasticity = pair.restitution
        impulses = [(0.0, 0.0)]

        def note(arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
            del space, data
            impulses.append(arbiter.total_impulse)

        space.add(part, tip)
        space.on_collision(post_solve=note)
        before = space.iterations
        space.iterations = ENGINE_ITERATIONS
        scene.step_alone(ENGINE_STEP)
        space.iterations = before
        space.on_collision()
        space.remove(part, tip)
        rub, push = impulses[-1]
        rates = tuple([body.angular_velocity for body in scene.links])
        after = mechanism.poses(state._replace(rates=rates))
        velocity = pair.closest(after, rates).velocity
        return state._replace(rates=rates), ContactRecord(
            obstacle=pair.name,
            law=self.name,
            time=state.time,
            duration=0.0,
            angles=state.angles,
            rates_before=state.rates,
            rates_after=rates,
            outcome="rebound" if velocity[0] > 0.0 else "no rebound",
            # The sign of the engine's impulse depends on the order of the shapes. A contact can
            # only push, so the normal impulse must be positive.
            impulse=(push, rub) if push >= 0.0 else (-push, -rub),
            compressive_impulse=None,
            compressive_work=None,
            restitutive_work=None,
            velocity_before=pair.closest(mechanism.poses(state), state.rates).velocity,
            velocity_after=velocity,
        )
