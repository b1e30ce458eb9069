"""Draw the inertia-driven bristle and the bar-cued one: retraction over the hub's turn, and both in the phase plane."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure

from bristle_sim.render.colours import BLUE, GREY, VERMILION
from bristle_sim.render.style import add_panel, blank_figure, note, styled
from bristle_sim.studies.inertia_driven import InertiaDriven


@styled()
def inertia_figure(driven: InertiaDriven) -> Figure:
    """Draw retractions in degrees and rates relative to the hub in rad/s."""
    figure = blank_figure(16.0, 8.2)
    turn = add_panel(figure, (1.5, 1.2, 6.2, 5.6), "retraction", xlabel="turn of the hub (°)", ylabel="retraction (°)")
    labels = {"xlabel": "retraction (°)", "ylabel": "rate (rad/s)"}
    phase = add_panel(figure, (9.5, 1.2, 6.2, 5.6), "rate relative to the hub", **labels)
    contact, radial = driven.pass_with_bar.first_contact("workpart"), driven.radial
    end = "no strike" if contact is None else f"{math.hypot(*contact.velocity_before):.1f} m/s at the strike"
    runs = [(driven.pass_with_bar, BLUE, "bar-cued", end)]
    if radial is not None:
        runs.append((radial.trajectory, VERMILION, "thrown by its inertia", f"{radial.tip_speed:.1f} m/s when radial"))
    for run, color, name, words in runs:
        course = run.course()
        turned, retraction = np.degrees([course.hub_angle - run.hub_angle[0], course.retraction])
        speed = course.relative_rate
        for axes, x, y in ((turn, turned, retraction), (phase, retraction, speed)):
            axes.plot(x, y, color=color, label=name)
            axes.plot([x[-1]], [y[-1]], "o", color=color, markersize=4.0, zorder=4)
            axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
        ground = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5}
        note(phase, words, (retraction[-1], speed[-1]), (6.0, 5.0), ha="left", color=color, bbox=ground)
    phase.axvline(0.0, color=GREY, linewidth=0.6, zorder=1)
    phase.margins(x=0.05, y=0.12)
    turn.legend(loc="lower left", bbox_to_anchor=(-0.02, 0.99), ncols=2)
    return figure
