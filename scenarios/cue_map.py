"""Cue map: where must the bar stand?

The bar goes around the hub at its distance, and each pass is simulated up to its strike. The direction for which the
bristle strikes radially is a root, that of the highest tip speed a maximum; both are compared with the dissertation's
formula and its printed position.
"""

import sys
from pathlib import Path

from bristle_sim.cli import Scenario, main
from bristle_sim.cli.scenario import study
from bristle_sim.comparison import Report
from bristle_sim.parameters import Bar, Belt, Bristle, Comparison, Hub, Tool, Workpart
from bristle_sim.settings import Settings
from bristle_sim.studies.cue_map import MapGrid


def plot(report: Report, path: Path) -> None:
    """Draw maps of lag, tip speed, normal work and crater depth over the bar's position."""
    from bristle_sim.render.map_figure import map_figure
    from bristle_sim.render.style import save_figure
    from bristle_sim.studies.cue_map import position_map

    found = report.subject
    save_figure(map_figure(found, position_map(found.tool, found.settings, found.grid)), path)


SCENARIO = Scenario(
    name="cue_map",
    question="Where must the bar stand for a radial strike, and where for the fastest tip?",
    parts=(Hub, Belt, Bristle, Bar, Workpart, Tool, Settings, Comparison, MapGrid),
    run=study("studies.cue_map.cue_map"),
    plot=plot,
    without=("knee_position", "knee_angle_deg"),
    highest={"wire_links": (2, "at most 2, with which the directions alone take 24 s and 40 passes")},
    defaults={
        "reference": ("yes", "chosen: the roots are found a second time in the independent solution"),
        "accuracy": (1e-9, "chosen: the roots are found to 1e-6"),
    },
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
