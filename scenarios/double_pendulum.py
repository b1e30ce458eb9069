"""Stronge's double pendulum: the lower end of two hinged rods strikes a surface, and its slip
continues, stops or reverses during the impact.

Final rates, impulses and the ratio of kinetic energies are compared with the closed form, for any
mass ratio of the rods. The engine's own contact gains energy here; the energetic law never does.
"""

import sys

from bristle_sim.cli import Scenario, main
from bristle_sim.cli.impact import film, plot, series
from bristle_sim.comparison import Report
from bristle_sim.parameters import Contact, DoublePendulum, Surface
from bristle_sim.settings import Settings


def run(pendulum: DoublePendulum, surface: Surface, contact: Contact, settings: Settings) -> Report:
    """Let the lower rod strike, and compare the impact with the closed form."""
    from bristle_sim.studies.impacts import double_pendulum

    return double_pendulum(pendulum, surface, contact, settings)


SCENARIO = Scenario(
    name="double_pendulum",
    question="Stronge's double pendulum: does the simulated impact follow the closed form, whatever the masses?",
    run=run,
    plot=plot,
    film=film,
    series=series,
    without=("hub_turn",),
    defaults={
        "friction": (0.5, "Zhang 2020, fig. 2.28: the second of its three curves"),
        "restitution": (0.5, "Zhang 2020, fig. 2.28: e*"),
    },
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
