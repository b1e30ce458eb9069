"""Stronge's single pendulum: a rod on a fixed hinge strikes a rough surface with its end.

The rebound ratio and the impulses are compared with the closed form; the rod does not rebound at all where friction
reaches the tangent of the impact angle.
"""

import sys

from bristle_sim.cli import Scenario, main
from bristle_sim.cli.scenario import figure_of_impact, film_of_impact, series_of_impact, study
from bristle_sim.parameters import Contact, SinglePendulum, Surface
from bristle_sim.settings import Settings

SCENARIO = Scenario(
    name="single_pendulum",
    question="Stronge's single pendulum: does the simulated impact follow the closed form?",
    parts=(SinglePendulum, Surface, Contact, Settings),
    run=study("studies.impacts.single_pendulum"),
    plot=figure_of_impact,
    video=film_of_impact,
    series=series_of_impact,
    without=("step", "hub_turn"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
