"""The whole pass: a bristle is held back by the bar, released, whipped onto the workpart and thrown back.

At t = 0 the bristle is radial, 90 degrees before the workpart's normal, and turns with the hub. Its release, flight,
strike and rebound are simulated and compared with the dissertation's formulas for cueing and impact.
"""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bristle_sim.comparison import Report
from bristle_sim.parameters import Bar, Belt, Bristle, Comparison, Contact, Hub, Tool, Workpart
from bristle_sim.scenario_cli import Scenario, build, build_tool, main
from bristle_sim.scenario_cli.scenario import series_of_pass
from bristle_sim.settings import Settings


def run(values: Mapping[str, Any]) -> Report:
    """Build the tool from the keys and simulate one pass."""
    from bristle_sim.studies.whole_pass import whole_pass

    return whole_pass(build_tool(values), build(Settings, values), with_reference=values["reference"] == "yes")


def plot(report: Report, path: Path) -> None:
    """Relative angle, rate and tip path, with the events marked."""
    from bristle_sim.render.pass_figure import pass_figure
    from bristle_sim.render.style import save_figure

    save_figure(pass_figure(report.subject.trajectory, report.subject.tool), path)


def video(report: Report, path: Path) -> None:
    """The tool in close-up, slow motion around the strike."""
    from bristle_sim.render.pass_video import pass_video

    pass_video(report.subject.trajectory, report.subject.tool, path)


SCENARIO = Scenario(
    name="cue_and_impact",
    question="From bar to rebound: does the cued tool do what the formulas say?",
    parts=(Hub, Belt, Bristle, Bar, Workpart, Contact, Tool, Settings, Comparison),
    run=run,
    plot=plot,
    video=video,
    series=series_of_pass,
    most={"wire_links": (16, "at most 16; the strike of more is beyond the 500,000 engine steps of a run")},
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
