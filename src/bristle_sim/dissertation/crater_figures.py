"""Figures 4.2-4.19: motion during compression, width of the cut and crater depth (Zhang 2020,
chapter 4).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from bristle_sim.arrays import Array
from bristle_sim.dissertation.force_figures import FORCE, MICROSECONDS, bristle_contact
from bristle_sim.dissertation.redrawn import Axis, Level, Mark, Panel, Redrawn, curve_of
from bristle_sim.parameters import Bristle, Crater
from bristle_sim.studies.crater_study import MEASURED
from bristle_sim.theory.crater import (
    energy_crater_depth,
    energy_crater_depth_ratio,
    friction_for_crater_depth,
    merchant_crater_depth,
)
from bristle_sim.theory.crater_kinematics import (
    COMPRESSION_TIME,
    IMPACT_ANGLE,
    PRINTED_KINEMATICS,
    PRINTED_WIDTH,
)
from bristle_sim.theory.force_history import BRISTLE
from bristle_sim.theory.merchant import PRINTED_ANGLES

DEPTH = Axis("crater depth", "µm", 1e6)
PATH = Axis("tip's path", "µm", 1e6)
PLIES = Axis("number of plies $n$", log=True)
AXES = {
    "friction": Axis("friction coefficient while cutting $\\mu$"),
    "impact_angle": Axis("impact angle $\\gamma$", "°", math.degrees(1.0)),
    "shear_yield_stress": Axis("shear yield stress", "MPa", 1e-6),
}

WHOLE_PLIES = np.unique(np.geomspace(1, 1e5, 81).astype(int))
FEW_PLIES = np.array([1, 3, 10, 30, 100, 300, 1000, 10000, 100000])
MEASURED_LEVEL = Level(MEASURED, "measured")
OWN = Crater()
OPERATING_POINT = {
    "friction": OWN.friction,
    "impact_angle": IMPACT_ANGLE,
    "shear_yield_stress": OWN.shear_yield_stress,
}

ANGLES = ("impact_angle", tuple(np.radians([10.0, 15.0, 20.0, 23.4]).tolist()))
FAMILIES: dict[str, tuple[str, str, tuple[float, float], tuple[str, tuple[float, ...]]]] = {
    "4.14": ("friction", "friction", (0.45, 4.0), ANGLES),
    "4.15": (
        "the impact angle",
        "impact_angle",
        (math.radians(0.5), math.radians(23.4)),
        ("friction", (0.5, 1.0, 2.0, 4.0)),
    ),
    "4.17": ("the shear yield stress", "shear_yield_stress", (0.8e8, 2.4e8), ANGLES),
}
"""Families of curves of the crater depth, by the number of their figure.

For the quantity that varies along a curve, an entry holds its name in words, its key, and its range
in SI units. For the quantity that varies from curve to curve it holds the key and the values."""


def map_figure() -> Redrawn:
    """Return figure 4.2: force and motion during compression.

    The curves are the printed formulas; the points are a simulated contact. The contact begins with
    the speed at which the dissertation's bristle strikes.
    """
    k = PRINTED_KINEMATICS
    contact = bristle_contact(impulse=False)
    h = contact.history
    speed = np.hypot(h.normal_velocity, h.tangential_velocity)
    panels = (
        _over_time(FORCE, "$F$ (3.19)", BRISTLE, contact.force),
        _over_time(PATH, "$S$ (4.4a)", k.tip_displacement, contact.path),
        _over_time(Axis("tip's speed", "m/s"), "$v_C$ (4.4b)", k.tip_velocity, speed),
        _over_time(
            Axis("bristle's rate", "rad/s"), "$\\dot\\varphi$ (4.6)", k.bristle_rate, contact.rate
        ),
        _over_time(
            Axis("centre's speed", "m/s"), "$v_G$ (4.7)", k.centre_velocity, contact.centre_speed
        ),
        _over_time(
            Axis("depth of the tip", "µm", 1e6), "$\\delta$ (4.8)", k.crater_depth, h.penetration
        ),
    )
    note = "a contact that stops a tip of 30 m/s in 50 µs needs a path of about 0.9 mm, three times that of (4.4a)"
    return Redrawn("4.2", "force and motion during compression", panels, note)


def displacement_figure() -> Redrawn:
    """Return figure 4.3: the path length of the tip during compression."""
    motion = PRINTED_KINEMATICS.tip_displacement
    panel = _over_time(PATH, "$S$ (4.4a)", motion, bristle_contact(impulse=False).path)
    end = float(motion(COMPRESSION_TIME))
    level = Level(3.25e-4, "measured, 325 µm")
    mark = Mark(COMPRESSION_TIME, end, f"{1e6 * end:.1f} µm", "left")
    panel = dataclasses.replace(panel, levels=(level,), marks=(mark,))
    return Redrawn("4.3", "penetration displacement", (panel,), "printed end: 320 µm")


def width_figure() -> Redrawn:
    """Return figure 4.6: the width of the cut during compression."""
    at = COMPRESSION_TIME * np.linspace(0.0, 1.0, 11)[1:]
    printed = 2.0 * np.sqrt(3.55e-4**2 - (1.39e-4 + 2.16e-4 * np.exp(-92400.0 * at)) ** 2)
    grid = COMPRESSION_TIME * np.linspace(0.0, 1.0, 161) ** 2
    curve = curve_of("$b$ (4.16)", PRINTED_WIDTH, grid, {"printed": (at, printed)})
    end = float(PRINTED_WIDTH(COMPRESSION_TIME))
    mark = Mark(COMPRESSION_TIME, end, f"{1e6 * end:.1f} µm", "left")
    level = Level(6.51e-4, "measured, 651 µm")
    panel = Panel(
        MICROSECONDS, Axis("cutting width", "µm", 1e6), (curve,), marks=(mark,), levels=(level,)
    )
    return Redrawn("4.6", "cutting width", (panel,), "printed end: 652 µm")


def plies_figure() -> Redrawn:
    """Return figure 4.13: crater depth over the number of plies.

    A ply is the layer of the chip that is cut in one of the equal time steps of compression. One
    curve has the exact angles of Merchant's circle, the other has the rounded angles in print.
    """
    rounded = partial(_depth, "plies", {"angles": PRINTED_ANGLES})
    printed = [_printed_sum(plies=int(n)) for n in FEW_PLIES]
    points = {"printed": (FEW_PLIES, printed)}
    curves = (
        curve_of("exact angles", partial(_depth, "plies", {}), WHOLE_PLIES, points),
        curve_of("rounded angles (4.52)", rounded, WHOLE_PLIES),
    )
    limit = float(merchant_crater_depth(plies=math.inf))
    depth = float(rounded(300))
    levels = (MEASURED_LEVEL, Level(limit, f"limit {1e6 * limit:.2f} µm"))
    mark = Mark(300.0, depth, f"{1e6 * depth:.2f} µm, printed 140")
    panel = Panel(PLIES, DEPTH, curves, marks=(mark,), levels=levels)
    note = "300 plies are called converged; the error falls like 1/√n, so that a tenth of it takes 30000 plies"
    return Redrawn("4.13", "crater depth over the number of plies", (panel,), note)


def depth_figure(number: str) -> Redrawn:
    """Return figure 4.14, 4.15 or 4.17: crater depth over friction, impact angle or yield stress.

    The stress is the shear yield stress. The points are values of the sum over plies as the
    dissertation prints it in equation (4.57).
    """
    words, along, ends, (family, values) = FAMILIES[number]
    at = np.linspace(*ends, 8)
    curves = []
    for value in values:
        printed = [_printed_sum(**{family: value, along: x}) for x in at.tolist()]
        formula = partial(_depth, along, {family: value})
        points = {"printed": (at, printed)}
        curves.append(curve_of(AXES[family].shown(value), formula, np.linspace(*ends, 101), points))
    mark = Mark(OPERATING_POINT[along], float(merchant_crater_depth()))
    symbol = "$\\mu$" if family == "friction" else "$\\gamma$"
    panel = Panel(AXES[along], DEPTH, tuple(curves), symbol, (mark,), (MEASURED_LEVEL,))
    return Redrawn(number, f"crater depth over {words}", (panel,))


def constant_depth_figure() -> Redrawn:
    """Return figure 4.16: the friction that gives a constant crater depth, over the impact
    angle.
    """
    grid = np.radians(np.linspace(5.0, 23.4, 101))
    curves = []
    for depth in (1.2e-4, 1.4e-4, 1.6e-4, 2.0e-4):
        formula = np.vectorize(partial(_friction, depth))
        angles = grid[np.isfinite(formula(grid))]
        at = angles[:: max(len(angles) // 8, 1)]
        printed = [_friction_of_printed_sum(depth, angle) for angle in at.tolist()]
        curves.append(curve_of(DEPTH.shown(depth), formula, angles, {"printed": (at, printed)}))
    mark = Mark(OPERATING_POINT["impact_angle"], OPERATING_POINT["friction"])
    panel = Panel(AXES["impact_angle"], AXES["friction"], tuple(curves), "depth", (mark,))
    return Redrawn("4.16", "friction over the impact angle at constant crater depth", (panel,))


def energy_figure() -> Redrawn:
    """Return figure 4.19: crater depth from work and energy, over the number of plies.

    The printed equation can be read as a sum of quotients or as a quotient of two sums. Each
    reading gives one curve.
    """
    curves = (
        curve_of(
            "sum of quotients (4.62)",
            np.vectorize(energy_crater_depth),
            WHOLE_PLIES,
            {"motion": (FEW_PLIES, [*map(_energy_sum, FEW_PLIES.tolist())])},
        ),
        curve_of("ratio of two sums (4.66)", np.vectorize(energy_crater_depth_ratio), WHOLE_PLIES),
    )
    mark = Mark(5.0, float(energy_crater_depth_ratio(5)), "5 plies", "left")
    levels = (MEASURED_LEVEL, Level(7.58e-5, "printed, 75.8 µm"))
    panel = Panel(PLIES, dataclasses.replace(DEPTH, log=True), curves, marks=(mark,), levels=levels)
    note = "the sum grows like ln $n$ until the rounding of $F$(0), 0.02 N, stops it at 14 mm; the ratio falls like 1/$n$"
    return Redrawn(
        "4.19", "crater depth by work and energy over the number of plies", (panel,), note
    )


FIGURES: dict[str, Callable[[], Redrawn]] = {
    "4.2": map_figure,
    "4.3": displacement_figure,
    "4.6": width_figure,
    "4.13": plies_figure,
    "4.14": partial(depth_figure, "4.14"),
    "4.15": partial(depth_figure, "4.15"),
    "4.16": constant_depth_figure,
    "4.17": partial(depth_figure, "4.17"),
    "4.19": energy_figure,
}


def _over_time(
    axis: Axis, name: str, formula: Callable[[Array], ArrayLike], values: Array
) -> Panel:
    """Return a panel of a quantity over time during compression.

    Args:
        axis: vertical axis.
        name: label of the curve.
        formula: the printed formula, a function of time (s).
        values: samples of the simulated contact, shown as points.
    """
    time, first = np.unique(bristle_contact(impulse=False).time, return_index=True)
    kept = time <= COMPRESSION_TIME
    grid = np.linspace(0.0, COMPRESSION_TIME, 101)
    return Panel(
        MICROSECONDS,
        axis,
        (curve_of(name, formula, grid, {"contact": (time[kept], values[first][kept])}),),
    )


def _depth(along: str, given: dict[str, Any], x: Any) -> Any:
    """Return the crater depth (m) that Merchant's theory gives.

    Args:
        along: name of the argument that varies.
        given: values of other arguments, by name.
        x: values of the argument that varies.
    """
    return merchant_crater_depth(**given, **{along: x})


def _printed_sum(*, impact_angle: float = IMPACT_ANGLE, **changes: Any) -> float:
    """Return the crater depth (m) that the printed sum (4.57) gives.

    ``impact_angle`` is in rad; ``changes`` are other crater parameters that differ from their
    defaults.
    """
    crater = dataclasses.replace(OWN, impact_angle_deg=math.degrees(impact_angle), **changes)
    return merchant_sum(crater)


def merchant_sum(crater: Crater) -> float:
    """Return the crater depth (m) that Merchant's relation gives as printed (4.57).

    The sum is over plies, the layers of the chip that are cut in equal time steps. The shear angle
    is that of least work.
    """
    time = np.linspace(0.0, crater.compression_time, int(crater.plies) + 1)
    gamma = math.radians(crater.impact_angle_deg)
    ratio = 0.5 * (1.0 - math.sin(math.atan2(1.0, crater.friction) - gamma)) * math.cos(gamma)
    growth = float(np.sum(np.diff(BRISTLE(time)) / PRINTED_WIDTH(time[1:])))
    return ratio * growth / crater.shear_yield_stress


def _energy_sum(plies: int) -> float:
    """Return the crater depth (m) from work and energy (4.58, 4.62-4.65), as a sum over plies.

    The kinetic energy is that of the printed motion (4.6, 4.7).
    """
    time = np.linspace(0.0, COMPRESSION_TIME, plies + 1)
    wire = Bristle()
    speed = PRINTED_KINEMATICS.centre_velocity(time)
    rate = PRINTED_KINEMATICS.bristle_rate(time)
    energy = 0.5 * wire.mass * speed**2 + 0.5 * wire.inertia_about_centre * rate**2
    return math.cos(IMPACT_ANGLE) * float(np.sum(-np.diff(energy) / BRISTLE(time[1:])))


def _friction(depth: float, impact_angle: float) -> float:
    """Return the friction coefficient for a crater depth (m) and an impact angle (rad), or NaN.

    The coefficient is at least the tangent of the impact angle. The result is NaN if no coefficient
    gives this depth.
    """
    try:
        return float(friction_for_crater_depth(depth, impact_angle))
    except ValueError:
        return math.nan


def _friction_of_printed_sum(depth: float, impact_angle: float) -> float:
    """Return the friction coefficient at which the printed sum (4.57) gives a crater depth (m).

    The impact angle is in rad. The sum grows with friction, so there is only one such coefficient.
    """

    def excess(logarithm: float) -> float:
        """Return d/``depth`` - 1, with the depth d at the friction coefficient exp(logarithm)."""
        friction = math.exp(logarithm)
        return _printed_sum(friction=friction, impact_angle=impact_angle) / depth - 1.0

    return math.exp(brentq(excess, math.log(math.tan(impact_angle)), math.log(1e6), xtol=1e-15))
