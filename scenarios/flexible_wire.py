"""The wire that bends: what does the rigid bristle overstate?

A straight radial wire of links turns without bending until its tip strikes. The contact has a finite stiffness, that which would keep
the rigid bristle in touch for contact_duration; a strike of 50 us is over before the bending wave reaches the root.
"""

import sys
from pathlib import Path
from typing import Any

from bristle_sim.cli import Scenario, main
from bristle_sim.cli.scenario import film, study
from bristle_sim.comparison import Report
from bristle_sim.parameters import Belt, Bristle, Comparison, ContactStiffness, Hub, Strike, Surface
from bristle_sim.settings import Settings


def plot(report: Report, path: Path) -> None:
    """Draw the force over time, and what contact stiffness and number of links change."""
    from bristle_sim.render.style import save_figure
    from bristle_sim.render.wire_figure import wire_figure
    from bristle_sim.studies.flexible_wire import wire_study

    save_figure(wire_figure(report.subject, wire_study(report.subject.strike)), path)


def series(report: Report) -> dict[str, Any]:
    """Return the contact in time."""
    return dict(report.subject.wire.contact.columns())


SCENARIO = Scenario(
    name="flexible_wire",
    question="One strike of a wire that bends: what does the rigid bristle overstate?",
    parts=(Hub, Belt, Bristle, Strike, Surface, ContactStiffness, Settings, Comparison),
    run=study("studies.flexible_wire.flexible_wire"),
    plot=plot,
    video=film("wire_film.WireFilm"),
    series=series,
    without=("knee_position", "knee_angle_deg", "step", "hub_turn"),
    highest={"wire_links": (32, "at most 32, whose strike takes 2 s; a strike of 64 does not finish")},
    defaults={
        "wire_links": (8, "chosen: impulse and peak force are within 0.3 % of those of more links"),
        "friction": (0.0, "chosen: the stiffness is that of a frictionless contact of the given duration"),
        "reference": ("yes", "chosen: one strike takes the independent solution little time"),
    },
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
