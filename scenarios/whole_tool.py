"""The whole tool: what does a hand hold against, and what does a load cell under the workpart see?

One bristle is turned until its motion repeats. The tool's forces are the sum of its copies, one for each bristle, which
must not touch each other; mean forces, torque and power are compared with the impulses and with the energy that a turn
loses, and the force behind a load cell of finite bandwidth is a band.
"""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bristle_sim.comparison import Report
from bristle_sim.parameters import Bar, Belt, Bristle, Hub, Tool, Workpart
from bristle_sim.scenario_cli import Scenario, build, main
from bristle_sim.settings import Settings
from bristle_sim.studies.whole_tool import Assembly, load_cell_series, whole_tool


def run(values: Mapping[str, Any]) -> Report:
    """Build the tool from the keys, and sum the forces of its bristles."""
    tool = Tool(
        hub=build(Hub, values),
        belt=build(Belt, values),
        bristle=build(Bristle, values),
        bar=build(Bar, values),
        workpart=build(Workpart, values),
    )
    return whole_tool(tool, build(Assembly, values), build(Settings, values))


def plot(report: Report, path: Path) -> None:
    """Draw the forces of one bristle in a turn, and the force and its band behind the load cell."""
    from bristle_sim.render.style import save_figure
    from bristle_sim.render.whole_tool_figure import whole_tool_figure

    save_figure(whole_tool_figure(report.subject), path)


def series(report: Report) -> dict[str, Any]:
    """Return the force behind the load cell, from one bristle to the next."""
    return load_cell_series(report.subject)


SCENARIO = Scenario(
    name="whole_tool",
    question="What does a hand hold against, and what does a load cell see?",
    parts=(Hub, Belt, Bristle, Bar, Workpart, Assembly, Settings),
    run=run,
    plot=plot,
    series=series,
    without=("step", "hub_turn"),
    defaults={"accuracy": (1e-8, "chosen: forces and power are compared to 1e-6")},
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
