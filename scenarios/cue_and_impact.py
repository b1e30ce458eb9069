"""The whole pass: a bristle is held back by the bar, released, whipped onto the workpart and thrown back.

At t = 0 the bristle is radial, 90 degrees before the workpart's normal, and turns with the hub. Its release, flight,
strike and rebound are simulated and compared with the dissertation's formulas for cueing and impact.
"""

import sys

from bristle_sim.cli import Scenario, main
from bristle_sim.cli.scenario import figure, film, series_of_pass, study
from bristle_sim.parameters import Bar, Belt, Bristle, Comparison, Contact, Hub, Tool, Workpart
from bristle_sim.settings import Settings

SCENARIO = Scenario(
    name="cue_and_impact",
    question="From bar to rebound: does the cued tool do what the formulas say?",
    parts=(Hub, Belt, Bristle, Bar, Workpart, Contact, Tool, Settings, Comparison),
    run=study("studies.whole_pass.whole_pass"),
    plot=figure("pass_figure", "trajectory", "tool"),
    video=film("tool_films.PassFilm", "trajectory", "tool"),
    series=series_of_pass,
    highest={"wire_links": (16, "at most 16; the strike of more is beyond the 500,000 engine steps of a run")},
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
