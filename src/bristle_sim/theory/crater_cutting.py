"""Crater depth from one statement of cutting force, energy and depth, also for a contact resolved in time.

Merchant's relation (4.31) says that a tip which cuts a chip of depth d_u and width b feels F_c = u b d_u along its path,
with the specific cutting energy u = tau_s cos(beta - alpha)/(sin(eta) cos(eta + beta - alpha)) fixed by the angles. On a
straight path that descends at gamma, the tip after the path S is S sin(gamma) below the surface and S tan(gamma) from
it along the normal to the path; this is d_u, so that depth = d_u cos(gamma) as in (4.50), and the face's width there is
b(S sin(gamma)). So

    F_c(S) = u b(S sin(gamma)) S tan(gamma),    W(S) = integral of F_c dS = u V(S),    V: volume swept.

``depth_from_force`` solves the first for a force, ``depth_from_energy`` the second for an energy. The sum over plies of (4.50)
differs from the first: it adds up dF_c/b with the width at the time, although (4.31) ties the whole force to the last width.

A contact resolved in time gives both: up to its deepest penetration the force along the path, N sin(gamma) + |T| cos(gamma),
is F_c, and the work of both forces on the tip is W. The two depths agree only if the contact is as stiff as the chip is: the
energy does not depend on how long the contact lasts, a force is inversely proportional to it.

Assumed: straight path, rigid perfectly plastic work material, weightless chip, no spring-back, compression only, and a
face longer than the cut is deep. The angle is within 0 < gamma < pi/2, in rad.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Number
from bristle_sim.theory.crater_kinematics import IMPACT_ANGLE, PRINTED_FACE, TipFace
from bristle_sim.theory.merchant import API_5L, Surface, specific_cutting_energy
from bristle_sim.theory.numbers import require

_RULE = np.polynomial.legendre.leggauss(40)
NODES = 0.5 * (_RULE[0] + 1.0)
WEIGHTS = 0.5 * _RULE[1]
"""Gauss-Legendre rule on (0, 1).

The width is smooth in the substituted path up to the full depth, and constant beyond."""

NEWTON_STEPS = 60  # largest number of steps; about ten suffice from the start values used here


@dataclass(frozen=True, slots=True)
class ContactCrater:
    """Results of a contact's compression, from first touch to deepest penetration, and its craters.

    Attributes:
        compression_time: time from first touch to deepest penetration, s.
        peak_cutting_force: largest force along the path, N.
        path: length of the tip's path, m.
        penetration: deepest penetration, m.
        depth_from_force: crater depth that follows from the largest force, m.
        depth_from_energy: crater depth that follows from the work, m.
        shear_plane_emerges: whether eta >= gamma with the friction used. If not, the depths for a
            parallel surface are formal.
    """

    compression_time: float
    peak_cutting_force: float
    path: float
    penetration: float
    depth_from_force: float
    depth_from_energy: float
    shear_plane_emerges: bool


def swept_volume(
    path: ArrayLike, impact_angle: ArrayLike = IMPACT_ANGLE, face: TipFace = PRINTED_FACE
) -> Number:
    """Return the volume V(S) that the face sweeps below the surface on a path S (m), m^3.

    It is the integral of b(S' sin(gamma)) S' tan(gamma) dS'.

    Up to the full depth the substitution S' = S u^2 makes the integrand smooth; from there on the
    width is constant.
    """
    gamma = np.asarray(impact_angle)
    full = face.full_depth / np.sin(gamma)
    narrow = np.minimum(path, full)[..., np.newaxis]
    widths = face.width(narrow * NODES**2 * np.sin(gamma)[..., np.newaxis])
    inner = np.sum(WEIGHTS * widths * 2.0 * NODES**3, axis=-1) * narrow[..., 0] ** 2
    outer = 0.5 * face.short_axis * (np.maximum(path, full) ** 2 - full**2)
    return (inner + outer) * np.tan(gamma)


def depth_from_energy(
    energy: ArrayLike,
    specific_energy: ArrayLike,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    face: TipFace = PRINTED_FACE,
) -> Number:
    """Return the crater depth S sin(gamma), m, whose volume V(S) satisfies u V(S) = W.

    W in J is the work that the tip does on the workpart along its path, u in J/m^3.

    The energy of a swept volume gives the depth of its path:

    >>> path, angle = 1e-4, math.radians(30.0)
    >>> print(f"{depth_from_energy(1e9 * swept_volume(path, angle), 1e9, angle) / path:.6f}")  # sin(30 deg)
    0.500000
    """
    volume = np.divide(energy, specific_energy)
    slope = np.tan(impact_angle)

    def excess(path: Number) -> tuple[Number, Number]:
        width = face.width(path * np.sin(impact_angle))
        return swept_volume(path, impact_angle, face) - volume, width * path * slope

    # The start is the path at full width everywhere, which is the shortest. The volume is a convex
    # function of the path, so Newton's method converges.
    return np.sin(impact_angle) * _root(excess, np.sqrt(2.0 * volume / (face.short_axis * slope)))


def depth_from_force(
    cutting_force: ArrayLike,
    specific_energy: ArrayLike,
    impact_angle: ArrayLike = IMPACT_ANGLE,
    face: TipFace = PRINTED_FACE,
) -> Number:
    """Return the crater depth, m, at which the chip resists with a force: u b(depth)
    depth/cos(gamma) = F_c.

    ``cutting_force`` is the force along the path, N; the other arguments are those of
    ``depth_from_energy``.

    A face of full width b = 0.71 mm in steel of u = 1 GPa: at gamma = 60 deg, whose cosine is 1/2,
    1420 N cut 1 mm, deeper than the face's half, from where on the width is constant.

    >>> print(f"{1e3 * depth_from_force(1420.0, 1e9, math.radians(60.0)):.6f}")
    1.000000
    """
    area = np.asarray(cutting_force, dtype=float) * np.cos(impact_angle) / specific_energy
    # Beyond the full depth the width is constant, and b(depth) depth = area is linear.
    wide = area / face.short_axis
    fraction = np.minimum(wide / face.full_depth, 1.0)

    def excess(root: Number) -> tuple[Number, Number]:
        """Return the scaled area of a depth less the given area, and its slope."""
        # b depth = d D y^3 sqrt(2 - y^2) with y^2 = depth/D, D the full depth; it rises up to y = 1.22.
        rest = np.sqrt(2.0 - root**2)
        return root**3 * rest - fraction, 3.0 * root**2 * rest - root**4 / rest

    narrow = face.full_depth * _root(excess, np.cbrt(fraction / math.sqrt(2.0))) ** 2
    return np.where(wide >= face.full_depth, wide, narrow)[()]


def _root(excess: Callable[[Number], tuple[Number, Number]], start: Number) -> Number:
    """Return the root of a rising function by Newton's method.

    ``excess`` returns the function and its slope. The start must be just below the root, or the
    root itself where that is 0.
    """
    root = np.asarray(start, dtype=float)
    step = np.array(math.inf)
    tries = 0
    while tries < NEWTON_STEPS and np.any(np.abs(step) > 1e-14 * np.abs(root)):
        value, slope = excess(root)
        step = np.divide(
            value,
            slope,
            out=np.zeros(np.broadcast(value, slope).shape),
            where=np.asarray(slope) > 0.0,
        )
        root = root - step
        tries = tries + 1
    return root[()]


def crater_depth_from_contact(
    time: ArrayLike,
    normal_force: ArrayLike,
    tangential_force: ArrayLike,
    penetration: ArrayLike,
    normal_velocity: ArrayLike,
    tangential_velocity: ArrayLike,
    *,
    impact_angle: float = IMPACT_ANGLE,
    shear_yield_stress: float = API_5L,
    friction: float | None = None,
    surface: Surface = "parallel",
    wire_diameter: float = PRINTED_FACE.short_axis,
) -> ContactCrater:
    """Return the craters that follow from a contact resolved in time, up to its deepest
    penetration.

    Args:
        time: times, s, shape (n,) with n >= 2, as all columns below.
        normal_force: normal force on the tip, N.
        tangential_force: tangential force on the tip, N.
        penetration: penetration, m, positive inside the workpart.
        normal_velocity: normal velocity of the tip, m/s.
        tangential_velocity: tangential velocity of the tip, m/s.
        impact_angle: gamma, rad.
        shear_yield_stress: tau_s, Pa.
        friction: mu while cutting; by default the contact's own at its largest force.
        surface: lie of the surface where the shear plane ends, ``parallel`` or ``inclined``.
        wire_diameter: width of the tip's face, m.

    Raises:
        ValueError: if no force presses on the tip at the peak.
    """
    columns = (
        time,
        normal_force,
        tangential_force,
        penetration,
        normal_velocity,
        tangential_velocity,
    )
    deepest = max(int(np.argmax(penetration)), 1)
    t, normal, tangential, inside, v_n, v_t = (
        np.asarray(column)[: deepest + 1] for column in columns
    )
    along = math.sin(impact_angle) * normal + math.cos(impact_angle) * np.abs(tangential)
    peak = int(np.argmax(along))
    require("normal_force", normal[peak], normal[peak] > 0.0, "must press at its peak (in N)")
    cutting = float(abs(tangential[peak]) / normal[peak]) if friction is None else friction
    u = specific_cutting_energy(cutting, impact_angle, shear_yield_stress, surface)
    face = TipFace(short_axis=wire_diameter)
    work = sum(
        float(np.trapezoid(force * speed, t)) for force, speed in ((normal, v_n), (tangential, v_t))
    )
    return ContactCrater(
        compression_time=float(t[-1] - t[0]),
        peak_cutting_force=float(along[peak]),
        path=float(np.trapezoid(np.hypot(v_n, v_t), t)),
        penetration=float(inside[-1]),
        depth_from_force=float(depth_from_force(along[peak], u, impact_angle, face)),
        depth_from_energy=float(depth_from_energy(max(-work, 0.0), u, impact_angle, face)),
        shear_plane_emerges=surface == "inclined" or cutting >= math.tan(impact_angle),
    )
