"""The wire that bends: what does the rigid bristle overstate?

A straight radial wire of links turns as one when its end strikes. The contact has a finite stiffness, that which would keep
the rigid bristle in touch for contact_duration; a strike of 50 us is over before the root knows of it.
"""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bristle_sim.comparison import Report
from bristle_sim.parameters import Belt, Bristle, Comparison, ContactStiffness, Hub, Strike, Surface
from bristle_sim.scenario_cli import Scenario, build, main
from bristle_sim.settings import Settings


def run(values: Mapping[str, Any]) -> Report:
    """Strike with the wire and with the rigid bristle."""
    from bristle_sim.studies.flexible_wire import flexible_wire

    return flexible_wire(
        build(Hub, values),
        build(Belt, values),
        build(Bristle, values),
        build(Strike, values),
        build(Surface, values),
        build(ContactStiffness, values),
        build(Settings, values),
        with_reference=values["reference"] == "yes",
    )


def plot(report: Report, path: Path) -> None:
    """Draw the force over time, and what contact stiffness and number of links change."""
    from bristle_sim.render.style import save_figure
    from bristle_sim.render.wire_figure import wire_figure
    from bristle_sim.studies.flexible_wire import wire_study

    save_figure(wire_figure(report.subject, wire_study(report.subject.strike)), path)


def video(report: Report, path: Path) -> None:
    """Film the bending wave that runs up the wire, in slow motion."""
    from bristle_sim.render.wire_video import wire_video

    wire_video(report.subject, path)


def series(report: Report) -> dict[str, Any]:
    """Return the contact in time."""
    return dict(report.subject.wire.contact.columns())


SCENARIO = Scenario(
    name="flexible_wire",
    question="One strike of a wire that bends: what does the rigid bristle overstate?",
    parts=(Hub, Belt, Bristle, Strike, Surface, ContactStiffness, Settings, Comparison),
    run=run,
    plot=plot,
    video=video,
    series=series,
    without=("knee_position", "knee_angle_deg", "step", "hub_turn"),
    most={"wire_links": (32, "at most 32, whose strike takes 2 s; that of 64 comes to no end")},
    defaults={
        "wire_links": (8, "chosen: impulse and peak force are within 0.3 % of those of more links"),
        "friction": (0.0, "chosen: the stiffness is that of a frictionless contact of the given duration"),
        "reference": ("yes", "chosen: one strike takes the independent solution little time"),
    },
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
