"""One oblique strike of a radial bristle: impulses, works and rebound compared with the
dissertation's closed forms.

The bristle stands radially at the impact angle, with its tip on the workpart, and turns at
speed_ratio times the hub's speed. The report states the results of the requested contact law; a
further table compares all three laws.
"""

import sys

from bristle_sim.cli import Scenario, main
from bristle_sim.cli.impact import film, plot, series
from bristle_sim.comparison import Report
from bristle_sim.parameters import SHAPE_KEYS, Bristle, Contact, Hub, Strike, Surface
from bristle_sim.settings import Settings


def run(
    hub: Hub,
    bristle: Bristle,
    strike: Strike,
    surface: Surface,
    contact: Contact,
    settings: Settings,
) -> Report:
    """Simulate one strike, and compare it with the closed forms."""
    from bristle_sim.studies.impacts import oblique_impact

    return oblique_impact(hub, bristle, strike, surface, contact, settings)


SCENARIO = Scenario(
    name="oblique_impact",
    question="One strike of a radial bristle: does the simulated impact follow the closed forms?",
    run=run,
    plot=plot,
    film=film,
    series=series,
    without=(*SHAPE_KEYS, "hub_turn"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
