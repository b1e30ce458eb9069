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
    """The state of all links: time (s), absolute angles (rad) and absolute rates (rad/s)."""

    time: float
    angles: Array
    rates: Array


@dataclass(slots=True, eq=False)
class Sustained:
    """A sustained contact; it is rigid unless it is an object of the subclass.

    Attributes:
        point: location of the contact on the wire.
        surface: coefficients of the contact.
        since: state at the start of the contact.
        velocity_before: (normal, tangential) contact velocity at the start, m/s.
        slip: sense of the slip; 0 in stick.
        sums: normal and tangential impulse (N s) and normal and tangential work (J) so far.
        compression: impulses and works, as in ``sums``, at the end of compression; None before it,
            and for a contact without compression.
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
        """Coulomb's coefficient of friction at present."""
        return self.surface.friction

    def acting(self, touch: Touch) -> Acting:
        """Return the contact with its kinematics and the forces of its springs."""
        return Acting(touch, self.friction, self.slip)


@dataclass(slots=True, eq=False, kw_only=True)
class Compliant(Sustained):
    """A sustained contact with a normal spring and perhaps a tangential one.

    Attributes:
        law: stiffness, restitution and friction of the contact.
        level: gap at which the contact began, from which the penetration is measured, m. It is
            negative in the dent of an earlier contact.
        anchor: position of the tangential spring's foot along the surface while it sticks, m.
        deepest: deepest penetration, m.
        loading: whether the normal spring is in loading.
    """

    law: ContactSpring
    level: float
    anchor: float
    deepest: float = 0.0
    loading: bool = True

    @property
    def friction(self) -> float:
        """Coulomb's coefficient of friction; while the spring unloads, that in restitution."""
        return self.law.coefficient(loading=self.loading)

    def acting(self, touch: Touch) -> Acting:
        """Return the contact with its kinematics and the forces of its springs."""
        return Acting(touch, self.friction, self.slip, self.force(touch.gap), self.rub(touch))

    def force(self, gap: float) -> float:
        """Return the normal force (N) at a gap (m), measured from the undented surface."""
        return self.law.normal_force(self.level - gap, None if self.loading else self.deepest)

    def rub(self, touch: Touch) -> float | None:
        """Return the tangential force, N; None if the contact is rigid along the surface."""
        if not self.law.compliance:
            return None
        if self.slip:
            return -self.friction * self.slip * self.force(touch.gap)
        return self.law.tangential_force(touch.along, self.anchor)

    def foot(self, touch: Touch, slip: int) -> float:
        """Return the velocity of the tangential spring's foot in a sense of slip, m/s.

        Without a tangential spring it is the velocity of the contact point in this sense.
        """
        normal, tangential = touch.velocity.tolist()
        return slip * self.law.foot_velocity((normal, tangential), slip, loading=self.loading)
