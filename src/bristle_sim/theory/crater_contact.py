"""Crater depth that follows from a contact resolved in time: from its force and from the energy it takes.

Compression ends where the tip is deepest. Up to there the force along the path, N sin(gamma) + |T| cos(gamma), is
Merchant's cutting force, and the work of both forces on the tip is what the workpart takes. The two depths (see
crater_cutting) agree only if the contact is as stiff as the chip is: the energy does not depend on how long the contact
lasts, but a force is inversely proportional to it, so the depth from the force is as good as the contact's duration is.

The impact of a bristle on a hub that keeps its speed gives the same energy whatever gamma and mu, half of m/3 times the
square of the tip's speed (Zhang 2020, eqs. 2.40, 2.58 added), and the impulse m/3 times that speed along the path.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bristle_sim.quantity import Range
from bristle_sim.theory.checks import finite, ranges, require, single
from bristle_sim.theory.crater_cutting import Surface, depth_from_energy, depth_from_force, specific_cutting_energy
from bristle_sim.theory.crater_kinematics import IMPACT_ANGLE, TipFace
from bristle_sim.theory.merchant import API_5L

__all__ = ["ContactCrater", "crater_depth_from_contact"]

Array = NDArray[np.float64]

COLUMNS = ("time", "normal_force", "tangential_force", "penetration", "normal_velocity", "tangential_velocity")


@dataclass(frozen=True, slots=True)
class ContactCrater:
    """What a contact's compression did and the craters that follow.

    Attributes:
        compression_time: from first touch to deepest penetration, s.
        peak_cutting_force: largest force along the path, N.
        friction: tangential over normal force at that instant.
        path_impulse: integral of the force along the path, N s.
        normal_work, tangential_work: of the force on the tip in compression, J; negative.
        path: length of the tip's path in compression, m.
        penetration: deepest, of the contact itself, m.
        depth_from_force, depth_from_energy: of the crater, m.
        shear_plane_emerges: whether eta >= gamma with the friction used; where not, ``parallel`` depths are formal.
    """

    compression_time: float
    peak_cutting_force: float
    friction: float
    path_impulse: float
    normal_work: float
    tangential_work: float
    path: float
    penetration: float
    depth_from_force: float
    depth_from_energy: float
    shear_plane_emerges: bool


COLUMN = ranges(*(Range(name, "SI units", -1e30, 1e30, True, "simulated") for name in COLUMNS))
SCALARS = ranges(
    Range("impact_angle", "rad", 1e-30, 1.57, True, "Zhang 2020, eq. 4.51"),
    Range("shear_yield_stress", "Pa", 1e-30, 1e30, True, "Zhang 2020, eq. 4.53"),
    Range("friction", "1", 0.0, 1e300, False, "Zhang 2020, eq. 4.51"),
)


@COLUMN
@SCALARS
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
    face: TipFace | None = None,
    surface: Surface = "parallel",
) -> ContactCrater:
    """Craters that follow from a contact resolved in time, up to its deepest penetration.

    Args:
        time: s, increasing, shape (n,); n >= 2.
        normal_force, tangential_force: on the tip, shape (n,), N.
        penetration: of the tip, positive inside the workpart, shape (n,), m.
        normal_velocity, tangential_velocity: of the tip, shape (n,), m/s.
        impact_angle: gamma, rad.
        shear_yield_stress: tau_s, Pa.
        friction: mu while cutting; by default the contact's own at its peak. Chapter 4 of the dissertation cuts with 0.5
            where chapter 2 strikes with 0.31.
        face: of the tip.
        surface: where the shear plane ends, ``parallel`` or ``inclined``.

    Raises:
        ValueError: for arrays of unequal length, values that are not finite, times that do not increase, or a contact
            without a pressing force.
    """
    for name, value in (("impact_angle", impact_angle), ("shear_yield_stress", shear_yield_stress)):
        single(name, value)
    if friction is not None:
        single("friction", friction)
    given = (time, normal_force, tangential_force, penetration, normal_velocity, tangential_velocity)
    t, normal, tangential, inside, v_n, v_t = _compression(given)
    along = math.sin(impact_angle) * normal + math.cos(impact_angle) * np.abs(tangential)
    peak = int(np.argmax(along))
    require("normal_force", normal[peak], normal[peak] > 0.0, "a contact that presses at its peak is allowed (in N)")
    ratio = float(abs(tangential[peak]) / normal[peak])
    cutting = ratio if friction is None else friction
    u = specific_cutting_energy(cutting, impact_angle, shear_yield_stress, surface)
    works = [_integral(force * speed, t) for force, speed in ((normal, v_n), (tangential, v_t))]
    return ContactCrater(
        compression_time=float(t[-1] - t[0]),
        peak_cutting_force=float(along[peak]),
        friction=ratio,
        path_impulse=_integral(along, t),
        normal_work=works[0],
        tangential_work=works[1],
        path=_integral(np.hypot(v_n, v_t), t),
        penetration=float(inside[-1]),
        depth_from_force=float(depth_from_force(along[peak], u, impact_angle, face)),
        depth_from_energy=float(depth_from_energy(max(-sum(works), 0.0), u, impact_angle, face)),
        shear_plane_emerges=surface == "inclined" or cutting >= math.tan(impact_angle),
    )


def _compression(values: tuple[ArrayLike, ...]) -> list[Array]:
    """The columns, checked, up to the deepest penetration."""
    columns = [np.asarray(value, dtype=float) for value in values]
    shape = columns[0].shape
    if len(shape) != 1 or shape[0] < 2 or any(column.shape != shape for column in columns):
        shapes = ", ".join(f"{name} {column.shape}" for name, column in zip(COLUMNS, columns, strict=True))
        raise ValueError(f"{shapes}: rows of equal lengths, two samples or more, are allowed")
    for name, column in zip(COLUMNS, columns, strict=True):
        finite(name, column, "SI units")
    require("time", columns[0][1:], np.diff(columns[0]) >= 0.0, "times that do not decrease are allowed (in s)")
    deepest = max(int(np.argmax(columns[3])), 1)
    return [column[: deepest + 1] for column in columns]


def _integral(values: Array, time: Array) -> float:
    """Trapezoidal rule over the samples."""
    return float(0.5 * np.sum((values[1:] + values[:-1]) * np.diff(time)))
