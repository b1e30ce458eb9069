"""The law of a contact that is simulated over its duration: a stiff spring with energetic
restitution, Coulomb friction and true stick.

The shorter the contact, the closer its outcome is to the outcome of the rigid-body law with the
same energetic coefficient of restitution.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from bristle_sim.scene.build import Scene
from bristle_sim.scene.extrapolation import Extrapolation, damped_interval
from bristle_sim.scene.impacts import (
    ContactLaw,
    EnergeticLaw,
    contact_at,
    ending_together,
    impact_at,
)
from bristle_sim.scene.mechanism import Mechanism, State, cross
from bristle_sim.scene.pairs import ClosestApproach, ContactPair, WorkpartPair
from bristle_sim.scene.spring import SpringContact
from bristle_sim.theory.contact_spring import (
    ContactSpring,
    check_restitution,
    frictionless_stiffness,
    stiffness_for_duration,
)
from bristle_sim.theory.impact import LEAST_COMPLIANCE
from bristle_sim.trajectory import ContactRecord

LEAST_DURATION = 3e-7
"""Lower bound of T sqrt(e*), in scene time units, with the duration T of a simulated contact and
the energetic coefficient of restitution e*. Measured: the contact differs from the rigid-body limit
by 0.4 T, and rounding error of the penetration adds 4e-14/(T e*); the sum is least near this bound.
Damping with a time constant 1/r < 1 reduces a velocity by the fraction r T during the contact, so
the bound is then divided by sqrt(r)."""

FORCE_ROUNDING = 1e-15
"""Error of a velocity in one interval, caused by rounding error of the contact force and multiplied
by T e*, with the contact's duration T and its coefficient of restitution e*; scene units."""

CONTACT_FRACTION = 0.03
"""Error permitted in one interval of a contact, as a fraction of the run's accuracy: the errors of
thirty intervals add up to the accuracy."""

# Lower bound of d e*, in scene units, with the penetration d of a simulated contact. In a shallower
# contact rounding error decides when the contact ends, and the rigid-body law is more accurate.
LEAST_DEPTH = 1e-13

SLOWEST_REBOUND = 100.0
"""Least rebound speed of a contact in the rigid-body limit, as a multiple of the velocity error
permitted in an interval. In a slower contact the error decides how the contact ends, and the
rigid-body law is more accurate."""

SAMPLES_OF_A_COURSE = 24
"""Least number of samples of a contact's force history, which are joined by straight lines in a
drawing. Samples are taken at the end and in the middle of each interval. With e* = 0.42 seven of
the 24 lie in restitution. The straight lines then differ from the force, a quarter of a sine wave,
by (pi/14)^2/8 = 0.6 % of the peak. With half as many samples the difference is 2.5 %, and the
drawing looks like a polygon."""

SAMPLES_OF_A_SWING = 5
"""Least number of intervals in half a period of the tangential spring's oscillation."""


@dataclass(eq=False)
class CompliantLaw(ContactLaw):
    """The law of contacts that last some time: a spring acts between wire and workpart.

    The spring's stiffness is given, or it follows from the duration of the contact or from the
    accuracy.

    Args:
        duration: duration of the first contact of a rigid wire without tangential compliance,
            engine units. For a wire that bends it is the duration that the contact would have if
            the wire were rigid and frictionless. With None, every contact is so short that its
            outcome agrees with the rigid-body limit to ``accuracy``.
        accuracy: requested relative accuracy.
        stiffness: stiffness of the spring in compression, engine units. If it is given, it is used
            in place of the stiffness that follows from ``duration``.
        tangential_compliance: tangential compliance eta^2, dimensionless.
        time_unit: unit of time of the scene (s) for messages.
    """

    duration: float | None
    accuracy: float
    stiffness: float | None = None
    tangential_compliance: float = 0.0
    time_unit: float = 1.0
    name = "compliant"
    instantaneous: ClassVar[bool] = False

    def __post_init__(self) -> None:
        """Record whether the user has given the duration."""
        self.finite_duration = self.duration is not None

    def spring(
        self, scene: Scene, state: State, pair: ContactPair, press: float = 0.0
    ) -> SpringContact | None:
        """Return the spring of a new contact; None if the touch is too slow to be simulated.

        Args:
            scene: the scene.
            state: the state at the touch.
            pair: the link and the workpart.
            press: acceleration (engine units) at which the contact point, if it were at rest, would
                approach the workpart.

        Raises:
            ValueError: if the contact is too short, or its restitution too small, for double
                precision.
        """
        assert isinstance(pair, WorkpartPair), "only the workpart's contacts are resolved in time"
        restitution = pair.restitution
        self._check(restitution)
        point, velocity = ending_together(contact_at(scene.mechanism, state, pair), self.accuracy)
        touch = point.touch
        approach = velocity[0]
        rigid = impact_at(point, velocity, pair)
        # Ratio of unloading time to loading time; 1 if the contact ends with compression.
        unloading = restitution or 1.0
        fastest = max(1.0, *map(abs, state.rates))
        # A tangential spring of less compliance is omitted here. The impact law takes a mean of the
        # impacts with and without a spring instead.
        compliance = (
            self.tangential_compliance if self.tangential_compliance >= LEAST_COMPLIANCE else 0.0
        )
        # A tangential spring amplifies the rounding error of positions by its stiffness.
        rounding = max(1.0, 1.0 / compliance) if compliance else 1.0
        duration = self.duration or self._shortest(scene, fastest, unloading / math.sqrt(rounding))
        depth = -approach * duration * unloading
        if self.stiffness is not None:
            depth = max(depth, press / (self.stiffness * point.inverse_mass[0][0]))
        if depth < LEAST_DEPTH:
            return None
        if self.stiffness is None and self.finite_duration and scene.effects.hinge[0]:
            self.stiffness = rigid_stiffness(scene.mechanism, state, touch, pair, duration)
        # The stiffness is a property of the surface, so later touches have the same stiffness. In
        # the rigid-body limit each touch has its own, which determines the duration alone.
        stiffness = self.stiffness or stiffness_for_duration(rigid, approach, restitution, duration)
        self.stiffness = self.stiffness if self.duration is None else stiffness
        longest = min(2.0 * duration / SAMPLES_OF_A_COURSE, damped_interval(scene))
        (normal, _), (_, tangential) = point.inverse_mass
        if compliance and tangential:
            rigid = impact_at(point, velocity, pair, compliance)
            rate = math.sqrt(stiffness / compliance * tangential)
            longest = min(longest, math.pi / (SAMPLES_OF_A_SWING * rate))
        # Largest change of a link's angular velocity while the normal velocity changes by 1
        turning = rounding * max(1.0, *(abs(each) / normal for each in point.response[0]))
        least = turning * FORCE_ROUNDING / (duration * unloading)
        tolerance = fastest * max(CONTACT_FRACTION * self.accuracy, least)
        if not self.finite_duration and -approach * unloading < SLOWEST_REBOUND * tolerance:
            return None
        law = ContactSpring(
            stiffness, restitution, pair.friction, pair.restitution_friction, compliance
        )
        return SpringContact(
            law=law,
            pair=pair,
            duration=duration,
            predicted=rigid.outcome_name,
            stepper=Extrapolation(tolerance, longest),
            surface=touch.gap,
            inverse_mass=point.inverse_mass,
            start=state,
        )

    def _shortest(self, scene: Scene, fastest: float, unloading: float) -> float:
        """Return a contact duration so short that the outcome agrees with the rigid-body limit.

        The duration is also long enough to keep rounding error small.

        Args:
            scene: the scene.
            fastest: largest angular velocity of a link, at least 1, in scene units.
            unloading: ratio of unloading time to loading time, divided by the square root of the
                factor by which a tangential spring amplifies rounding error.
        """
        damping = max(1.0, scene.effects.damping / scene.mechanism.links[0].inertia_about_joint)
        return max(
            LEAST_DURATION / math.sqrt(unloading * damping),
            0.1 * self.accuracy / max(fastest, damping),
        )

    def resolve(self, scene: Scene, state: State, pair: ContactPair) -> ContactRecord:
        """Apply the rigid-body law to a touch that is too slow to be simulated as a contact."""
        return EnergeticLaw(0.0, self.tangential_compliance).resolve(scene, state, pair)

    def _check(self, restitution: float) -> None:
        check_restitution(restitution)
        least = LEAST_DURATION / math.sqrt(restitution or 1.0)
        if self.duration is not None and self.duration < least:
            raise ValueError(
                f"contact_duration = {self.duration * self.time_unit:.3g}: must be at least"
                f" {least * self.time_unit:.3g}, or rounding would hide the penetration (in s)"
            )


def rigid_stiffness(
    mechanism: Mechanism, state: State, touch: ClosestApproach, pair: ContactPair, duration: float
) -> float:
    """Return the compression stiffness that gives a contact of the duration T (``duration``).

    The stiffness is k = (pi (1 + e*)/(2 T))^2/K_nn, with the energetic coefficient of restitution
    e*. This equation holds for a rigid, frictionless wire. ``touch`` is the closest approach at the
    first touch. The inverse mass along the normal is K_nn = l^2/I, with the lever l of the normal
    and the moment of inertia I of the straight wire, both about the root.
    """
    poses = mechanism.poses(state)
    root = poses[pair.link - pair.link % mechanism.wire_links].joint
    lever = cross(poses[pair.link].joint + touch.arm - root, touch.normal)
    inertia = float(mechanism.straight_mass_matrix().sum())
    return frictionless_stiffness(lever**2 / inertia, pair.restitution, duration)
