"""Cutting as one statement of force, energy and depth: what Merchant's relation says of a tip that dives in obliquely.

Merchant's relation (4.31) says that a tip which cuts a chip of depth d_u and width b feels F_c = u b d_u along its path,
with the specific cutting energy u = tau_s cos(beta - alpha)/(sin(eta) cos(eta + beta - alpha)) fixed by the angles. On a
straight path that descends at gamma, the tip after the path S is S sin(gamma) below the surface and S tan(gamma) from
it along the normal to the path; this is d_u, so that depth = d_u cos(gamma) as in (4.50), and the face's width there is
b(S sin(gamma)). So

    F_c(S) = u b(S sin(gamma)) S tan(gamma),    W(S) = integral of F_c dS = u V(S),    V: volume swept.

``depth_from_force`` solves the first for a force, ``depth_from_energy`` the second for an energy, and ``cutting_stroke``
lets cutting alone stop the tip. The sum over plies of (4.50) differs from the first: it adds up dF_c/b with the width at
the time, although (4.31) ties the whole force to the width that is there last. The work-energy estimate (4.62) has the
energy right in kind, but divides it by the force of another event.

Assumed: straight path, rigid perfectly plastic work material, weightless chip, no spring-back, compression only, and a
face longer than the cut is deep.

``surface="parallel"`` measures the shear plane as (4.28) does, d_u/sin(eta) long, which is right for a surface parallel to
the path. The real surface rises from the path at gamma, so a shear plane at eta meets it after d_u cos(gamma)/sin(eta -
gamma). ``surface="inclined"`` takes that: least work then asks for eta - gamma = pi/4 - arccot(mu)/2, whatever gamma,

    R = 2 tau_s b depth/(1 - sin(arccot mu)),    u = 2 tau_s cos(gamma) cos(arccot(mu) - gamma)/(1 - sin(arccot mu)),

and the shear plane comes out of the surface for every mu > 0: the contradiction between mu >= tan(gamma) for the chip and
mu < tan(gamma) for the rebound (4.43) is one of where the shear plane ends.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.quantity import Range
from bristle_sim.theory.checks import not_negative, positive, ranges, require, single
from bristle_sim.theory.crater_kinematics import IMPACT_ANGLE, TipFace
from bristle_sim.theory.merchant import API_5L, oblique_angles

__all__ = [
    "CuttingStroke",
    "Surface",
    "cutting_stroke",
    "depth_from_energy",
    "depth_from_force",
    "specific_cutting_energy",
    "swept_volume",
]

Number = Any
"""A float where the arguments are, else an array of their broadcast shape."""

Surface = Literal["parallel", "inclined"]
"""How the surface lies to the path where the shear plane ends."""

_RULE = np.polynomial.legendre.leggauss(40)
NODES, WEIGHTS = 0.5 * (_RULE[0] + 1.0), 0.5 * _RULE[1]
"""Gauss-Legendre rule on (0, 1); the width is smooth in the substituted path up to the full depth and constant beyond."""

NEWTON_STEPS = 60
"""Steps allowed; from the start values given, about ten suffice."""


_arguments = ranges(
    Range("friction", "1", -1e300, 1e300, True, "Zhang 2020, eq. 4.51"),
    Range("impact_angle", "rad", -1e6, 1e6, True, "Zhang 2020, eq. 4.51"),
    Range("shear_yield_stress", "Pa", -1e30, 1e30, True, "Zhang 2020, eq. 4.53"),
    Range("path", "m", -1e30, 1e30, True, "Zhang 2020, eq. 4.4"),
    Range("energy", "J", -1e30, 1e30, True, "Zhang 2020, eq. 4.59"),
    Range("cutting_force", "N", -1e30, 1e30, True, "Zhang 2020, eq. 4.31"),
    Range("specific_energy", "J/m^3", -1e60, 1e60, True, "Zhang 2020, eq. 4.46"),
    Range("speed", "m/s", -1e15, 1e15, True, "Zhang 2020, eq. 4.5"),
    Range("effective_mass", "kg", -1e30, 1e30, True, "I/L^2"),
)
"""What is allowed for the arguments of these names; functions narrow it where they must."""

LEAST = 1e-60
"""Of angles, stresses, masses, speeds and specific energies: less makes depths that are no number."""


@dataclass(frozen=True, slots=True)
class CuttingStroke:
    """A tip stopped by cutting alone: crater depth and path in m, duration in s, largest force along the path in N."""

    depth: float
    path: float
    duration: float
    peak_cutting_force: float


@_arguments
def specific_cutting_energy(
    friction: ArrayLike,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    shear_yield_stress: ArrayLike = API_5L,
    surface: Surface = "parallel",
) -> Number:
    """Specific cutting energy u = F_c/(b d_u), J/m^3, for a surface parallel to the path or inclined to it.

    Raises:
        ValueError: if friction <= 0, gamma is not within 0 <= gamma < pi/2, the stress is not positive, or surface is not
            one of the two words.
    """
    positive("shear_yield_stress", shear_yield_stress, "Pa")
    require(
        "shear_yield_stress",
        shear_yield_stress,
        np.greater(shear_yield_stress, LEAST),
        f"more than {LEAST:g} is allowed (in Pa)",
    )
    angles = oblique_angles(friction, impact_angle, check=False)
    if surface == "parallel":
        return np.asarray(shear_yield_stress, dtype=float) / angles.cutting_ratio
    if surface != "inclined":
        raise ValueError(f"surface = {surface!r}: one word of parallel | inclined is allowed")
    # [1 - sin(arccot mu)]/2 = [1 - cos(arctan mu)]/2, in the form that does not cancel.
    room = np.sin(0.5 * np.arctan(np.asarray(friction, dtype=float))) ** 2
    return np.asarray(shear_yield_stress) * np.cos(impact_angle) * np.cos(angles.resultant_angle) / room


@_arguments
def swept_volume(path: ArrayLike, impact_angle: ArrayLike = IMPACT_ANGLE, face: TipFace | None = None) -> Number:
    """Volume V(S) that the face sweeps below the surface, integral of b(S' sin(gamma)) S' tan(gamma) dS', m^3.

    Up to the full depth the substitution S' = S u^2 makes the integrand smooth; from there on the width is constant.
    """
    face = TipFace() if face is None else face
    path, gamma = np.asarray(path, dtype=float), np.asarray(impact_angle, dtype=float)
    not_negative("path", path, "m")
    _check_angle(gamma)
    full = face.full_depth / np.sin(gamma)
    narrow = np.minimum(path, full)[..., np.newaxis]
    widths = face.width(narrow * NODES**2 * np.sin(gamma)[..., np.newaxis])
    inner = np.sum(WEIGHTS * widths * 2.0 * NODES**3, axis=-1) * narrow[..., 0] ** 2
    outer = 0.5 * face.short_axis * (np.maximum(path, full) ** 2 - full**2)
    return (inner + outer) * np.tan(gamma)


@_arguments
def depth_from_energy(
    energy: ArrayLike,
    specific_energy: ArrayLike,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    face: TipFace | None = None,
) -> Number:
    """Crater depth whose volume takes the energy, u V(S) = W, depth = S sin(gamma), m.

    Args:
        energy: W, work that the tip does on the workpart along its path, J.
        specific_energy: u, J/m^3.
        impact_angle: gamma, rad; above 0, or the tip never enters.
        face: of the tip.

    Raises:
        ValueError: if energy is negative, u not positive or gamma not within 0 < gamma < pi/2.
    """
    face = TipFace() if face is None else face
    not_negative("energy", energy, "J")
    positive("specific_energy", specific_energy, "J/m^3")
    require(
        "specific_energy",
        specific_energy,
        np.greater(specific_energy, LEAST),
        f"more than {LEAST:g} is allowed (in J/m^3)",
    )
    _check_angle(impact_angle)
    volume, slope = np.asarray(energy, dtype=float) / specific_energy, np.tan(impact_angle)

    def excess(path: Number) -> tuple[Number, Number]:
        width = face.width(path * np.sin(impact_angle))
        return swept_volume(path, impact_angle, face) - volume, width * path * slope

    # The full width everywhere would need the least path; the volume is convex in it, so Newton's method converges.
    return np.sin(impact_angle) * _root(excess, np.sqrt(2.0 * volume / (face.short_axis * slope)))


@_arguments
def depth_from_force(
    cutting_force: ArrayLike,
    specific_energy: ArrayLike,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    face: TipFace | None = None,
) -> Number:
    """Crater depth at which the chip resists with the force, u b(depth) depth/cos(gamma) = F_c, m; no plies, no b(t).

    Args and errors as for depth_from_energy; cutting_force is that along the path, N.
    """
    face = TipFace() if face is None else face
    not_negative("cutting_force", cutting_force, "N")
    positive("specific_energy", specific_energy, "J/m^3")
    require(
        "specific_energy",
        specific_energy,
        np.greater(specific_energy, LEAST),
        f"more than {LEAST:g} is allowed (in J/m^3)",
    )
    _check_angle(impact_angle)
    area = np.asarray(cutting_force, dtype=float) * np.cos(impact_angle) / np.asarray(specific_energy, dtype=float)
    # Beyond the full depth the width is constant, and b(depth) depth = area is linear.
    wide = area / face.short_axis
    share = np.minimum(wide / face.full_depth, 1.0)

    def excess(root: Number) -> tuple[Number, Number]:
        # b depth = d D y^3 sqrt(2 - y^2) with y^2 = depth/D, D the full depth; it rises up to y = 1.22.
        rest = np.sqrt(2.0 - root**2)
        return root**3 * rest - share, 3.0 * root**2 * rest - root**4 / rest

    narrow = face.full_depth * _root(excess, np.cbrt(share / math.sqrt(2.0))) ** 2
    return np.where(wide >= face.full_depth, wide, narrow)[()]


@_arguments
def cutting_stroke(
    speed: float,
    effective_mass: float,
    specific_energy: float,
    impact_angle: float = IMPACT_ANGLE,
    face: TipFace | None = None,
) -> CuttingStroke:
    """Stop a tip by cutting alone, (effective_mass) dv/dt = -u b d_u.

    Args:
        speed: of the tip along its path when it touches, m/s.
        effective_mass: at the tip along the path, kg; m/3 for a bristle on a hub that keeps its speed.
        specific_energy: u, J/m^3.
        impact_angle: gamma, rad.
        face: of the tip.

    Raises:
        ValueError: if speed, mass or u is not positive or gamma not within 0 < gamma < pi/2.
    """
    face = TipFace() if face is None else face
    for name, value, unit in (("speed", speed, "m/s"), ("effective_mass", effective_mass, "kg")):
        positive(name, value, unit)
        require(name, value, value > LEAST, f"more than {LEAST:g} is allowed (in {unit})")
    for name, value in (("speed", speed), ("effective_mass", effective_mass), ("specific_energy", specific_energy)):
        single(name, value)
    single("impact_angle", impact_angle)
    depth = float(depth_from_energy(0.5 * effective_mass * speed**2, specific_energy, impact_angle, face))
    path = depth / math.sin(impact_angle)
    # v = speed sqrt(1 - V/V_end) vanishes like a root at the end: S = path (1 - w^2) takes it away.
    places = path * (1.0 - NODES**2)
    left = 1.0 - swept_volume(places, impact_angle, face) / swept_volume(path, impact_angle, face)
    duration = float(np.sum(WEIGHTS * 2.0 * NODES * path / (speed * np.sqrt(left))))
    force = specific_energy * float(face.width(depth)) * depth / math.cos(impact_angle)
    return CuttingStroke(depth, path, duration, force)


def _check_angle(impact_angle: ArrayLike) -> None:
    gamma = np.asarray(impact_angle, dtype=float)
    require(
        "impact_angle", gamma, (gamma > LEAST) & (gamma < 0.5 * math.pi), "0 < impact_angle < pi/2 is allowed (in rad)"
    )


def _root(excess: Callable[[Number], tuple[Number, Number]], start: Number) -> Number:
    """Newton's method for a rising function from a start close below its root; where the start is 0 so is the root."""
    root = np.asarray(start, dtype=float)
    for _ in range(NEWTON_STEPS):
        value, slope = excess(root)
        step = np.divide(value, slope, out=np.zeros(np.broadcast(value, slope).shape), where=np.asarray(slope) > 0.0)
        root = root - step
        if np.all(np.abs(step) <= 1e-14 * np.abs(root)):
            break
    return root[()]
