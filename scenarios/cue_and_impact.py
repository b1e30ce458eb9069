"""The whole pass: a bristle is held back by the bar, released, whipped onto the workpart and thrown back.

At t = 0 the bristle is radial, 90 degrees before the workpart's normal, and turns with the hub. Its release, flight,
strike and rebound are simulated and compared with the dissertation's formulas for cueing and impact.
"""

import sys

from bristle_sim.cli import Columns, Film, Picture, Scenario, main
from bristle_sim.comparison import Report
from bristle_sim.parameters import Comparison, Tool
from bristle_sim.settings import Settings


def run(tool: Tool, settings: Settings, compared: Comparison) -> Report:
    """Simulate the pass, and compare it with the formulas."""
    from bristle_sim.studies.whole_pass import whole_pass

    return whole_pass(tool, settings, with_reference=compared.reference == "yes")


def plot(report: Report) -> Picture:
    """Draw the motion, and the retraction over time."""
    from bristle_sim.render.pass_figure import pass_figure

    return pass_figure(report.subject.trajectory, report.subject.tool)


def film(report: Report, **size: int) -> Film:
    """Film the pass."""
    from bristle_sim.render.tool_films import pass_film

    return pass_film(report.subject.trajectory, report.subject.tool, **size)


def series(report: Report) -> Columns:
    """Return the simulated motion."""
    return dict(report.subject.trajectory.columns())


SCENARIO = Scenario(
    name="cue_and_impact",
    question="From bar to rebound: does the cued tool do what the formulas say?",
    run=run,
    plot=plot,
    film=film,
    series=series,
    in_arrays=True,
    highest={
        "wire_links": (
            16,
            "at most 16; the strike of more is beyond the 500,000 engine steps of a run",
        )
    },
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
