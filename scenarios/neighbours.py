"""Neighbours: below what spacing do the bristles of one plane touch each other, and how does a
touch change the strike?

A row of bristles on one hub, each one pitch behind the one ahead, is simulated together. The wires
may touch each other, the bar and the workpart. Bristles that touch no other bristle all perform the
same pass, from which theory finds the least pitch.
"""

import sys

from bristle_sim.cli import Columns, Film, Picture, Scenario, main
from bristle_sim.comparison import Report
from bristle_sim.parameters import CONTACT_KEYS, SHAPE_KEYS, Comparison, Neighbours, Tool
from bristle_sim.settings import Settings


def run(tool: Tool, row: Neighbours, settings: Settings, compared: Comparison) -> Report:
    """Simulate the row, and search for the least pitches."""
    from bristle_sim.studies.neighbours import neighbours

    return neighbours(tool, row, settings, with_reference=compared.reference == "yes")


def plot(report: Report) -> Picture:
    """Draw the row at its first touch, and the strike over the pitch, with the least pitches
    marked.
    """
    from bristle_sim.render.bristle_figures import neighbours_figure, pitches_to_draw
    from bristle_sim.studies.neighbours import over_pitch

    pitches = pitches_to_draw(report.subject)
    return neighbours_figure(report.subject, pitches, over_pitch(report.subject, pitches))


def film(report: Report, **size: int) -> Film:
    """Film the row."""
    from bristle_sim.render.tool_films import row_film

    return row_film(report.subject, **size)


def series(report: Report) -> Columns:
    """Return the motion of every bristle."""
    from bristle_sim.studies.neighbours import row_series

    return row_series(report.subject)


SCENARIO = Scenario(
    name="neighbours",
    question="From what pitch do bristles of one plane touch each other, and what does a touch do?",
    run=run,
    plot=plot,
    film=film,
    series=series,
    without=(*SHAPE_KEYS, *CONTACT_KEYS, "gravity"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
