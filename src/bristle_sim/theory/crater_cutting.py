"""Crater depth from the cutting force or from the energy, also for a simulated contact.

A tip that cuts a chip of depth d_u and width b is loaded by the force F_c = u b d_u along its path
(Merchant, 4.31; symbols of the module ``merchant``). The specific cutting energy u = tau_s cos(beta
- alpha)/(sin(eta) cos(eta + beta - alpha)) depends on the angles only. The path is straight and
descends at the impact angle gamma. After the length S of the path, the tip is S sin(gamma) below
the surface. Measured along the normal to the path, the surface is at the distance
d_u = S tan(gamma) from the tip, so that depth = d_u cos(gamma) as in (4.50). With the width b of
the face at a depth,

    F_c(S) = u b(S sin(gamma)) S tan(gamma),    W(S) = integral of F_c dS = u V(S),

where V is the swept volume.

``depth_from_force`` solves the equation of F_c for the depth, ``depth_from_energy`` the equation of
W. The sum over time steps of (4.50) differs from the equation of F_c: the sum adds up dF_c/b with
the width at each time, although in (4.31) the whole force belongs to the last width.

A contact simulated over its duration gives both force and energy. Up to the deepest penetration the
force along the path, N sin(gamma) + |T| cos(gamma), is F_c, and the work of both forces on the tip
is W. The two depths agree only if the contact is as stiff as the chip. The energy does not depend
on the duration of the contact, but the force is inversely proportional to the duration.

Assumed: straight path, rigid perfectly plastic work material, weightless chip, no spring-back,
compression only, and a face longer than the cut is deep. The angle is within 0 < gamma < pi/2, in
rad.
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

NODES, WEIGHTS = np.array(np.polynomial.legendre.leggauss(20))[:, 10:]
"""Positive nodes of a Gauss-Legendre rule on (-1, 1) and their weights, for the volume swept up to
the depth at which the cut is as wide as the wire.

The integrand is an even function of the substituted path u and smooth for |u| < 1.4, so that half
of the rule suffices, with an error of 1e-15."""

NEWTON_STEPS = 60  # largest number of Newton steps; about ten suffice from these start values


@dataclass(frozen=True, slots=True)
class ContactCrater:
    """The compression of a contact, up to the deepest penetration, and the crater that is cut.

    Attributes:
        compression_time: time from first touch to deepest penetration, s.
        peak_cutting_force: largest force along the tip's path, N.
        path: length of the tip's path during compression, m.
        penetration: deepest penetration, m.
        depth_from_force: crater depth that follows from the largest force, m.
        depth_from_energy: crater depth that follows from the work, m.
        shear_plane_emerges: whether the shear plane of the chip emerges from the surface. If not,
            Merchant's circle for a surface parallel to the path does not apply, and the two depths
            have no physical meaning.
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
    """Return the volume that the tip's face sweeps below the surface, m^3.

    On a path of length S (m) that descends at the impact angle gamma (rad) the volume is

        V(S) = integral from 0 to S of b(s sin(gamma)) s tan(gamma) ds.

    b is the width of the cut at a depth. The width is constant at depths at which the cut is as
    wide as the wire. At smaller depths the substitution s = S u^2 makes the integrand smooth.
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
    """Return the crater depth at which cutting the crater takes a given energy, m.

    The depth is S sin(gamma), where the length S of the path satisfies u V(S) = W. V is the volume
    of ``swept_volume``.

    Args:
        energy: work W that the tip does on the workpart along its path, J.
        specific_energy: specific cutting energy u of the chip, J/m^3.
        impact_angle: angle gamma of the path to the surface, rad.
        face: cutting face of the tip.

    The energy that cuts the volume of a given path gives the depth of that path:

    >>> path, angle = 1e-4, math.radians(30.0)
    >>> print(f"{depth_from_energy(1e9 * swept_volume(path, angle), 1e9, angle) / path:.6f}")  # sin(30 deg)
    0.500000
    """
    volume = np.divide(energy, specific_energy)
    slope = np.tan(impact_angle)

    def excess(path: Number) -> tuple[Number, Number]:
        """Return the volume that a path sweeps minus that required (m^3), and its derivative."""
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
    """Return the crater depth at which the chip resists with a given force, m.

    The depth z solves u b(z) z/cos(gamma) = F_c, with the width b of the cut. ``cutting_force`` is
    the force F_c along the path, N. The specific cutting energy u, the impact angle gamma and the
    face are those of ``depth_from_energy``.

    In steel of u = 1 GPa, at gamma = 60 deg, 1420 N cut 1 mm deep. The cut is then as wide as the
    wire, b = 0.71 mm, and cos(gamma) = 1/2:

    >>> print(f"{1e3 * depth_from_force(1420.0, 1e9, math.radians(60.0)):.6f}")
    1.000000
    """
    area = np.asarray(cutting_force, dtype=float) * np.cos(impact_angle) / specific_energy
    # Beyond the full depth the width is constant, and b(depth) depth = area is linear.
    wide = area / face.short_axis
    fraction = np.minimum(wide / face.full_depth, 1.0)

    def excess(root: Number) -> tuple[Number, Number]:
        """Return the dimensionless area of the cut minus the required one, and its derivative.

        The argument ``root`` is sqrt(depth/``face.full_depth``).
        """
        # b depth = d D y^3 sqrt(2 - y^2) with y^2 = depth/D, D the full depth; it rises up to y =
        # 1.22.
        rest = np.sqrt(2.0 - root**2)
        return root**3 * rest - fraction, 3.0 * root**2 * rest - root**4 / rest

    narrow = face.full_depth * _root(excess, np.cbrt(fraction / math.sqrt(2.0))) ** 2
    return np.where(wide >= face.full_depth, wide, narrow)[()]


def _root(excess: Callable[[Number], tuple[Number, Number]], start: Number) -> Number:
    """Return the root of an increasing function by Newton's method.

    ``excess`` returns the values of the function and of its derivative at a place. ``start`` is the
    place from which the search starts, near the root and below it. For a root of 0, ``start`` is 0.
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
    """Return the crater that a contact cuts up to its deepest penetration, from its force history.

    The depth is computed in two ways, from the largest force and from the work.

    Args:
        time: times (s), shape (n,) with n >= 2. The next five arguments have the same shape.
        normal_force: normal force on the tip, N, positive away from the workpart.
        tangential_force: tangential force on the tip, N.
        penetration: penetration (m), positive inside the workpart.
        normal_velocity: normal velocity of the tip, m/s, positive away from the workpart.
        tangential_velocity: tangential velocity of the tip, m/s, along the axis of the force.
        impact_angle: angle of the tip's path to the surface, rad.
        shear_yield_stress: shear yield stress of the workpart, Pa.
        friction: coefficient of friction while cutting; by default the ratio of tangential to
            normal force at the time at which the force along the path is largest.
        surface: direction of the surface at which the shear plane ends, relative to the path:
            ``parallel`` or ``inclined``.
        wire_diameter: width of the tip's face, m.

    Raises:
        ValueError: if the normal force is not positive where the force along the path is largest.
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
