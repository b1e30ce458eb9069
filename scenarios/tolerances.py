"""Tolerances: which of them matters?

The tool's inputs spread about their values as parts, belts and hands do; thousands of passes are simulated. How the strike
spreads, and which input causes it, is compared with first-order error propagation.
"""

import sys
from collections.abc import Mapping
from typing import Any

from bristle_sim.comparison import Report
from bristle_sim.parameters import Bar, Belt, Bristle, Hub, Tool, Workpart
from bristle_sim.scenario_cli import Scenario, build, build_tool, main
from bristle_sim.scenario_cli.scenario import figure
from bristle_sim.settings import Settings
from bristle_sim.studies.tolerances import Sampling, Spreads, tolerances


def run(values: Mapping[str, Any]) -> Report:
    """Build the tool from the keys and simulate its passes with spread inputs."""
    return tolerances(build_tool(values), build(Spreads, values), build(Sampling, values), build(Settings, values))


SCENARIO = Scenario(
    name="tolerances",
    question="Which tolerance matters, and how far does the strike spread?",
    parts=(Hub, Belt, Bristle, Bar, Workpart, Tool, Settings, Spreads, Sampling),
    run=run,
    plot=figure("tolerance_figure"),
    without=("knee_position", "knee_angle_deg"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
