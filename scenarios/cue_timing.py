"""Cue timing: how well do the quasi-static cue formulas place the bar?

The bristle is released from rest relative to the hub at the retraction angle, with no bar in the scene. The time to its
highest relative speed, and the hub's turn meanwhile, say where the bar must stand, for each reading of the printed belt
stiffness. Full passes, with the bar there and where bar_horizontal and bar_vertical put it, show the strikes that follow.
"""

import math
import sys
from collections.abc import Mapping
from typing import Any

from bristle_sim.cli import Scenario, build, main
from bristle_sim.cli.scenario import figure, series_of_pass
from bristle_sim.comparison import Report
from bristle_sim.parameters import Bar, Belt, Bristle, Comparison, Hub, Release, Tool, Workpart
from bristle_sim.settings import Settings


def run(values: Mapping[str, Any]) -> Report:
    """Build the tool from the keys and release its bristle."""
    from bristle_sim.studies.cue_timing import cue_timing, unplaced

    hub, bristle, bar = build(Hub, values), build(Bristle, values), build(Bar, values)
    tool = Tool(
        hub=hub,
        belt=build(Belt, values),
        bristle=bristle,
        bar=unplaced(bar, hub, bristle),
        workpart=build(Workpart, values),
    )
    return cue_timing(
        tool,
        math.radians(values["retraction_deg"]),
        build(Settings, values),
        bar=bar,
        with_reference=values["reference"] == "yes",
    )


SCENARIO = Scenario(
    name="cue_timing",
    question="How well do the quasi-static cue formulas place the bar?",
    parts=(Hub, Belt, Bristle, Bar, Workpart, Release, Settings, Comparison),
    run=run,
    plot=figure("cue_figure"),
    series=series_of_pass,
    without=(
        "knee_position",
        "knee_angle_deg",
        "hub_turn",
        "friction",
        "restitution_friction",
        "restitution",
    ),
    highest={"wire_links": (4, "at most 4, of which the releases and passes for four belts take 22 s")},
    defaults={"reference": ("yes", "chosen: a release takes the independent solution little time")},
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
