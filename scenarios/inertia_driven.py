"""The inertia-driven tool: how fast does a bristle strike that no bar holds back?

The wire arrives translating on a straight belt and enters the pulley with the rate 0; it lags, the belt whips it back, and it
passes the radial direction. How fast is its tip then, and how fast must the pulley turn to strike as the bar-cued tool does?
"""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bristle_sim.comparison import Report
from bristle_sim.parameters import Bar, Belt, Bristle, Comparison, Hub, Tool, Workpart
from bristle_sim.scenario_cli import Scenario, build, main
from bristle_sim.settings import Settings
from bristle_sim.studies.inertia_driven import inertia_driven


def run(values: Mapping[str, Any]) -> Report:
    """Build the bar-cued tool from the keys and run it with and without its bar."""
    tool = Tool(
        hub=build(Hub, values),
        belt=build(Belt, values),
        bristle=build(Bristle, values),
        bar=build(Bar, values),
        workpart=build(Workpart, values),
    )
    return inertia_driven(tool, build(Settings, values), with_reference=values["reference"] == "yes")


def plot(report: Report, path: Path) -> None:
    """Draw both bristles' angles over the hub's turn, and their rates over the angles."""
    from bristle_sim.render.inertia_figure import inertia_figure
    from bristle_sim.render.style import save_figure

    save_figure(inertia_figure(report.subject), path)


SCENARIO = Scenario(
    name="inertia_driven",
    question="How fast does the tip strike that inertia drives, without a bar?",
    parts=(Hub, Belt, Bristle, Bar, Workpart, Settings, Comparison),
    run=run,
    plot=plot,
    without=("knee_position", "knee_angle_deg", "hub_turn", "step"),
    defaults={
        "reference": ("yes", "chosen: a flight takes the independent solution little time"),
        "accuracy": (1e-9, "chosen: the flight is held to 1e-8 of the reference"),
    },
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
