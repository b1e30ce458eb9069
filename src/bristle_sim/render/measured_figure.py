"""Draw the measured spheres with the curves of the rigid and of the elastic contact over the angle of incidence."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from bristle_sim.render.colours import BLACK, BLUE, VERMILION
from bristle_sim.render.style import add_panel, blank_figure, styled
from bristle_sim.studies.measured_impacts import MEASURED_SPHERES, Spheres, sphere_rebound

PANELS = (
    ("restitution", "tangential velocity"),
    ("spin", "spin (rad/s)"),
    ("rebound_angle", "rebound angle (°)"),
)


@styled()
def measured_figure(subject: tuple[Spheres, Spheres, Any]) -> Figure:
    """Draw velocity ratio, spin and rebound angle: points as measured, curves by the law with and without compliance."""
    compliant, rigid, _ = subject
    figure = blank_figure(16.0, 7.6)
    angle = np.linspace(0.5, 62.0, 400)
    for place, (name, title) in enumerate(PANELS):
        axes = add_panel(
            figure, (1.3 + 5.1 * place, 1.9, 3.9, 4.4), title, "after over before" if place == 0 else "after"
        )
        for each, colour, style, label in (
            (rigid, VERMILION, "--", "rigid along the surface"),
            (compliant, BLUE, "-", f"elastic, η² = {compliant.compliance:g}"),
        ):
            found = sphere_rebound(angle, each.compliance)[name]
            axes.plot(angle, found, color=colour, linestyle=style, label=label, gid=f"{name}, {label}")
        points = MEASURED_SPHERES[name]
        axes.plot(*points.T, "o", color=BLACK, markersize=3.5, label="measured", gid=f"{name}, measured")
        axes.set_xlabel("angle of incidence (°)")
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=3)
    return figure
