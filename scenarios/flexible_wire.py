"""The wire that bends: what does the model of a rigid bristle overstate?

A straight radial wire of links rotates without bending until its tip strikes. The stiffness of the
contact would keep the rigid bristle in contact for contact_duration. A strike of 50 us is over
before the bending wave reaches the root.
"""

import sys

from bristle_sim.cli import Columns, Film, Picture, Scenario, main
from bristle_sim.comparison import Report
from bristle_sim.parameters import Belt, Bristle, Comparison, ContactStiffness, Hub, Strike, Surface
from bristle_sim.settings import Settings


def run(
    hub: Hub,
    belt: Belt,
    bristle: Bristle,
    strike: Strike,
    surface: Surface,
    stiffness: ContactStiffness,
    settings: Settings,
    compared: Comparison,
) -> Report:
    """Compare the strike of a wire of links with the beam and with the rigid bristle."""
    from bristle_sim.studies.flexible_wire import flexible_wire

    return flexible_wire(
        hub,
        belt,
        bristle,
        strike,
        surface,
        stiffness,
        settings,
        with_reference=compared.reference == "yes",
    )


def plot(report: Report) -> Picture:
    """Draw the force over time, and the effects of contact stiffness and number of links."""
    from bristle_sim.render.wire_pictures import wire_figure
    from bristle_sim.studies.flexible_wire import wire_study

    return wire_figure(report.subject, wire_study(report.subject.strike))


def film(report: Report, **size: int) -> Film:
    """Film the bending wave in the wire."""
    from bristle_sim.render.wire_pictures import WireFilm

    return WireFilm(report.subject, **size)


def series(report: Report) -> Columns:
    """Return the history of the contact."""
    return dict(report.subject.wire.contact.columns())


SCENARIO = Scenario(
    name="flexible_wire",
    question="One strike of a wire that bends: what does the rigid bristle overstate?",
    run=run,
    plot=plot,
    film=film,
    series=series,
    without=("knee_position", "knee_angle_deg", "hub_turn"),
    highest={
        "wire_links": (32, "at most 32, whose strike takes 2 s; a strike of 64 does not finish")
    },
    defaults={
        "wire_links": (8, "chosen: impulse and peak force are within 0.3 % of those of more links"),
        "friction": (
            0.0,
            "chosen: the stiffness is that of a frictionless contact of the given duration",
        ),
        "reference": ("yes", "chosen: one strike takes the independent solution little time"),
    },
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
