"""Neighbours: from what spacing do the bristles of one plane touch each other, and what does a touch do to the strike?

A row of bristles on one hub, each a pitch behind the one before, is simulated together: wires touch each other, bar and
workpart. Bristles that touch no other one are copies of a single pass, from which theory finds the least pitch.
"""

import sys
from pathlib import Path
from typing import Any

from bristle_sim.cli import Scenario, main
from bristle_sim.cli.scenario import film, study
from bristle_sim.comparison import Report
from bristle_sim.parameters import Bar, Belt, Bristle, Comparison, Hub, Neighbours, Workpart
from bristle_sim.settings import Settings


def plot(report: Report, path: Path) -> None:
    """Draw the row at its first touch, and the strike over the pitch with the least pitches."""
    from bristle_sim.render.neighbours_figure import neighbours_figure, pitches_to_draw
    from bristle_sim.render.style import save_figure
    from bristle_sim.studies.neighbours import over_pitch

    pitches = pitches_to_draw(report.subject)
    save_figure(neighbours_figure(report.subject, pitches, over_pitch(report.subject, pitches)), path)


def series(report: Report) -> dict[str, Any]:
    """Return the motion of every bristle."""
    from bristle_sim.studies.neighbours import row_series

    return row_series(report.subject)


SCENARIO = Scenario(
    name="neighbours",
    question="From what pitch do bristles of one plane touch each other, and what does a touch do?",
    parts=(Hub, Belt, Bristle, Bar, Workpart, Neighbours, Settings, Comparison),
    run=study("studies.neighbours.neighbours"),
    plot=plot,
    video=film("tool_films.RowFilm"),
    series=series,
    without=("knee_position", "knee_angle_deg", "step"),
    highest={"wire_links": (4, "at most 4, of which two bristles take 15 s, and minutes to find the pitches")},
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
