"""The constant C of (4.45) that the measured crater asks for, over friction, as a panel of the crater's figure."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes

from bristle_sim.render.style import BLACK, GREY, ORANGE, SERIES
from bristle_sim.studies.crater_constant import IMPACT_ANGLES_DEG, constants_over
from bristle_sim.studies.crater_study import MEASURED, CraterStudy
from bristle_sim.theory.crater import friction_for_crater_depth

__all__ = ["draw_constants"]

LOWEST, HIGHEST = 0.4, 4.0
"""Friction coefficients shown (Zhang 2020, fig. 4.14 goes from 0.45 to 4)."""

TICKS = (0.5, 1.0, 2.0, 4.0)


def draw_constants(axes: Axes, study: CraterStudy) -> None:
    """A curve for each impact angle, solid where the shear plane comes out of the surface and dotted where it does not."""
    for angle, color in zip(IMPACT_ANGLES_DEG, SERIES, strict=False):
        frictions = _frictions(study, angle)
        rows = constants_over(study.crater, MEASURED, frictions, (angle,))
        found = np.array([each["constant_deg"] or np.nan for each in rows])
        chip = np.array([bool(each["shear_plane_emerges"]) for each in rows])
        axes.plot(frictions, found, color=color, linewidth=0.9, dashes=(1, 1.2))
        axes.plot(frictions, np.where(chip, found, np.nan), color=color, linewidth=1.8, label=f"{angle:g}°")
    own = constants_over(study.crater, MEASURED, (study.crater.friction,), (study.crater.impact_angle_deg,))[0]
    if own["constant_deg"] is not None:
        axes.plot([own["friction"]], [own["constant_deg"]], marker="*", color=ORANGE, markersize=9, markeredgecolor=BLACK,
                  markeredgewidth=0.6, zorder=4, linestyle="none",
                  label=f"{own['constant_deg']:.1f}° with {own['friction']:g}")  # fmt: skip
    axes.axhline(90.0, color=GREY, linewidth=0.8)
    axes.annotate("least work", (HIGHEST, 90.0), (0, 2), textcoords="offset points", ha="right", fontsize=7.0,
                  color=GREY)  # fmt: skip
    axes.set_xscale("log")
    axes.set_xticks(TICKS, [f"{each:g}" for each in TICKS])
    axes.minorticks_off()
    axes.set(xlim=(LOWEST, HIGHEST), ylim=(0.0, 98.0), xlabel="friction coefficient", ylabel="C (deg)")
    axes.legend(loc="lower left", title="impact angle", labelspacing=0.3, title_fontsize=7.0)
    axes.annotate("solid: the shear\nplane comes out\nof the surface", (0.97, 0.82), xycoords="axes fraction", ha="right",
                  va="top", fontsize=7.0, color=GREY)  # fmt: skip


def _frictions(study: CraterStudy, angle_deg: float) -> list[float]:
    """From that at which least work cuts the measured depth, where the curve is steep, to the highest."""
    crater = study.crater
    try:
        least = float(
            friction_for_crater_depth(
                MEASURED,
                math.radians(angle_deg),
                crater.shear_yield_stress,
                int(crater.plies),
                compression_time=crater.compression_time,
            )
        )
    except ValueError:  # no friction makes it that deep, or any does
        least = LOWEST
    if least >= HIGHEST:
        return [HIGHEST]
    return [least, *(least + np.geomspace(1e-6, HIGHEST - least, 120)).tolist()]
