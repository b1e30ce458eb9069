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
from bristle_sim.render.style import add_panel, blank_figure, note, signed, styled
from bristle_sim.studies.crater_study import MEASURED, CraterStudy, cut_of
from bristle_sim.theory.crater import (
    energy_crater_depth_ratio,
    merchant_crater_depth,
    merchant_crater_depth_limit,
)
from bristle_sim.theory.crater_kinematics import PRINTED_KINEMATICS

MICRO = 1e6  # micrometres in a metre
# Angle of the rake face, leaning back from the workpart's normal, rad (Zhang 2020, eq. 4.36).
LEAN = math.radians(11.5)


@styled()
def crater_figure(study: CraterStudy) -> Figure:
    """Draw every estimate of the crater depth, um, beside the measured depth.

    A panel below shows the chip and the shear plane to scale.
    """
    figure = blank_figure(16.0, 14.1)
    rows = _estimates(study)
    name, depth, _ = min(rows, key=lambda row: abs(row[1] - MICRO * MEASURED))
    off = 100.0 * (depth / (MICRO * MEASURED) - 1.0)
    words = f"{abs(off):.0f} % {'deeper' if off > 0.0 else 'shallower'}"
    finding = f"Nearest to the measured depth: {' '.join(name.split())}, {words}"
    figure.text(1.5 / 16.0, 1.0 - 0.6 / 14.1, finding, fontsize=9.0)
    words = "shaded: within 10 % of the measured depth"
    _draw_estimates(
        add_panel(figure, (4.6, 7.7, 10.6, 4.4), "crater depth by every estimate", words), rows
    )
    _draw_chip(add_panel(figure, (1.5, 1.2, 14.0, 4.4), "chip and shear plane, to scale"), study)
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


def _draw_chip(axes: Axes, study: CraterStudy) -> None:
    """Draw workpart, path, tip with its rake face, and the two shear planes, in um.

    The tip travels along x.
    """
    gamma = study.impact_angle
    path = MICRO * float(PRINTED_KINEMATICS.tip_displacement(study.crater.compression_time))
    tip = path * _direction(-gamma)
    depth = path * math.sin(gamma)
    rising = math.pi / 4.0 - 0.5 * math.atan2(1.0, study.crater.friction)
    planes = {"shear plane to the surface": (GREEN, depth / math.sin(rising) * _direction(rising))}
    if study.angles is not None:  # the length is that of (4.28)
        eta = float(study.angles.shear)
        length = depth / math.cos(gamma) / math.sin(eta)
        planes["shear plane of (4.28)"] = (VERMILION, length * _direction(eta - gamma))
    farthest = tip[0] + max(float(along[0]) for _, along in planes.values())
    width = max(1.25 * farthest, 7.0 * depth, 1.0)
    sides = (-0.12 * width, 0.88 * width)
    height = width * axes.bbox.height / axes.bbox.width
    bottom = -max(1.7 * depth, 0.25 * height)
    upright = _direction(math.pi / 2.0 + LEAN)
    cut = np.array([(0.0, 0.0), tip, tip + depth / math.cos(LEAN) * upright])
    axes.fill_between(sides, 0.0, bottom, color="#e3e6ea", linewidth=0.0, zorder=0)
    axes.fill(*cut.T, color="white", zorder=1)
    axes.plot(sides, (0.0, 0.0), color=GREY, linewidth=0.8)
    axes.plot(*cut[:2].T, color=BLACK, label="path")
    face = 3.2 * depth * upright
    heel = 2.6 * depth * _direction(math.pi - gamma - math.radians(12.0))  # clears the path
    tool = np.array([tip, tip + face, tip + heel])
    axes.fill(*tool.T, color=GREY, alpha=0.55, linewidth=0.0, zorder=2)
    note(axes, "tip", tuple(tool.mean(axis=0)), (0.0, 0.0), color="white", ha="center", zorder=3)
    for label, (color, along) in planes.items():
        axes.plot(*np.transpose([tip, tip + along]), color=color, label=label)
    axes.set(xlim=sides, ylim=(bottom, bottom + height))
    axes.set(xlabel="along the workpart (µm)", ylabel="height (µm)")
    axes.set_aspect("equal")
    axes.legend(loc="upper right", labelspacing=0.3)


def _direction(angle: float) -> Array:
    return np.array([math.cos(angle), math.sin(angle)])
