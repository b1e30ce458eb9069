"""Tolerances: which tolerance matters most?

The tool's inputs vary about their values, as real parts, belts and handling do, and thousands of
passes are simulated. The variation of the strike, and the inputs that cause it, are compared with
first-order error propagation. A second list states which differences between printed and computed
numbers the rounding of the printed inputs explains.
"""

import sys

from bristle_sim.cli import Picture, Scenario, main
from bristle_sim.comparison import Report
from bristle_sim.parameters import CONTACT_KEYS, SHAPE_KEYS, Sampling, Spreads, Tool
from bristle_sim.settings import Settings


def run(tool: Tool, spreads: Spreads, sampling: Sampling, settings: Settings) -> Report:
    """Simulate tools with varied inputs, and find the inputs that make the strike vary."""
    from bristle_sim.studies.tolerances import tolerances

    return tolerances(tool, spreads, sampling, settings)


def plot(report: Report) -> Picture:
    """Draw the variation of each output and its causes."""
    from bristle_sim.render.sweep_figures import tolerance_figure

    return tolerance_figure(report.subject)


SCENARIO = Scenario(
    name="tolerances",
    question="Which tolerance matters, and how far does the strike spread?",
    run=run,
    plot=plot,
    without=(*SHAPE_KEYS, *CONTACT_KEYS),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
