"""Tolerances: which of them matters?

The tool's inputs spread about their values as parts, belts and hands do; thousands of passes are simulated. How the strike
spreads, and which input is to blame, is compared with first-order error propagation. A second list says how far the rounding
of the printed inputs explains where the printed numbers differ from the computed ones.
"""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bristle_sim.comparison import Report
from bristle_sim.parameters import Bar, Belt, Bristle, Hub, Tool, Workpart
from bristle_sim.scenario_cli import Scenario, build, main
from bristle_sim.settings import Settings
from bristle_sim.studies.tolerances import Sampling, Spreads, tolerances


def run(values: Mapping[str, Any]) -> Report:
    """Build the tool from the keys and simulate its passes with spread inputs."""
    tool = Tool(
        hub=build(Hub, values),
        belt=build(Belt, values),
        bristle=build(Bristle, values),
        bar=build(Bar, values),
        workpart=build(Workpart, values),
        gravity=values["gravity"],
    )
    return tolerances(tool, build(Spreads, values), build(Sampling, values), build(Settings, values))


def plot(report: Report, path: Path) -> None:
    """Draw the outputs' distributions and the Sobol indices of the inputs."""
    from bristle_sim.render.style import save_figure
    from bristle_sim.render.tolerance_figure import tolerance_figure

    save_figure(tolerance_figure(report.subject), path)


SCENARIO = Scenario(
    name="tolerances",
    question="Which tolerance matters, and how far does the strike spread?",
    parts=(Hub, Belt, Bristle, Bar, Workpart, Tool, Settings, Spreads, Sampling),
    run=run,
    plot=plot,
    without=("knee_position", "knee_angle_deg"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
