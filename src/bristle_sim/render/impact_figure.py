"""Figure of a single impact: velocities of the tip over the normal impulse.

The energetic law is compared with a contact that is resolved in time.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.render.colours import BLACK, BLUE, VERMILION
from bristle_sim.render.style import (
    add_panel,
    blank_figure,
    draw_zero,
    say,
    scale_for,
    styled,
)
from bristle_sim.studies.contact_laws import Impacts
from bristle_sim.studies.impulse_course import ImpulseCourse, energetic_course, recorded_course

PHASE_COLOURS = {
    "compression slip": "#e6eef6", "compression reverse slip": "#d3e2f0", "compression stick": "#dadde6",
    "restitution slip": "#eff5e8", "restitution reverse slip": "#e0ecd2", "restitution stick": "#e7e7df",
}  # fmt: skip
# Width of the narrowest phase whose name is shown, as a fraction of the panel
NARROWEST_NAMED = 0.09
LINES = {"tangential_velocity": ("$v_t$", VERMILION), "normal_velocity": ("$v_n$", BLUE)}


@styled()
def impact_figure(impacts: Impacts) -> Figure:
    """Draw the velocities of the tip over the normal impulse of an impact.

    The energetic law is drawn as lines, a contact that is resolved in time as crosses.
    """
    figure = blank_figure(16.0, 7.4)
    surface = impacts.surface
    angles = ", ".join(f"{math.degrees(-angle):.4g}°" for angle in impacts.chain.angles)
    words = f"{angles} to the normal, μ = {surface.friction:.4g}"
    if surface.restitution_friction is not None:
        words += f", μ₂ = {surface.restitution_friction:.4g}"
    words += f", e* = {surface.restitution:.4g}"
    course = energetic_course(impacts.chain, surface)
    end = float(course.impulse[-1])
    recorded = None
    resolved = impacts.strikes.get("compliant")
    if resolved is not None and resolved.contact.history is not None:
        recorded = recorded_course(resolved.contact.history)
        if resolved.contact.outcome == "rebound":  # a tip in stiction stays in contact
            end = max(end, float(recorded.impulse[-1]))
        elastic = bool(impacts.contact.tangential_compliance)
        words += "; lines: " + ("rigid along the surface" if elastic else "energetic law")
        words += ", crosses: resolved in time" + ", elastic" * elastic
    axes = add_panel(figure, (1.45, 1.3, 13.4, 4.9), "the impact over its normal impulse", words)
    _draw_impulse_plane(axes, course, recorded, end)
    return figure


def _draw_impulse_plane(
    axes: Axes, course: ImpulseCourse, recorded: ImpulseCourse | None, end: float
) -> None:
    """Draw the tip's velocities over the normal impulse, with the phases of the impact shaded.

    Args:
        axes: axes of the drawing.
        course: the energetic law, drawn as straight lines.
        recorded: a contact resolved in time, drawn as crosses.
        end: largest normal impulse shown, N s.
    """
    fastest = float(np.abs([course.normal_velocity, course.tangential_velocity]).max())
    impulse = scale_for(float(course.impulse[-1]), "N·s")
    speed = scale_for(fastest, "m/s")
    axes.set(
        xlabel=f"normal impulse p ({impulse.unit})", ylabel=f"velocity of the tip ({speed.unit})"
    )
    if course.impulse.size < 2:
        say(axes, "the tip does not approach: no contact")
        return
    draw_zero(axes)
    for which, (name, color) in LINES.items():
        values = getattr(course, which) * speed.factor
        axes.plot(course.impulse * impulse.factor, values, color=color, gid=which, label=name)
        if recorded is not None:
            points = (recorded.impulse * impulse.factor, getattr(recorded, which) * speed.factor)
            (crosses,) = axes.plot(*points, "x", color=BLACK, gid=f"{which}, resolved in time")
            crosses.set(markersize=3.6, markeredgewidth=0.8, zorder=3)
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.08), ncols=2, fontsize=9.0)
    bottom, top = axes.get_ylim()
    axes.set_xlim(0.0, 1.03 * end * impulse.factor)
    axes.set_ylim(top=top + 0.24 * (top - bottom))  # room for the names of the phases
    _shade_phases(axes, course, impulse.factor)


def _shade_phases(axes: Axes, course: ImpulseCourse, factor: float) -> None:
    right = axes.get_xlim()[1]
    for name, (start, end) in zip(course.phases, pairwise(course.impulse * factor), strict=False):
        axes.axvspan(start, end, color=PHASE_COLOURS[name], linewidth=0.0, zorder=0)
        if end - start >= NARROWEST_NAMED * right:
            words = (
                name.replace(" ", "\n")
                if end - start < 0.25 * right
                else name.replace(" ", "\n", 1)
            )
            above = axes.get_xaxis_transform()
            axes.text(
                0.5 * (start + end),
                0.97,
                words,
                transform=above,
                ha="center",
                va="top",
                fontsize=7.0,
            )
