"""Figure of the crater: every estimate of its depth beside the measured depth, and the chip to
scale.
"""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.arrays import Array
from bristle_sim.render.colours import BLACK, BLUE, GREEN, GREY, VERMILION
from bristle_sim.render.drawing import show_points
from bristle_sim.render.style import add_panel, blank_figure, draw_zero, note, styled
from bristle_sim.studies.crater_study import MEASURED, CraterStudy, cut_of
from bristle_sim.theory.crater import (
    energy_crater_depth_ratio,
    merchant_crater_depth,
    merchant_crater_depth_limit,
)
from bristle_sim.theory.crater_kinematics import PRINTED_KINEMATICS

MICRO = 1e6  # micrometres in a metre
MEASURED_DEPTH = MICRO * MEASURED
# Angle of the rake face, leaning back from the workpart's normal, rad (Zhang 2020, eq. 4.36).
LEAN = math.radians(11.5)


@styled()
def crater_figure(study: CraterStudy) -> Figure:
    """Draw every estimate of the crater depth, um, beside the measured depth.

    A panel below shows the chip and the shear plane to scale.
    """
    figure = blank_figure(16.0, 14.1)
    rows = _estimates(study)
    name, depth, _ = min(rows, key=lambda row: abs(row[1] - MEASURED_DEPTH))
    off = depth / MEASURED_DEPTH - 1.0
    words = f"{100.0 * abs(off):.0f} % {'deeper' if off > 0.0 else 'shallower'}"
    finding = f"Nearest to the measured depth: {' '.join(name.split())}, {words}"
    figure.text(1.5 / 16.0, 1.0 - 0.6 / 14.1, finding, fontsize=9.0)
    words = "shaded: within 10 % of the measured depth"
    label = f"crater depth (µm); line: measured, {MEASURED_DEPTH:.0f} µm"
    place = (4.6, 7.7, 8.8, 4.4)
    _draw_estimates(
        add_panel(figure, place, "crater depth by every estimate", words, xlabel=label), rows
    )
    chip = add_panel(
        figure,
        (1.5, 1.2, 14.0, 4.4),
        "chip and shear plane, to scale",
        xlabel="along the workpart (µm)",
        ylabel="height (µm)",
    )
    _draw_chip(chip, study)
    return figure


def _estimates(study: CraterStudy) -> list[tuple[str, float, str]]:
    """Return name, depth (um) and colour of every estimate of the crater depth.

    The sum of work and energy, which gives millimetres, is left out.
    """
    crater = study.crater
    force = study.craters.get("parallel")
    rows = []
    ratio = float(
        energy_crater_depth_ratio(5, study.impact_angle, compression_time=crater.compression_time)
    )
    if study.angles is not None:
        cut = cut_of(crater, study.wire_diameter)
        name = f"Merchant, {crater.plies:g} plies"
        rows.append((name, float(merchant_crater_depth(plies=crater.plies, **cut)), BLUE))
        rows.append(("Merchant, limit", float(merchant_crater_depth_limit(**cut)), BLUE))
    rows.append(("ratio of sums (4.66), 5 plies", ratio, GREEN))
    if force is not None and force.shear_plane_emerges:
        rows.append(("simulated force", force.depth_from_force, VERMILION))
        rows.append(("simulated energy", force.depth_from_energy, VERMILION))
    if (inclined := study.craters.get("inclined")) is not None:
        rows.append(
            ("simulated energy,\nshear to the surface", inclined.depth_from_energy, VERMILION)
        )
    return [(name, MICRO * depth, color) for name, depth, color in rows]


def _draw_estimates(axes: Axes, rows: list[tuple[str, float, str]]) -> None:
    names, depths, colors = zip(*rows, strict=True)
    axes.axvspan(0.9 * MEASURED_DEPTH, 1.1 * MEASURED_DEPTH, color=GREY, alpha=0.18, linewidth=0.0)
    axes.axvline(MEASURED_DEPTH, color=BLACK, linewidth=1.2)
    places = range(len(rows))
    axes.barh(places, depths, color=colors, alpha=0.55, height=0.6)
    axes.set_yticks(places, names)
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    off = [f"{100.0 * (depth / MEASURED_DEPTH - 1.0):+.0f} %" for depth in depths]
    words = [f"{depth:.0f} µm, {each}" for depth, each in zip(depths, off, strict=True)]
    axes.secondary_yaxis("right").set_yticks(
        places, [each.replace("-", "\N{MINUS SIGN}") for each in words]
    )


def _draw_chip(axes: Axes, study: CraterStudy) -> None:
    """Draw workpart, path, tip with its rake face, and the two shear planes, in um.

    The tip travels along x.
    """
    gamma = study.impact_angle
    path = MICRO * float(PRINTED_KINEMATICS.tip_displacement(study.crater.compression_time))
    tip = path * _direction(-gamma)
    depth = path * math.sin(gamma)
    rising = math.pi / 4.0 - 0.5 * math.atan2(1.0, study.crater.friction)
    planes = {"shear plane to the surface": (GREEN, depth / math.sin(rising), rising)}
    if study.angles is not None:  # the length is that of (4.28)
        eta = float(study.angles.shear)
        length = depth / math.cos(gamma) / math.sin(eta)
        planes["shear plane of (4.28)"] = (VERMILION, length, eta - gamma)
    heel = math.pi - gamma - math.radians(12.0)  # clears the path
    rake = math.pi / 2.0 + LEAN
    tool = tip + depth * np.array([(0.0, 0.0), 3.2 * _direction(rake), 2.6 * _direction(heel)])
    lines = {"path": (BLACK, np.array([(0.0, 0.0), tip]))}
    for label, (color, length, angle) in planes.items():
        lines[label] = (color, np.array([tip, tip + length * _direction(angle)]))
    show_points(axes, [*(points for _, points in lines.values()), 0.5 * (tip + tool)], 0.08)
    axes.axhspan(axes.get_ylim()[0], 0.0, color="#e3e6ea", linewidth=0.0, zorder=0)
    draw_zero(axes)
    axes.fill(*tool.T, color=GREY, alpha=0.55, linewidth=0.0, zorder=2)
    note(axes, "tip", tuple(tool.mean(axis=0)), (0.0, 0.0), color="white", ha="center", zorder=3)
    for label, (color, points) in lines.items():
        axes.plot(*points.T, color=color, label=label)
    axes.legend(loc="upper right", labelspacing=0.3)


def _direction(angle: float) -> Array:
    return np.array([math.cos(angle), math.sin(angle)])
