"""Figure of a single impact: velocities of the tip over the normal impulse.

The energetic law is compared with a contact that is simulated in time.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.render.colours import BLACK, BLUE, VERMILION
from bristle_sim.render.style import (
    Look,
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
LINES = {"tangential_velocity": ("tangential", VERMILION), "normal_velocity": ("normal", BLUE)}


@styled()
def impact_figure(impacts: Impacts) -> Figure:
    """Draw the tip's velocity components over the normal impulse during an impact.

    Lines are the energetic law. Crosses are a contact simulated in time, if there is one.
    """
    surface = impacts.surface
    angles = ", ".join(f"{math.degrees(-angle):.4g}°" for angle in impacts.chain.angles)
    words = f"{angles} to the normal, μ = {surface.friction:.4g}, e* = {surface.restitution:.4g}"
    if surface.restitution_friction is not None:
        words += f", μ₂ = {surface.restitution_friction:.4g}"
    law = "energetic law"
    resolved = impacts.strikes.get("compliant")
    recorded = None
    if resolved is not None and resolved.contact.history is not None:
        recorded = recorded_course(resolved.contact.history)
        elastic = impacts.contact.tangential_compliance
        law = "lines: rigid along the surface" if elastic else "lines: energetic law"
        law += f"; crosses: resolved in time{', elastic' if elastic else ''}"
    figure = blank_figure(16.0, 7.4)
    axes = figure.subplots()
    axes.set_title(f"the impact over its normal impulse, {words}\n{law}")
    _draw_impulse_plane(axes, energetic_course(impacts.chain, surface), recorded)
    return figure


def _draw_impulse_plane(axes: Axes, course: ImpulseCourse, recorded: ImpulseCourse | None) -> None:
    """Draw the tip's velocity components over the normal impulse, with the impact's phases shaded.

    Args:
        axes: axes of the drawing.
        course: velocities by the energetic law, drawn as lines.
        recorded: velocities of a contact simulated in time, drawn as crosses; None if there is no
            such contact.
    """
    fastest = float(np.abs([course.normal_velocity, course.tangential_velocity]).max())
    impulse = scale_for(float(course.impulse[-1]), "N·s")
    speed = scale_for(fastest, "m/s")
    axes.set_xlabel(f"normal impulse ({impulse.unit})")
    axes.set_ylabel(f"velocity of the tip ({speed.unit})")
    if course.impulse.size < 2:
        say(axes, "the tip does not approach: no contact")
        return
    draw_zero(axes)
    end = float(course.impulse[-1])
    for which, (name, color) in LINES.items():
        values = getattr(course, which) * speed.factor
        axes.plot(course.impulse * impulse.factor, values, color=color, gid=which, label=name)
        if recorded is not None:
            points = (recorded.impulse * impulse.factor, getattr(recorded, which) * speed.factor)
            gid = f"{which}, resolved in time"
            axes.plot(*points, "x", color=BLACK, markersize=3.6, zorder=3, gid=gid)
            end = max(end, float(recorded.impulse[-1]))
    axes.legend(loc="lower right")
    axes.set_xlim(0.0, 1.03 * end * impulse.factor)
    axes.margins(y=0.25)  # room for the names of the phases
    edges = course.impulse * impulse.factor
    for name, (start, stop) in zip(course.phases, pairwise(edges), strict=False):
        axes.axvspan(start, stop, color=PHASE_COLOURS[name], linewidth=0.0, zorder=0)
        if stop - start >= NARROWEST_NAMED * axes.get_xlim()[1]:
            place = (0.5 * (start + stop), 0.97)
            look: Look = {"transform": axes.get_xaxis_transform(), "fontsize": 7.0}
            axes.text(*place, name.replace(" ", "\n"), ha="center", va="top", **look)
