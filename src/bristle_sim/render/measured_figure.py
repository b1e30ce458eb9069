"""Draw the measured spheres with the curves of the rigid and of the elastic contact over the angle of incidence."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from bristle_sim.render.colours import BLACK, BLUE, VERMILION
from bristle_sim.render.style import add_panel, blank_figure, styled
from bristle_sim.studies.measured_impacts import MEASURED_SPHERES, Spheres, sphere_rebound

PANELS = {
    "restitution": ("tangential velocity", "after over before"),
    "spin": ("spin (rad/s)", "after"),
    "rebound_angle": ("rebound angle (°)", "after"),
}


@styled()
def measured_figure(subject: tuple[Spheres, Spheres, Any]) -> Figure:
    """Draw velocity ratio, spin and rebound angle: points as measured, curves by the law with and without compliance."""
    compliant, rigid, _ = subject
    figure, angle, lines = blank_figure(16.0, 7.6), np.linspace(0.5, 62.0, 400), []
    for place, (name, (title, words)) in enumerate(PANELS.items()):
        axes = add_panel(figure, (1.3 + 5.1 * place, 1.9, 3.9, 4.4), title, words, xlabel="angle of incidence (°)")
        by_compliance = [sphere_rebound(angle, each.compliance)[name] for each in (rigid, compliant)]
        lines = axes.plot(angle, by_compliance[0], "--", color=VERMILION, label="rigid along the surface")
        lines += axes.plot(angle, by_compliance[1], color=BLUE, label=f"elastic, η² = {compliant.compliance:g}")
        lines += axes.plot(*MEASURED_SPHERES[name].T, "o", color=BLACK, markersize=3.5, label="measured")
    figure.legend(handles=lines, loc="lower center", ncols=3)
    return figure
