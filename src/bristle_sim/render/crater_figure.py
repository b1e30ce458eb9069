"""Draw the crater on one page: depth over plies, the chip to scale, every estimate, and C over friction."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.arrays import Array
from bristle_sim.render.colours import BLACK, BLUE, GREEN, GREY, ORANGE, SERIES, VERMILION
from bristle_sim.render.style import add_panel, blank_figure, note, signed, styled
from bristle_sim.studies.crater_study import (
    IMPACT_ANGLES_DEG,
    MEASURED,
    CraterStudy,
    constants_over,
    cut_of,
    merchant_depth_course,
)
from bristle_sim.theory.crater import (
    energy_crater_depth_ratio,
    friction_for_crater_depth,
    merchant_crater_depth,
    merchant_crater_depth_limit,
)
from bristle_sim.theory.crater_kinematics import PRINTED_KINEMATICS

MICRO = 1e6

LEAN = math.radians(11.5)  # lean of the rake face back from the workpart's normal, rad (Zhang 2020, eq. 4.36)
LEAST_FRICTION, MOST_FRICTION = 0.4, 4.0  # friction coefficients shown (Zhang 2020, fig. 4.14 goes from 0.45 to 4)
OWN: dict[str, Any] = {"marker": "*", "color": ORANGE, "markersize": 9, "markeredgecolor": BLACK, "linestyle": "none"}
"""Look of the study's own values."""


@styled()
def crater_figure(study: CraterStudy) -> Figure:
    """Draw every estimate of the depth (um) beside the measured one, and below how they come about."""
    figure, emerges = blank_figure(16.0, 20.6), study.angles is not None
    rows = _estimates(study)
    figure.text(1.5 / 16.0, 1.0 - 0.75 / 20.6, _finding(rows), fontsize=9.0)
    _draw_estimates(
        add_panel(
            figure,
            (4.6, 14.2, 10.6, 4.6),
            "crater depth by every estimate",
            "shaded: within 10 % of the measured depth",
        ),
        rows,
    )
    _draw_chip(add_panel(figure, (1.5, 7.7, 7.3 if emerges else 14.0, 4.4), "chip and shear plane, to scale"), study)
    if emerges:
        _draw_plies(add_panel(figure, (10.4, 7.7, 5.2, 4.4), "Merchant's depth over the plies"), study)
    _draw_constants(
        add_panel(figure, (1.5, 1.1, 14.0, 4.2), "Merchant's constant C that gives the measured depth"), study
    )
    return figure


def _draw_plies(axes: Axes, study: CraterStudy) -> None:
    crater = study.crater
    axes.axhline(MICRO * MEASURED, color=GREY, dashes=(4, 2), label="measured")
    axes.set(xscale="log", xlabel="number of plies", ylabel="crater depth (µm)")
    curve, points = np.unique(np.geomspace(1, 1e5, 61).astype(int)), (1, 3, 10, 30, 100, 300, 1000, 10000, 100000)
    sums = [float(merchant_depth_course(dataclasses.replace(crater, plies=n))[-1]) for n in points]
    cut = cut_of(crater)
    limit, own = float(merchant_crater_depth_limit(**cut)), float(merchant_crater_depth(plies=crater.plies, **cut))
    axes.plot(curve, MICRO * np.asarray(merchant_crater_depth(plies=curve, **cut)), color=BLUE, label="sum (4.50)")
    printed: dict[str, Any] = {"markersize": 3.6, "markerfacecolor": "white", "label": "(4.57) as printed"}
    axes.plot(points, MICRO * np.array(sums), "o", color=BLUE, **printed)
    axes.axhline(MICRO * limit, color=BLUE, dashes=(1, 1.5), linewidth=0.9, label=f"limit {MICRO * limit:.2f} µm")
    axes.plot([crater.plies], [MICRO * own], label=f"{MICRO * own:.2f} µm with {crater.plies:g}", zorder=4, **OWN)
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.05), labelspacing=0.3)


def _draw_chip(axes: Axes, study: CraterStudy) -> None:
    gamma, upright = study.impact_angle, math.pi / 2.0 + LEAN
    path = MICRO * float(PRINTED_KINEMATICS.tip_displacement(study.crater.compression_time))
    tip, depth = path * _direction(-gamma), path * math.sin(gamma)
    width = max(3.3 * path * math.cos(gamma), 7.0 * depth, 1.0)
    sides, height = (-0.12 * width, 0.88 * width), width * axes.bbox.height / axes.bbox.width
    bottom = -max(1.7 * depth, 0.25 * height)
    cut = np.array([(0.0, 0.0), tip, tip + depth / math.cos(LEAN) * _direction(upright)])
    axes.fill_between(sides, 0.0, bottom, color="#e3e6ea", linewidth=0.0, zorder=0)
    axes.fill(*cut.T, color="white", zorder=1)
    axes.plot(sides, (0.0, 0.0), color=GREY, linewidth=0.8)
    axes.plot(*cut[:2].T, color=BLACK, label="path")
    _draw_tip(axes, tip, 3.2 * depth * _direction(upright), gamma)
    rising = math.pi / 4.0 - 0.5 * math.atan2(1.0, study.crater.friction)
    planes = [("shear plane to the surface", GREEN, rising, depth / math.sin(rising))]
    if study.angles is not None:  # as long as (4.28) has it
        eta = float(study.angles.shear)
        planes.insert(0, ("shear plane of (4.28)", VERMILION, eta - gamma, depth / math.cos(gamma) / math.sin(eta)))
    for label, color, slope, length in planes:
        axes.plot(*np.transpose([tip, tip + length * _direction(slope)]), color=color, label=label)
    limits: dict[str, Any] = {"xlim": sides, "ylim": (bottom, bottom + height), "aspect": "equal"}
    axes.set(**limits, xlabel="along the workpart (µm)", ylabel="height (µm)")
    axes.legend(loc="upper right", labelspacing=0.3)


def _draw_tip(axes: Axes, tip: Array, face: Array, gamma: float) -> None:
    """Draw the tip behind its rake face; the heel clears the path."""
    size = math.hypot(*face)
    heel = 0.8 * size * _direction(math.pi - gamma - math.radians(12.0))
    back = np.array([heel[0] + 0.1 * size, face[1]])
    axes.fill(*np.transpose([tip, tip + face, tip + back, tip + heel]), color=GREY, alpha=0.55, linewidth=0.0, zorder=2)
    x, y = tip + 0.6 * face
    axes.text(x - 0.08 * size, y, "tip", fontsize=7.0, ha="right", color="white", zorder=3)


def _direction(angle: float) -> Array:
    return np.array([math.cos(angle), math.sin(angle)])


def _estimates(study: CraterStudy) -> list[tuple[str, float, str]]:
    """Return name, depth (um) and colour of every estimate; the work-energy sum, millimetres, is left out."""
    crater, inclined = study.crater, study.inclined
    force = study.parallel if study.parallel is not None and study.parallel.shear_plane_emerges else None
    ratio = float(energy_crater_depth_ratio(5, study.impact_angle, compression_time=crater.compression_time))
    rows = []
    if study.angles is not None:
        cut = cut_of(crater)
        rows = [
            (f"Merchant, {crater.plies:g} plies", float(merchant_crater_depth(plies=crater.plies, **cut)), BLUE),
            ("Merchant, limit", float(merchant_crater_depth_limit(**cut)), BLUE),
        ]
    rows.append(("work and energy, 5 plies", ratio, GREEN))
    if force is not None:
        rows += [
            ("simulated force", force.depth_from_force, VERMILION),
            ("simulated energy", force.depth_from_energy, VERMILION),
        ]
    if inclined:
        rows.append(("simulated energy,\nshear to the surface", inclined.depth_from_energy, VERMILION))
    return [(name, MICRO * depth, color) for name, depth, color in rows]


def _finding(rows: list[tuple[str, float, str]]) -> str:
    """Return which estimate is nearest to the measured depth, and by how much it misses it."""
    name, depth, _ = min(rows, key=lambda row: abs(row[1] - MICRO * MEASURED))
    off = 100.0 * (depth / (MICRO * MEASURED) - 1.0)
    words = "as measured" if abs(off) < 0.5 else f"{abs(off):.0f} % {'deeper' if off > 0.0 else 'shallower'}"
    return f"Nearest to the measured depth: {' '.join(name.split())}, {words}"


def _draw_estimates(axes: Axes, rows: list[tuple[str, float, str]]) -> None:
    measured = MICRO * MEASURED
    axes.axvspan(0.9 * measured, 1.1 * measured, color=GREY, alpha=0.18, linewidth=0.0)
    axes.axvline(measured, color=BLACK, linewidth=1.2)
    for row, (_, depth, color) in enumerate(rows):
        axes.barh(row, depth, color=color, alpha=0.55, height=0.6)
        off = 100.0 * (depth / measured - 1.0)
        words = f"{depth:.0f} µm, {'+' * (off >= 0.5)}{signed(off, 0)} %"
        note(axes, words, (max(depth, measured), row), (5.0, 0.0), va="center", color=BLACK)
    axes.set_yticks(range(len(rows)), [name for name, _, _ in rows])
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.set_xlim(0.0, 1.35 * max(measured, *(depth for _, depth, _ in rows)))
    axes.set_xlabel(f"crater depth (µm); line: measured, {measured:.0f} µm", labelpad=1.0)


def _draw_constants(axes: Axes, study: CraterStudy) -> None:
    """Draw a curve for each impact angle, solid where the shear plane comes out of the surface and dotted where it does not."""
    for angle, color in zip(IMPACT_ANGLES_DEG, SERIES, strict=False):
        frictions = _frictions(study, angle)
        rows = constants_over(study.crater, MEASURED, frictions, (angle,))
        found = np.array([each["constant_deg"] or np.nan for each in rows])
        chip = np.array([bool(each["shear_plane_emerges"]) for each in rows])
        axes.plot(frictions, found, color=color, linewidth=0.9, dashes=(1, 1.2))
        axes.plot(frictions, np.where(chip, found, np.nan), color=color, linewidth=1.8, label=f"{angle:g}°")
    own = constants_over(study.crater, MEASURED, (study.crater.friction,), (study.crater.impact_angle_deg,))[0]
    if own["constant_deg"] is not None:
        label = f"{own['constant_deg']:.1f}° with {own['friction']:g}"
        axes.plot([own["friction"]], [own["constant_deg"]], label=label, zorder=4, **OWN)
    axes.axhline(90.0, color=GREY, linewidth=0.8)
    note(axes, "least work", (MOST_FRICTION, 90.0), (0.0, 2.0), ha="right")
    axes.set_xscale("log")
    axes.set_xticks((0.5, 1.0, 2.0, 4.0), ["0.5", "1", "2", "4"])
    axes.minorticks_off()
    axes.set(xlim=(LEAST_FRICTION, MOST_FRICTION), ylim=(0.0, 98.0), xlabel="friction coefficient", ylabel="C (°)")
    axes.legend(loc="lower left", title="impact angle", labelspacing=0.3, title_fontsize=7.0, ncols=2)
    words = "solid: the shear\nplane comes out\nof the surface"
    note(axes, words, (0.97, 0.82), (0.0, 0.0), xycoords="axes fraction", ha="right", va="top")


def _frictions(study: CraterStudy, angle_deg: float) -> list[float]:
    """Return frictions from that at which least work cuts the measured depth, where the curve is steep, to the highest."""
    crater = study.crater
    given = (MEASURED, math.radians(angle_deg), crater.shear_yield_stress, int(crater.plies))
    try:
        least = float(friction_for_crater_depth(*given, compression_time=crater.compression_time))
    except ValueError:  # no friction makes it that deep, or any does
        least = LEAST_FRICTION
    if least >= MOST_FRICTION:
        return [MOST_FRICTION]
    return [least, *(least + np.geomspace(1e-6, MOST_FRICTION - least, 120)).tolist()]
