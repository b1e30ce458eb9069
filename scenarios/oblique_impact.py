"""One oblique strike of a radial bristle: impulses, works and rebound compared with the dissertation's closed forms.

The bristle is radial at the impact angle, its tip on the workpart, and turns at speed_ratio times the hub's speed. One
contact law is requested; the table below compares all three.
"""

import sys

from bristle_sim.cli import Scenario, main
from bristle_sim.cli.scenario import figure_of_impact, film_of_impact, series_of_impact, study
from bristle_sim.parameters import WIRE_KEYS, Bristle, Contact, Hub, Strike, Surface
from bristle_sim.settings import Settings

SCENARIO = Scenario(
    name="oblique_impact",
    question="One strike of a radial bristle: does the simulated impact follow the closed forms?",
    parts=(Hub, Bristle, Strike, Surface, Contact, Settings),
    run=study("studies.impacts.oblique_impact"),
    plot=figure_of_impact,
    video=film_of_impact,
    series=series_of_impact,
    without=("wire_diameter", "knee_position", "knee_angle_deg", *WIRE_KEYS, "step", "hub_turn"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
