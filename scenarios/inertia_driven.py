"""The inertia-driven tool: how fast does a bristle strike that no bar holds back?

The wire arrives translating on a straight belt and enters the pulley with the rate 0; it lags, the belt whips it back, and it
passes the radial direction. How fast is its tip then, and how fast must the pulley turn to strike as the bar-cued tool does?
"""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bristle_sim.comparison import Report
from bristle_sim.parameters import Bar, Belt, Bristle, Comparison, Hub, Workpart
from bristle_sim.scenario_cli import Scenario, build, build_tool, main
from bristle_sim.scenario_cli.scenario import figure
from bristle_sim.settings import Settings


def run(values: Mapping[str, Any]) -> Report:
    """Build the bar-cued tool from the keys and run it with and without its bar."""
    from bristle_sim.studies.inertia_driven import inertia_driven

    return inertia_driven(build_tool(values), build(Settings, values), with_reference=values["reference"] == "yes")


def video(report: Report, path: Path) -> None:
    """Film both tools side by side up to their strikes."""
    from bristle_sim.render.inertia_video import inertia_video

    inertia_video(report.subject, path)


SCENARIO = Scenario(
    name="inertia_driven",
    question="How fast does the tip strike that inertia drives, without a bar?",
    parts=(Hub, Belt, Bristle, Bar, Workpart, Settings, Comparison),
    run=run,
    plot=figure("inertia_figure"),
    video=video,
    without=(
        "knee_position",
        "knee_angle_deg",
        "friction",
        "restitution_friction",
        "restitution",
        "hub_turn",
        "step",
    ),
    most={"wire_links": (4, "at most 4, of which the runs that find the equal hub speed take 17 s")},
    defaults={
        "reference": ("yes", "chosen: a flight takes the independent solution little time"),
        "accuracy": (1e-9, "chosen: the flight agrees with the reference to 1e-8"),
    },
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
