"""The force law of a contact with springs: normal force over penetration, friction, and the foot of
the tangential spring.

The normal force N is bilinear in the penetration delta: N = k delta while delta exceeds every
earlier value, and

    N = (k/e*^2) (delta - delta_r),    delta_r = (1 - e*^2) delta_max,

otherwise, down to 0 at delta_r. The spring thus returns e*^2 of the work it took, for any motion of
the bodies (Stronge 1990).

Where the tangential compliance eta^2 is not 0, a spring of the stiffness k/eta^2 joins the contact
point to a foot on the surface. While the foot stands, T = -(k/eta^2) (x - x_foot). Where this force
would leave the friction cone abs(T) <= mu N, the foot slides in the sense s, with T = -mu s N, at
the velocity v_t + mu s eta^2 kappa v_n. The stiffness ratio kappa is 1 in loading and 1/e*^2 in
unloading (Maw, Barber and Fawcett 1976; Stronge, *Impact Mechanics*, 2nd ed., sec. 5).
"""

from __future__ import annotations

from dataclasses import dataclass

Vector = tuple[float, float]


@dataclass(frozen=True, slots=True)
class ContactSpring:
    """The springs and the friction of a contact, in SI or any other consistent units.

    Attributes:
        stiffness: normal stiffness k in loading.
        restitution: energetic coefficient of restitution e*.
        friction: Coulomb's coefficient of friction in loading.
        restitution_friction: Coulomb's coefficient of friction in unloading.
        compliance: ratio eta^2 of the normal to the tangential stiffness. With 0 there is no
            tangential spring: the contact is rigid along the surface.
        deepest: penetration at which unloading began; None while the normal spring is loading.

    A spring with e* = 0.5 is loaded to a penetration of 0.5 and unloads to the residual 0.375:

    >>> from dataclasses import replace
    >>> spring = ContactSpring(stiffness=1000.0, restitution=0.5, friction=0.3, restitution_friction=0.3)
    >>> spring.normal_force(0.25)
    250.0
    >>> unloading = replace(spring, deepest=0.5)
    >>> unloading.residual
    0.375
    >>> unloading.normal_force(0.5)
    500.0
    >>> unloading.normal_force(0.375)
    0.0
    """

    stiffness: float
    restitution: float
    friction: float
    restitution_friction: float
    compliance: float = 0.0
    deepest: float | None = None

    @property
    def loading(self) -> bool:
        """Whether the normal spring is being loaded (True) or unloaded."""
        return self.deepest is None

    @property
    def residual(self) -> float:
        """Penetration at which the normal force is 0: in unloading that of the dent."""
        return 0.0 if self.deepest is None else self.deepest * (1.0 - self.restitution**2)

    @property
    def steepness(self) -> float:
        """Present normal stiffness divided by that in loading.

        This ratio kappa is 1 in loading and 1/e*^2 in unloading. Without restitution (e* = 0) it is
        0 in unloading, because there is no force.
        """
        if self.deepest is None:
            return 1.0
        return 1.0 / self.restitution**2 if self.restitution else 0.0

    @property
    def coefficient(self) -> float:
        """Coulomb's coefficient of friction in the present phase."""
        return self.friction if self.deepest is None else self.restitution_friction

    def normal_force(self, penetration: float) -> float:
        """Return the normal force at a penetration."""
        return self.stiffness * self.steepness * (penetration - self.residual)

    def foot_velocity(self, velocity: Vector, slip: int) -> float:
        """Return the velocity of the tangential spring's sliding foot along the surface.

        Without a tangential spring it is the tangential velocity of the contact point.

        ``velocity`` is the (normal, tangential) velocity of the contact point. ``slip`` is the
        sense in which the foot slides, -1 or 1.
        """
        stretching = self.coefficient * slip * self.compliance * self.steepness
        return velocity[1] + stretching * velocity[0]

    def tangential_force(self, place: float, foot: float) -> float:
        """Return the force of the tangential spring while its foot sticks.

        ``place`` is the coordinate of the contact point along the surface, ``foot`` that of the
        foot.
        """
        return -(self.stiffness / self.compliance) * (place - foot)

    def foot(self, place: float, force: float) -> float:
        """Return the coordinate along the surface at which the tangential spring's foot must be.

        ``place`` is the coordinate of the contact point, ``force`` the force of the spring.
        """
        return place + force * self.compliance / self.stiffness
