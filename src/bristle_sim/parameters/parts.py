"""The parts of a tool: hub, belt, bristle, bar, workpart and contact law."""

import math
from dataclasses import dataclass
from typing import Any

from bristle_sim.arrays import Number
from bristle_sim.declared import Computed, Declared, declarations
from bristle_sim.fields import ANY, choice, count, quantity

Vector = tuple[float, float]

PRINTED_BELT_STIFFNESS = (
    0.00041  # N m/deg; printed with the unit N m/rad (Zhang 2020, eq. 2.2), which must be an error
)
# Usual hub speeds, rad/s: 10 to 14 000 rpm. A speed in rpm that is typed without its unit is
# usually larger, and causes a warning.
USUAL_HUB_SPEEDS = (1.0, 1500.0)
# Usual belt stiffnesses, N m/rad. The printed value is per degree, and so smaller than these.
USUAL_BELT_STIFFNESSES = (1e-3, 2.5)

# Printed mass (kg), length (m), diameter (m) and density (kg/m^3) of the wire (Zhang 2020, fig.
# 2.7, eq. 2.2, sec. 4.1).
PRINTED_MASS = 8.387e-5
PRINTED_LENGTH = 0.027
PRINTED_DIAMETER = 7.1e-4
PRINTED_DENSITY = PRINTED_MASS / (
    math.pi / 4.0 * PRINTED_DIAMETER**2 * PRINTED_LENGTH
)  # 7,845.78 kg/m^3: steel
USUAL_MASSES = (PRINTED_MASS / 100.0, PRINTED_MASS * 100.0)  # of a bristle, kg
RETRACTION_AT_RELEASE = math.radians(44.5)  # retraction theta_p, rad (Zhang 2020, eq. 2.2)
WIRE_KEYS = ("wire_links", "wire_modulus", "wire_damping_ratio")  # keys of a wire that bends
CONTACT_KEYS = ("contact", "contact_duration", "tangential_compliance")  # keys of the law of impact
SURFACE_KEYS = (
    "friction",
    "restitution_friction",
    "restitution",
)  # keys of the tip on the workpart
SHAPE_KEYS = (
    "knee_position",
    "knee_angle_deg",
    *WIRE_KEYS,
)  # keys of a wire that is not one straight rod


@dataclass(frozen=True, slots=True)
class Hub(Declared):
    """Hub that rotates at constant speed."""

    speed: float = quantity(
        261.8,
        "0 <= hub_speed <= 1e6 rad/s: speed of the hub's rotation [Zhang 2020, eq. 2.2]",
        usual=USUAL_HUB_SPEEDS,
    )
    radius: float = quantity(
        0.0275,
        "0 <= hub_radius <= 10 m: distance of the bristle's root from the hub's centre"
        " [Zhang 2020, eq. 2.2: root circle]",
    )


@dataclass(frozen=True, slots=True)
class Belt(Declared):
    """Flexible belt: a torsion spring at the bristle's root, with or without damping."""

    stiffness: float = quantity(
        math.degrees(PRINTED_BELT_STIFFNESS),
        "0 <= belt_stiffness <= 1e9 N m/rad: torsional stiffness of the belt at the bristle's root"
        " [Zhang 2020, eq. 2.2: 0.00041 N m read per degree]",
        usual=USUAL_BELT_STIFFNESSES,
    )
    damping_ratio: float = quantity(
        0.0,
        "0 <= belt_damping_ratio <= 1e3: damping ratio of the bristle on its belt; 1 is critical"
        " [undamped as in Zhang 2020]",
    )


def mass_of_volume(length: Number, diameter: Number, density: Number) -> Number:
    """Return the mass of a wire (kg) from its length (m), diameter (m) and density (kg/m^3).

    The mass printed in the dissertation is scaled by the ratios of these values to the printed
    values. A wire with the printed values therefore has exactly the printed mass.
    """
    section = (diameter / PRINTED_DIAMETER) ** 2
    return PRINTED_MASS * section * (length / PRINTED_LENGTH) * (density / PRINTED_DENSITY)


@dataclass(frozen=True, slots=True)
class Bristle(Declared):
    """Slender wire, straight or with one knee.

    The wire is one rigid rod, or a chain of equal rigid links that bends at the joints. If no mass
    is given, the mass is the density times the wire's volume. In a changed copy
    (``dataclasses.replace``) such a mass is computed anew, but a given mass stays the same.
    """

    length: float = quantity(
        PRINTED_LENGTH,
        "1e-9 <= bristle_length <= 10 m: length of the wire from root to tip, along its centre line"
        " [Zhang 2020, eq. 2.2]",
    )
    mass: float = quantity(
        None,
        "1e-30 <= bristle_mass <= 1e6 kg: mass of one bristle; none: wire_density times the wire's volume"
        " [the wire's volume: 8.387e-5 kg as printed]",
        usual=USUAL_MASSES,
    )
    wire_diameter: float = quantity(
        PRINTED_DIAMETER,
        "0 <= wire_diameter <= 10 m: diameter of the wire; the bar touches the wire half a diameter beside its centre line"
        " [Zhang 2020, sec. 4.1: tip ellipse]",
    )
    knee_position: float = quantity(
        0.75,
        "0.01 <= knee_position <= 0.99: distance of the knee from the root, as a fraction of the length"
        " [assumed: fraction of the length; Zhang 2020, fig. 1.3]",
        needs="knee_angle_deg != 0",
    )
    knee_angle_deg: float = quantity(
        0.0,
        "-90 <= knee_angle_deg <= 90 deg: bend at the knee; positive bends the tip forward, in the hub's sense"
        " [straight as in Zhang 2020, fig. 2.5]",
    )
    links: int = count(
        1,
        "1 <= wire_links <= 64: number of equal rigid links of the wire; 1 is a rigid bristle"
        " [rigid as in Zhang 2020, sec. 2.3]",
    )
    modulus: float = quantity(
        2e11,
        "0 < wire_modulus <= 1e15 Pa: Young's modulus of the wire, from which the stiffness of the hinges between its links follows"
        " [steel: E = 2e11 Pa]",
        needs="wire_links != 1",
    )
    bending_damping_ratio: float = quantity(
        0.0,
        "0 <= wire_damping_ratio <= 1e3: damping ratio of the wire's first bending mode [undamped as in Zhang 2020]",
        needs="wire_links != 1",
    )
    density: float = quantity(
        PRINTED_DENSITY,
        "1e-3 <= wire_density <= 1e6 kg/m^3: density of the wire, from which its mass follows"
        " [Zhang 2020, caption of fig. 2.7: 8.387e-5 kg divided by the wire's volume; steel]",
        needs="bristle_mass = none",
    )

    def __post_init__(self) -> None:
        given: float | None = None if isinstance(self.mass, Computed) else self.mass
        object.__setattr__(self, "mass", given)
        Declared.__post_init__(self)
        if given is None:
            mass = mass_of_volume(self.length, self.wire_diameter, self.density)
            declared = declarations(Bristle)["mass"]
            if not declared.lowest <= mass <= declared.highest:
                why = "; not given, it follows from bristle_length, wire_diameter and wire_density"
                raise declared.refusal(mass, why)
            object.__setattr__(self, "mass", Computed(mass))

    @property
    def path(self) -> tuple[Vector, ...]:
        """Corners of the centre line, m: the knee, if there is one, and the tip.

        The root is the origin. The shank, from root to knee, points along (0, -1).
        """
        if self.knee_angle_deg == 0.0:
            return ((0.0, -self.length),)
        shank = self.knee_position * self.length
        bend = math.radians(self.knee_angle_deg)
        rest = self.length - shank
        return ((0.0, -shank), (rest * math.sin(bend), -shank - rest * math.cos(bend)))

    @property
    def centre(self) -> Vector:
        """Centre of mass (m) in the axes of ``path``: root at the origin, shank along (0, -1)."""
        if self.knee_angle_deg == 0.0:
            return (0.0, -0.5 * self.length)
        (x, y), (u, v), rest = *self.path, 1.0 - self.knee_position
        return (0.5 * (x + rest * u), 0.5 * (y + rest * v))

    @property
    def inertia_about_centre(self) -> float:
        """Moment of inertia about the centre of mass, kg m^2.

        For a straight bristle the value is m L^2/12 (Zhang 2020, eq. 2.22).
        """
        if self.knee_angle_deg == 0.0:
            return self.mass * self.length**2 / 12.0
        x, y = self.centre
        return self.inertia_about_root - self.mass * (x * x + y * y)

    @property
    def inertia_about_root(self) -> float:
        """Moment of inertia about the root, kg m^2.

        A straight segment of mass m from the point a to the point b, measured from the root,
        contributes m (a.a + a.b + b.b)/3.
        """
        if self.knee_angle_deg == 0.0:
            return self.mass * self.length**2 / 3.0
        (x, y), (u, v), knee = *self.path, self.knee_position
        shank = x * x + y * y
        return (
            self.mass
            * (knee * shank + (1.0 - knee) * (shank + x * u + y * v + u * u + v * v))
            / 3.0
        )


def _bar_radius() -> float:
    """Return the bar radius (m) with which the bar touches the tip at a retraction of 44.5 deg.

    The position of the bar and the retraction are those printed in the dissertation.
    """
    hub_radius = 0.0275
    length = PRINTED_LENGTH
    tip_radius = math.sqrt(
        hub_radius**2 + length**2 + 2.0 * hub_radius * length * math.cos(RETRACTION_AT_RELEASE)
    )
    return math.hypot(0.05037, 0.0225) - PRINTED_DIAMETER / 2.0 - tip_radius


@dataclass(frozen=True, slots=True)
class Bar(Declared):
    """Accelerator bar: a fixed, rigid circle on the side from which the bristles come."""

    radius: float = quantity(
        _bar_radius(),
        "0 < bar_radius <= 10 m: radius of the accelerator bar"
        " [from Zhang 2020, eqs. 2.1-2.3: touches the wire at a retraction of 44.5 deg]",
    )
    horizontal: float = quantity(
        0.05037,
        "0 <= bar_horizontal <= 10 m: distance of the bar's centre from the hub's, along the workpart, on the"
        " incoming side [Zhang 2020, eq. 2.3: S_H]",
    )
    vertical: float = quantity(
        0.0225,
        "-10 <= bar_vertical <= 10 m: distance of the bar's centre below the hub's [Zhang 2020, eq. 2.3: S_V]",
    )
    friction: float = quantity(
        0.0,
        "0 <= bar_friction <= 1e6: coefficient of friction between wire and bar"
        " [frictionless as in Zhang 2020, sec. 2.2]",
    )
    restitution: float = quantity(
        0.0,
        "0 <= bar_restitution <= 1: energetic coefficient of restitution between wire and bar"
        " [assumed: the bar does not throw the wire back]",
    )

    @property
    def centre(self) -> tuple[float, float]:
        """Position of the bar's centre, (x, y) from the hub's centre, m."""
        return (-self.horizontal, -self.vertical)

    def closest(self, lines: Any) -> Any:
        """Return, for each straight segment, its point closest to the bar.

        ``lines`` holds the corners of centre lines as complex numbers x + i y from the hub's centre
        (m), shape (..., corners). The points have the shape (..., corners - 1).
        """
        start = lines[..., :-1]
        along = lines[..., 1:] - start
        fraction = ((complex(*self.centre) - start) / along).real
        return start + fraction.clip(0.0, 1.0) * along


@dataclass(frozen=True, slots=True)
class Surface(Declared):
    """Friction and restitution of a tip on a flat, rigid surface."""

    friction: float = quantity(
        0.31,
        "0 <= friction <= 1e9: coefficient of friction between tip and workpart during compression, mu_1"
        " [Zhang 2020, caption of fig. 2.8: mu_1]",
    )
    restitution_friction: float | None = quantity(
        None,
        "0 <= restitution_friction <= 1e9: coefficient of friction during restitution, mu_2; none: equal to friction"
        " [Zhang 2020, case II: equal to friction]",
    )
    restitution: float = quantity(
        0.42,
        "0 <= restitution <= 1: energetic coefficient of restitution between tip and workpart, e*"
        " [Zhang 2020, caption of fig. 2.13: energetic coefficient e*]",
    )

    @property
    def friction_in_restitution(self) -> float:
        """Coefficient of friction mu_2 during restitution.

        The value is ``restitution_friction``, or ``friction`` if ``restitution_friction`` is None.
        """
        return self.friction if self.restitution_friction is None else self.restitution_friction


@dataclass(frozen=True, slots=True)
class Workpart(Surface):
    """Flat, rigid workpart below the hub."""

    penetration: float = quantity(
        0.0045,
        "-10 <= penetration <= 10 m: depth by which the workpart cuts into the circle of undeflected tips, Delta"
        " [Zhang 2020, eq. 2.2: Delta = hub radius + bristle length - height of the hub's centre]",
    )


@dataclass(frozen=True, slots=True)
class Contact(Declared):
    """Law of impact between tip and workpart.

    ``energetic`` is an instantaneous impact with energetic restitution. ``compliant`` is a contact
    of finite duration with a stiff spring. ``engine`` is the physics engine's own contact.
    """

    law: str = choice(
        "contact: law of impact: instantaneous by energy, of finite duration on a spring, or the engine's own"
        " [Stronge 1990: energetic restitution]",
        *("energetic", "compliant", "engine"),
    )
    duration: float | None = quantity(
        None,
        "1e-18 <= contact_duration <= 1 s: duration of the first contact; of a wire that bends, as if it were rigid and without friction; none: short"
        " enough for the rigid-body limit [short enough for the rigid-body limit]",
        needs="contact = compliant",
    )
    tangential_compliance: float = quantity(
        0.0,
        "0 <= tangential_compliance <= 1e4: stiffness of the contact along its normal divided by its stiffness along the surface,"
        " eta^2; 1.21: steel [chosen: rigid along the surface]",
        usual=ANY,
    )

    def __post_init__(self) -> None:
        Declared.__post_init__(self)
        if self.tangential_compliance and self.law == "engine":
            raise ValueError(
                f"tangential_compliance = {self.tangential_compliance:g}: must be 0 with contact = engine (dimensionless)"
            )
        if self.duration is not None and self.law != "compliant":
            raise ValueError(
                f"contact_duration = {self.duration:g}: must be left out with contact = {self.law}, whose impacts are not"
                " resolved in time (in s)"
            )
