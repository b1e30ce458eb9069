"""Every computed figure of the dissertation, and table 3.1, redrawn from the equations, with simulated points on top.

Where a figure's quantity can be simulated, impacts through the scene stand on the formula's curve, by the energetic law and
resolved in time; elsewhere the printed equation is evaluated number by number. The table says how far they lie apart.
``--plot FOLDER`` writes one picture a figure, ``--plot FILE.pdf`` one page a figure; ``--only 2.24`` keeps to one.
"""

import sys
from pathlib import Path

from bristle_sim.cli import Scenario, main
from bristle_sim.comparison import Report
from bristle_sim.dissertation.figures import Selection


def run(selection: Selection) -> Report:
    """Compute the figures' curves and the simulated points on them."""
    from bristle_sim.dissertation.figures import figures_report

    return figures_report(selection)


def plots(report: Report, target: Path) -> None:
    """Draw one picture a figure, named after its number, or one page a figure."""
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
