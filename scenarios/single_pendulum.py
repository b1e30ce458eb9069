"""Stronge's single pendulum: a rod on a fixed hinge strikes a rough surface with its end.

The rebound ratio and the impulses are compared with the closed form. If friction reaches the
tangent of the impact angle, the rod does not rebound.
"""

import sys

from bristle_sim.cli import Scenario, main
from bristle_sim.cli.impact import film, plot, series
from bristle_sim.comparison import Report
from bristle_sim.parameters import Contact, SinglePendulum, Surface
from bristle_sim.settings import Settings


def run(pendulum: SinglePendulum, surface: Surface, contact: Contact, settings: Settings) -> Report:
    """Let the rod strike, and compare the impact with the closed form."""
    from bristle_sim.studies.impacts import single_pendulum

    return single_pendulum(pendulum, surface, contact, settings)


SCENARIO = Scenario(
    name="single_pendulum",
    question="Stronge's single pendulum: does the simulated impact follow the closed form?",
    run=run,
    plot=plot,
    film=film,
    series=series,
    without=("hub_turn",),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
