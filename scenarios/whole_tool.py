"""The whole tool: what does a hand hold against, and what does a load cell under the workpart see?

One bristle is turned until its motion repeats. The tool's forces are the sum of its copies, one for each bristle, which
must not touch each other; torque and power are compared with the energy that a turn loses, and the force behind a load
cell of finite bandwidth is a band.
"""

import sys
from typing import Any

from bristle_sim.cli import Scenario, main
from bristle_sim.cli.scenario import figure, study
from bristle_sim.comparison import Report
from bristle_sim.parameters import WIRE_KEYS, Bar, Belt, Bristle, Hub, Workpart
from bristle_sim.settings import Settings
from bristle_sim.studies.whole_tool import Assembly, load_cell_series


def series(report: Report) -> dict[str, Any]:
    """Return the force behind the load cell, from one bristle to the next."""
    return load_cell_series(report.subject)


SCENARIO = Scenario(
    name="whole_tool",
    question="What does a hand hold against, and what does a load cell see?",
    parts=(Hub, Belt, Bristle, Bar, Workpart, Assembly, Settings),
    run=study("studies.whole_tool.whole_tool"),
    plot=figure("whole_tool_figure"),
    series=series,
    without=("step", "hub_turn", *WIRE_KEYS),
    defaults={"accuracy": (1e-8, "chosen: forces and power are compared to 1e-6")},
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
