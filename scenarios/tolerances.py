"""Tolerances: which of them matters?

The tool's inputs spread about their values as parts, belts and hands do; thousands of passes are simulated. How the strike
spreads, and which input causes it, is compared with first-order error propagation. A second list says how far the rounding
of the printed inputs explains where the printed numbers differ from the computed ones.
"""

import sys

from bristle_sim.cli import Picture, Scenario, main
from bristle_sim.comparison import Report
from bristle_sim.parameters import CONTACT_KEYS, SHAPE_KEYS, Sampling, Spreads, Tool
from bristle_sim.settings import Settings


def run(tool: Tool, spreads: Spreads, sampling: Sampling, settings: Settings) -> Report:
    """Simulate tools whose inputs spread, and find which input makes the strike spread."""
    from bristle_sim.studies.tolerances import tolerances

    return tolerances(tool, spreads, sampling, settings)


def plot(report: Report) -> Picture:
    """Draw the spread of each output and its causes."""
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
