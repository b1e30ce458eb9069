"""Cue timing: how well do the quasi-static cue formulas place the bar?

The bristle is released from rest relative to the hub at the retraction angle, without a bar in the
scene. The time to the bristle's highest relative speed, and the angle by which the hub turns in
that time, determine the position of the bar. This is done for each interpretation of the printed
belt stiffness. Whole passes with the bar at this position, and at bar_horizontal and bar_vertical,
show the strikes.
"""

import math
import sys

from bristle_sim.cli import Columns, Picture, Scenario, main
from bristle_sim.comparison import Report
from bristle_sim.parameters import (
    SHAPE_KEYS,
    Bar,
    Belt,
    Bristle,
    Comparison,
    Hub,
    Release,
    Tool,
    Workpart,
)
from bristle_sim.settings import Settings


def run(
    hub: Hub,
    belt: Belt,
    bristle: Bristle,
    bar: Bar,
    workpart: Workpart,
    release: Release,
    settings: Settings,
    compared: Comparison,
) -> Report:
    """Release the bristle, and compare the bar position with that of the formulas."""
    from bristle_sim.studies.cue_timing import cue_timing, unplaced

    tool = Tool(
        hub=hub, belt=belt, bristle=bristle, bar=unplaced(bar, hub, bristle), workpart=workpart
    )
    retraction = math.radians(release.retraction_deg)
    return cue_timing(
        tool, retraction, settings, bar=bar, with_reference=compared.reference == "yes"
    )


def plot(report: Report) -> Picture:
    """Draw the release, and the strikes of the whole passes."""
    from bristle_sim.render.release_figures import cue_figure

    return cue_figure(report.subject)


def series(report: Report) -> Columns:
    """Return the simulated motion."""
    return dict(report.subject.trajectory.columns())


SCENARIO = Scenario(
    name="cue_timing",
    question="How well do the quasi-static cue formulas place the bar?",
    run=run,
    plot=plot,
    series=series,
    without=(*SHAPE_KEYS, "hub_turn", "friction", "restitution_friction", "restitution"),
    defaults={"reference": ("yes", "chosen: a release takes the independent solution little time")},
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
