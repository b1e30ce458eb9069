"""Every computed figure of the dissertation, and table 3.1, redrawn from the equations, with
simulated points on top.

If a figure's quantity can be simulated, the points are simulated impacts, by the energetic law and
with contacts resolved in time. Otherwise they are values of the printed equation with its printed
numbers. The table states the distances of the points from the curves. ``--plot FOLDER`` writes one
picture for each figure, ``--plot FILE.pdf`` one page for each. ``--only 2.24`` selects one figure.
"""

import sys
from pathlib import Path

from bristle_sim.cli import Scenario, main
from bristle_sim.comparison import Report
from bristle_sim.dissertation.figures import Selection


def run(selection: Selection) -> Report:
    """Compute the curves of the figures and the simulated points."""
    from bristle_sim.dissertation.figures import figures_report

    return figures_report(selection)


def plots(report: Report, target: Path) -> None:
    """Draw each figure to a file named after its number, or on its own page of a PDF."""
    from bristle_sim.render.dissertation_figures import save_figures

    save_figures(report.subject, target)


SCENARIO = Scenario(
    name="dissertation_figures",
    question="Do simulated impacts and printed equations lie on the dissertation's curves?",
    run=run,
    plots=plots,
    options=("only",),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
