"""A state of all links, and a sustained contact with its springs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Surface
from bristle_sim.reference.contacts import Point, Touch
from bristle_sim.reference.forces import Acting
from bristle_sim.theory.contact_spring import ContactSpring


class State(NamedTuple):
    """The state of all links: time (s), absolute angles (rad) and angular velocities (rad/s)."""

    time: float
    angles: Array
    rates: Array


@dataclass(slots=True, eq=False)
class Sustained:
    """A sustained contact. It is rigid unless it belongs to the subclass ``Compliant``.

    Attributes:
        point: point of the wire at which the contact acts.
        surface: coefficients of friction and restitution.
        since: state at the start of the contact.
        velocity_before: (normal, tangential) contact velocity at the start, m/s.
        slip: sign of the slip velocity; 0 in stick.
        sums: normal and tangential impulse (N s), and normal and tangential work (J), so far.
        compression: value of ``sums`` at the end of compression. None during compression, and for a
            rigid contact.
    """

    point: Point
    surface: Surface
    since: State
    velocity_before: Array
    slip: int = 0
    sums: Array = field(default_factory=lambda: np.zeros(4))
    compression: Array | None = None

    @property
    def friction(self) -> float:
        """Coulomb's coefficient of friction in the present phase of the contact."""
        return self.surface.friction

    def acting(self, touch: Touch) -> Acting:
        """Return the contact with its kinematics and friction.

        ``touch`` is the kinematics at the present instant.
        """
        return Acting(touch, self.friction, self.slip)


@dataclass(slots=True, eq=False, kw_only=True)
class Compliant(Sustained):
    """A sustained contact with a normal spring and, if the law has one, a tangential spring.

    Attributes:
        law: force law of the springs in the present phase.
        level: gap at which the contact began, m; penetration is measured from it. It is negative if
            the contact began in the dent of an earlier contact.
        anchor: coordinate of the tangential spring's foot along the surface while it sticks, m. The
            foot is the end of the spring at the workpart.
    """

    law: ContactSpring
    level: float
    anchor: float

    @property
    def friction(self) -> float:
        """Coulomb's coefficient of friction: that of restitution while the spring unloads."""
        return self.law.coefficient

    @property
    def steepest(self) -> float:
        """Largest stiffness of the contact's springs in any phase, N/m."""
        law = self.law
        return law.stiffness / min(1.0, law.restitution**2 or 1.0, law.compliance or 1.0)

    def acting(self, touch: Touch) -> Acting:
        """Return the contact with its kinematics and the forces of its springs."""
        return Acting(touch, self.friction, self.slip, self.force(touch.gap), self.rub(touch))

    def force(self, gap: float) -> float:
        """Return the normal force (N) at a gap (m) from the original surface."""
        return self.law.normal_force(self.level - gap)

    def rub(self, touch: Touch) -> float | None:
        """Return the force of the tangential spring, N; None without a tangential spring."""
        if not self.law.compliance:
            return None
        if self.slip:
            return -self.friction * self.slip * self.force(touch.gap)
        return self.law.tangential_force(touch.along, self.anchor)

    def foot(self, touch: Touch, slip: int) -> float:
        """Return the velocity of the tangential spring's foot in the sense of ``slip``, m/s.

        Without a tangential spring it is the velocity of the contact point.
        """
        normal, tangential = touch.velocity.tolist()
        return slip * self.law.foot_velocity((normal, tangential), slip)
