"""The constitutive law of a contact with springs: force over penetration, friction, and the foot of
the tangential spring.

The normal force over the penetration delta is bilinear: N = k delta while delta is larger than ever
before, and

    N = (k/e*^2) (delta - delta_r),    delta_r = (1 - e*^2) delta_max,

otherwise, down to 0 at delta_r. The spring thus returns e*^2 of the work it took, whatever the
bodies do (Stronge 1990).

Where the tangential compliance eta^2 is not 0, a spring of the stiffness k/eta^2 joins the point to
a foot on the surface. While the foot stands, T = -(k/eta^2) (x - x_foot). Where that would leave
the cone abs(T) <= mu N the foot slides in the sense s, with T = -mu s N, at the velocity v_t + mu s
eta^2 kappa v_n; kappa is 1 in loading and 1/e*^2 in unloading (Maw, Barber and Fawcett 1976;
Stronge, *Impact Mechanics*, 2nd ed., sec. 5).
"""

from __future__ import annotations

from dataclasses import dataclass

Vector = tuple[float, float]


@dataclass(frozen=True, slots=True)
class ContactSpring:
    """A contact's springs and friction; SI units, or the units of a scene.

    Attributes:
        stiffness: k in loading.
        restitution: energetic coefficient e*.
        friction, restitution_friction: Coulomb's mu in loading and in unloading.
        compliance: eta^2; 0 is rigid along the surface.

    >>> spring = ContactSpring(stiffness=1000.0, restitution=0.5, friction=0.3, restitution_friction=0.3)
    >>> spring.normal_force(0.25)
    250.0
    >>> spring.residual(0.5)
    0.375
    >>> spring.normal_force(0.5, deepest=0.5)
    500.0
    >>> spring.normal_force(0.375, deepest=0.5)
    0.0
    """

    stiffness: float
    restitution: float
    friction: float
    restitution_friction: float
    compliance: float = 0.0

    def residual(self, deepest: float) -> float:
        """Return delta_r, the penetration at which the force vanishes in unloading from the deepest
        one.
        """
        return deepest * (1.0 - self.restitution**2)

    def steepness(self, *, loading: bool) -> float:
        """Return kappa, the ratio of the stiffness in this phase to k.

        It is 1 in loading and 1/e*^2 in unloading; without restitution the force in unloading is 0,
        and so is kappa.
        """
        if loading:
            return 1.0
        return 1.0 / self.restitution**2 if self.restitution else 0.0

    def normal_force(self, penetration: float, deepest: float | None = None) -> float:
        """Return the normal force N at a penetration.

        ``deepest`` is the penetration from which the spring unloads; None means that it loads.
        """
        loading = deepest is None
        residual = 0.0 if deepest is None else self.residual(deepest)
        return self.stiffness * self.steepness(loading=loading) * (penetration - residual)

    def coefficient(self, *, loading: bool) -> float:
        """Return Coulomb's mu in loading or in unloading."""
        return self.friction if loading else self.restitution_friction

    def foot_velocity(self, velocity: Vector, slip: int, *, loading: bool) -> float:
        """Return the velocity of a sliding foot along the surface.

        ``velocity`` is that of the contact point, (normal, tangential); ``slip`` is the sense of
        sliding, -1 or 1.
        """
        stretching = (
            self.coefficient(loading=loading)
            * slip
            * self.compliance
            * self.steepness(loading=loading)
        )
        return velocity[1] + stretching * velocity[0]

    def tangential_force(self, place: float, foot: float) -> float:
        """Return the force T of the tangential spring between the point's place and its standing
        foot.
        """
        return -(self.stiffness / self.compliance) * (place - foot)

    def foot(self, place: float, force: float) -> float:
        """Return the place of the foot at which the tangential spring has a given force."""
        return place + force * self.compliance / self.stiffness
