"""Cue map: where must the bar stand?

The bar moves around the hub at constant distance from its centre, and each pass is simulated up to
its strike. One search finds the direction at which the bristle strikes radially, another the
direction of the highest tip speed. Both are compared with the dissertation's formula and with its
printed position.
"""

import sys

from bristle_sim.cli import Picture, Scenario, main
from bristle_sim.comparison import Report
from bristle_sim.parameters import CONTACT_KEYS, SHAPE_KEYS, Comparison, MapGrid, Tool
from bristle_sim.settings import Settings


def run(tool: Tool, settings: Settings, compared: Comparison, grid: MapGrid) -> Report:
    """Search the directions of the bar, and compare them with the formula and the printed position."""
    from bristle_sim.studies.cue_map import cue_map

    return cue_map(tool, settings, grid, with_reference=compared.reference == "yes")


def plot(report: Report) -> Picture:
    """Draw maps of lag, tip speed, normal work and crater depth over the bar's position."""
    from bristle_sim.render.sweep_figures import map_figure
    from bristle_sim.studies.cue_map import position_map

    return map_figure(report.subject, *position_map(report.subject))


def tool(report: Report) -> Tool:
    """Return the tool with its bar where the bristle strikes radially."""
    from bristle_sim.studies.bar_search import placed

    return placed(report.subject.tool, report.subject.radial.direction)


SCENARIO = Scenario(
    name="cue_map",
    question="Where must the bar stand for a radial strike, and where for the fastest tip?",
    run=run,
    plot=plot,
    tool=tool,
    without=(*SHAPE_KEYS, *CONTACT_KEYS),
    defaults={
        "reference": (
            "yes",
            "chosen: the roots are found a second time in the independent solution",
        ),
        "accuracy": (1e-9, "chosen: the roots are found to 1e-6"),
    },
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
