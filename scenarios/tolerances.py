"""Tolerances: which of them matters?

The tool's inputs spread about their values as parts, belts and hands do; thousands of passes are simulated. How the strike
spreads, and which input causes it, is compared with first-order error propagation. A second list says how far the rounding
of the printed inputs explains where the printed numbers differ from the computed ones.
"""

import sys

from bristle_sim.cli import Scenario, main
from bristle_sim.cli.scenario import figure, study
from bristle_sim.parameters import Bar, Belt, Bristle, Hub, Tool, Workpart
from bristle_sim.settings import Settings
from bristle_sim.studies.tolerances import Sampling, Spreads

SCENARIO = Scenario(
    name="tolerances",
    question="Which tolerance matters, and how far does the strike spread?",
    parts=(Hub, Belt, Bristle, Bar, Workpart, Tool, Settings, Spreads, Sampling),
    run=study("studies.tolerances.tolerances"),
    plot=figure("tolerance_figure"),
    without=("knee_position", "knee_angle_deg"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
