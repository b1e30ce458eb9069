"""Stronge's double pendulum: two hinged rods, the lower end strikes; slip stops, sticks or reverses on the way.

Final rates, impulses and the kinetic-energy ratio are compared with the closed form, for any ratio of the rods' masses. The
engine's own contact gains energy here; the energetic law never does.
"""

import sys

from bristle_sim.cli import Scenario, main
from bristle_sim.cli.scenario import figure_of_impact, film_of_impact, series_of_impact, study
from bristle_sim.parameters import Contact, DoublePendulum, Surface
from bristle_sim.settings import Settings

SCENARIO = Scenario(
    name="double_pendulum",
    question="Stronge's double pendulum: does the simulated impact follow the closed form, whatever the masses?",
    parts=(DoublePendulum, Surface, Contact, Settings),
    run=study("studies.impacts.double_pendulum"),
    plot=figure_of_impact,
    video=film_of_impact,
    series=series_of_impact,
    defaults={
        "friction": (0.5, "Zhang 2020, fig. 2.28: the second of its three curves"),
        "restitution": (0.5, "Zhang 2020, fig. 2.28: e*"),
    },
    without=("step", "hub_turn"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
