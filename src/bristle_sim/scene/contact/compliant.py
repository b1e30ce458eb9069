"""A contact resolved in time: a stiff spring with energetic restitution at the tip, Coulomb friction and true stick.

Normal force over penetration delta is bilinear: k delta while penetration grows, and (k/e*^2)(delta - delta_r) with
delta_r = (1 - e*^2) delta_max on the way out, so that the spring returns e*^2 of the work it took, whatever the bodies
do. The tangential force is -mu sign(v_t) N in slip; in stick it is what stops the point within each engine step,
-(K_nt N + v_t/h)/K_tt. Compression, restitution, slip and stick are smooth intervals; the instants between them are
located. As the contact gets shorter the outcome tends to that of the rigid-body law with the energetic coefficient.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from bristle_sim.arrays import Array
from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact.contact_integration import ContactIntegration
from bristle_sim.scene.contact.contact_motion import SAMPLES, ContactMotion, Expectation
from bristle_sim.scene.contact.laws import Coefficients, EnergeticLaw, contact_at
from bristle_sim.scene.contact.obstacles import Obstacle
from bristle_sim.scene.contact.spring import SpringLoad, time_at_unit_stiffness
from bristle_sim.scene.integrate.extrapolation import Extrapolation
from bristle_sim.scene.integrate.repetitions import CLOSE, WIDE
from bristle_sim.scene.integrate.stepping import PlainSteps, Stepper
from bristle_sim.scene.integrate.time_scales import damped_interval
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.wire_links import rigid_stiffness
from bristle_sim.trajectory import ContactRecord

LEAST_DURATION = 3e-7
"""Shortest contact in scene time units, times sqrt(e*). Measured: a contact of duration T differs from the rigid-body
limit by 0.4 T, and rounding of its penetration, of which restitution leaves the fraction e*^2, by 4e-14/(T e*). Damping of
a rate r > 1 takes the fraction r T of a velocity meanwhile: the shortest contact is then shorter by sqrt(r)."""

ROUNDING = 1e-15
"""Rounding of the contact's force in an interval, as a velocity, times duration and e*; no interval is more accurate."""

CLEAR = 1e4
"""Tolerance over rounding from which closely spaced repetitions, with weights a hundred times as large, reach it in fewer
steps. Measured for accuracies from 0.1 to 1e-4: two thirds to nine tenths of the steps, and the same error."""

LEAST_DEPTH = 1e-13
"""Penetration times e* below which rounding decides when a contact ends; the rigid-body limit is then closer."""

LEAST_RESTITUTION = 1e-3
"""Except 0. The spring's way out is 1/e* times as fast as its way in."""

PLAIN_ACCURACY = 1e-4
"""Accuracy to which contacts of plain steps follow the rigid-body limit: well below the steps' own errors, and not so
short that the rounding of positions shows in a penetration."""

FEWEST_SAMPLES = 8
"""Least number of intervals of a contact whose outcome is of interest: less than a phase in each. Its course follows."""


class CompliantLaw:
    """Contact resolved in time by the engine.

    Args:
        duration: time in touch, engine units; of a wire that bends: in its first touch, were it rigid and without friction. None
            is short enough for the rigid-body limit to ``accuracy``.
        accuracy: requested relative accuracy.
        plain_steps: number of plain engine steps in a contact, or None to extrapolate to the accuracy.
        maximum_steps: engine steps after which a contact is given up, each counted as the scene's ``work`` counts it.
        stiffness: of the spring in compression, engine units; None is that of a rigid-body contact of the duration. With
            one, the duration is only expected.
        observe: called with the states at the samples of each contact.
    """

    name = "compliant"

    def __init__(
        self,
        duration: float | None,
        accuracy: float,
        plain_steps: int | None = None,
        maximum_steps: int = 1_000_000,
        stiffness: float | None = None,
        observe: Callable[[list[State]], None] | None = None,
    ) -> None:
        """See the class."""
        self.duration = duration
        self.stiffness = stiffness
        self.observe = observe
        self.accuracy = accuracy
        self.plain_steps = plain_steps
        self.maximum_steps = maximum_steps

    def resolve(
        self, scene: Scene, state: State, obstacle: Obstacle, coefficients: Coefficients
    ) -> tuple[State, ContactRecord]:
        """Carry the scene through the contact; the state returned is later than the one given.

        A touch too slow to be resolved goes by the rigid-body law.

        Raises:
            ValueError: if the contact cannot be resolved in double precision, or comes to no end.
        """
        self._check(scene, coefficients.restitution)
        touch, space = contact_at(scene, state, obstacle)
        rigid = coefficients.energetic_impact(space)
        fastest = max(1.0, *(abs(rate) for rate in state.rates))
        factor = (
            coefficients.restitution or 1.0
        )  # of the time in which the spring unloads; 1 where it ends at the deepest
        duration = self.duration or self._shortest(scene, fastest, factor)
        if -space.velocity[0] * duration * factor < LEAST_DEPTH:
            return EnergeticLaw().resolve(scene, state, obstacle, coefficients)
        if self.stiffness is None and scene.effects.hinges:
            # It is the workpart's: later touches meet the same.
            self.stiffness = rigid_stiffness(
                scene.mechanism, state, touch, obstacle.link, duration, coefficients.restitution
            )
        stiffness = self.stiffness
        if stiffness is None:
            stiffness = (time_at_unit_stiffness(rigid, space.velocity[0], coefficients.restitution) / duration) ** 2
        load = SpringLoad(scene, touch, space.inverse_mass, stiffness, coefficients)
        longest = min(duration / (FEWEST_SAMPLES if self.duration is None else SAMPLES), damped_interval(scene))
        stepper = self._stepper(duration, longest, fastest, least=_rounding(space.inverse_mass, duration * factor))
        expected = Expectation.of(duration, longest, rigid.outcome_name, len(scene.links))
        contact = ContactIntegration(ContactMotion(scene, state, load, stepper, expected))
        outcome = contact.run(scene.work + self.maximum_steps)
        if self.observe is not None:
            self.observe(contact.course.states)
        names, constant = (obstacle.name, self.name, outcome), None if expected.moves else space.inverse_mass
        after = contact.motion.state
        return after, contact.course.record(names, state, after, constant)

    def _stepper(self, duration: float, longest: float, fastest: float, least: float) -> Stepper:
        """Return what integrates a contact of a duration, no more accurately than rounding, ``least``, allows."""
        if self.plain_steps is not None:
            return PlainSteps(duration / self.plain_steps)
        tolerance = max(0.1 * self.accuracy, least)
        return Extrapolation(tolerance, fastest, CLOSE if tolerance > CLEAR * least else WIDE, longest)

    def _shortest(self, scene: Scene, fastest: float, factor: float) -> float:
        """Return the duration of a contact that is as short as the accuracy needs and rounding leaves it."""
        damping = max(1.0, scene.effects.damping / scene.mechanism.links[0].inertia_about_joint)
        least = LEAST_DURATION / math.sqrt(factor * damping)
        return max(least, 0.1 * self.accuracy / max(fastest, damping))

    def _check(self, scene: Scene, restitution: float) -> None:
        if 0.0 < restitution < LEAST_RESTITUTION:
            raise ValueError(
                f"restitution = {restitution:g}: must be 0, or at least {LEAST_RESTITUTION:g}, for a contact resolved in"
                " time (dimensionless)"
            )
        least = LEAST_DURATION / math.sqrt(restitution or 1.0)
        if self.duration is not None and self.duration < least:
            raise ValueError(
                f"contact_duration: must be at least {least / self.duration:.3g} times the given one, or rounding"
                " would hide the penetration"
            )
        if not scene.solves_joints:
            raise ValueError(
                "contact = compliant: links must be at least 1e-3 times as heavy as the next one, or the engine's"
                " iterations do not solve their joints"
            )


def _rounding(inverse_mass: Array, resolved: float) -> float:
    """Return what rounding makes of the lightest link's rate in an interval; ``resolved``: the duration times e*.

    It turns the link, of inertia 1/3, by the normal velocity over the root of K_nn/3.
    """
    return max(1.0, math.sqrt(3.0 / inverse_mass[0, 0])) * ROUNDING / resolved
