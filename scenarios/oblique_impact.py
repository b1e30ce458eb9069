"""One oblique strike of a radial bristle: impulses, works and rebound compared with the dissertation's closed forms.

The bristle is radial at the impact angle, its tip on the workpart, and turns at speed_ratio times the hub's speed. One
contact law is requested; the table below compares all three.
"""

import sys

from bristle_sim.cli import Columns, Film, Picture, Scenario, main
from bristle_sim.comparison import Report
from bristle_sim.parameters import SHAPE_KEYS, Bristle, Contact, Hub, Strike, Surface
from bristle_sim.settings import Settings


def run(hub: Hub, bristle: Bristle, strike: Strike, surface: Surface, contact: Contact, settings: Settings) -> Report:
    """Strike once, and compare the impact with the closed forms."""
    from bristle_sim.studies.impacts import oblique_impact

    return oblique_impact(hub, bristle, strike, surface, contact, settings)


def plot(report: Report) -> Picture:
    """Draw the impact over its normal impulse."""
    from bristle_sim.render.impact_figure import impact_figure

    return impact_figure(report.subject)


def film(report: Report, **size: int) -> Film:
    """Film the impact in ultra slow motion, compressed in the printed 50 us unless contact_duration says otherwise."""
    from bristle_sim.render.impact_film import ImpactFilm
    from bristle_sim.studies.timed_contact import with_visible_contact

    return ImpactFilm(with_visible_contact(report.subject), **size)


def series(report: Report) -> Columns:
    """Return the impact in time, where its law resolves it."""
    return dict(report.subject.strikes[report.subject.law].contact.columns())


SCENARIO = Scenario(
    name="oblique_impact",
    question="One strike of a radial bristle: does the simulated impact follow the closed forms?",
    run=run,
    plot=plot,
    film=film,
    series=series,
    without=("wire_diameter", *SHAPE_KEYS, "hub_turn"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
