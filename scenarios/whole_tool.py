"""The whole tool: which forces does a hand bear, and what does a load cell under the workpart show?

One bristle is simulated, revolution by revolution, until its motion repeats. The tool's forces are
sums over copies of this motion, one for each bristle; the bristles must not touch each other.
Torque and power are compared with the energy dissipated in a revolution. The force that a load cell
of finite bandwidth shows varies within a band.
"""

import sys

from bristle_sim.cli import Columns, Picture, Scenario, main
from bristle_sim.comparison import Report
from bristle_sim.parameters import CONTACT_KEYS, WIRE_KEYS, Assembly, Tool
from bristle_sim.settings import Settings


def run(tool: Tool, assembly: Assembly, settings: Settings) -> Report:
    """Simulate one bristle until its motion repeats, and sum the forces of all bristles."""
    from bristle_sim.studies.whole_tool import whole_tool

    return whole_tool(tool, assembly, settings)


def plot(report: Report) -> Picture:
    """Draw the force of one bristle, and the force of all bristles that the load cell shows."""
    from bristle_sim.render.force_figures import whole_tool_figure

    return whole_tool_figure(report.subject)


def series(report: Report) -> Columns:
    """Return the force that the load cell shows, over the time between two bristles."""
    from bristle_sim.studies.whole_tool import load_cell_series

    return load_cell_series(report.subject)


SCENARIO = Scenario(
    name="whole_tool",
    question="Which forces does a hand bear, and what does a load cell show?",
    run=run,
    plot=plot,
    series=series,
    without=(*WIRE_KEYS, *CONTACT_KEYS, "gravity", "hub_turn"),
    defaults={"accuracy": (1e-8, "chosen: forces and power are compared to 1e-6")},
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
