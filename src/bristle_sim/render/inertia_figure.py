"""Draw the inertia-driven bristle and the bar-cued one: retraction over the hub's turn, and both in the phase plane."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure

from bristle_sim.render.panels import note, panel_title
from bristle_sim.render.style import BLUE, GREY, VERMILION, axes_at, blank_figure, styled
from bristle_sim.studies.inertia_driven import InertiaDriven
from bristle_sim.trajectory import Trajectory
from bristle_sim.trajectory.sampled_motion import SampledMotion

WIDTH, HEIGHT = 16.0, 8.2
"""Printed size, cm."""


@styled()
def inertia_figure(driven: InertiaDriven) -> Figure:
    """Draw retractions in degrees and rates relative to the hub in rad/s."""
    figure = blank_figure(WIDTH, HEIGHT)
    turn = axes_at(figure, 1.5, 1.2, 6.2, 5.6)
    phase = axes_at(figure, 9.5, 1.2, 6.2, 5.6)
    panel_title(turn, "a", "retraction")
    panel_title(phase, "b", "rate relative to the hub")
    for run, color, name, end in _runs(driven):
        motion = SampledMotion(run)
        course = motion.course()
        retraction = np.degrees(course.retraction)
        turned = np.degrees(motion.hub_angle(course.time) - run.hub_angle[0])
        turn.plot(turned, retraction, color=color, label=name)
        phase.plot(retraction, course.relative_speed, color=color)
        for axes, x, y in ((turn, turned, retraction), (phase, retraction, course.relative_speed)):
            axes.plot([x[-1]], [y[-1]], "o", color=color, markersize=4.0, zorder=4)
        note(phase, end, (retraction[-1], course.relative_speed[-1]), (6.0, 5.0), ha="left", color=color)
    for axes in (turn, phase):
        axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    phase.axvline(0.0, color=GREY, linewidth=0.6, zorder=1)
    turn.set(xlabel="turn of the hub (°)", ylabel="retraction (°)")
    phase.set(xlabel="retraction (°)", ylabel="rate (rad/s)")
    phase.margins(x=0.05, y=0.12)
    turn.legend(loc="upper left", labelspacing=0.3)
    return figure


def _runs(driven: InertiaDriven) -> list[tuple[Trajectory, str, str, str]]:
    """Return each run with its colour, name, and the tip's speed at its end."""
    found = []
    contact = driven.pass_with_bar.first_contact("workpart")
    speed = "no strike" if contact is None else f"{math.hypot(*contact.velocity_before):.1f} m/s at the strike"
    found.append((driven.pass_with_bar, BLUE, "bar-cued", speed))
    if driven.radial is not None:
        speed = f"{driven.radial.tip_speed:.1f} m/s when radial"
        found.append((driven.radial.trajectory, VERMILION, "thrown by its inertia", speed))
    return found
