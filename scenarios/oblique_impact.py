"""One oblique strike of a radial bristle: impulses, works and rebound beside the dissertation's closed forms.

The bristle is radial at the impact angle, its tip on the workpart, and turns at speed_ratio times the hub's speed. One
contact law is asked for; all three are shown side by side.
"""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bristle_sim.comparison import Report
from bristle_sim.parameters import Bristle, Contact, Hub, Strike, Surface
from bristle_sim.scenario_cli import Scenario, build, main
from bristle_sim.settings import Settings
from bristle_sim.studies.impacts import oblique_impact


def run(values: Mapping[str, Any]) -> Report:
    """Strike once, by the law asked for."""
    return oblique_impact(
        build(Hub, values),
        build(Bristle, values),
        build(Strike, values),
        build(Surface, values),
        build(Contact, values),
        build(Settings, values),
    )


def plot(report: Report, path: Path) -> None:
    """Velocities over the normal impulse, and the rebound ratio over impact angle and friction."""
    from bristle_sim.render.impact_figures import oblique_figure
    from bristle_sim.render.style import save_figure
    from bristle_sim.studies.impact_families import oblique_panels

    save_figure(oblique_figure(report.subject, oblique_panels(report.subject)), path)


def video(report: Report, path: Path) -> None:
    """The strike in ultra slow motion, compressed in the printed 50 us unless contact_duration says otherwise."""
    from bristle_sim.render.impact_video import impact_video
    from bristle_sim.studies.timed_contact import with_visible_contact

    impact_video(with_visible_contact(report.subject), path)


def series(report: Report) -> dict[str, Any]:
    """The contact in time, where the law resolves it."""
    return dict(report.subject.strikes[report.subject.law].contact.columns())


SCENARIO = Scenario(
    name="oblique_impact",
    question="One strike of a radial bristle: does the simulated impact follow the closed forms?",
    parts=(Hub, Bristle, Strike, Surface, Contact, Settings),
    run=run,
    plot=plot,
    video=video,
    series=series,
    without=("wire_diameter", "knee_position", "knee_angle_deg", "step", "hub_turn"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
