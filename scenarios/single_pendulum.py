"""Stronge's single pendulum: a rod on a fixed hinge strikes a rough surface with its end.

The rebound ratio and the impulses are laid beside the closed form; the rod does not rebound at all where friction
reaches the tangent of the impact angle.
"""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bristle_sim.comparison import Report
from bristle_sim.parameters import Contact, SinglePendulum, Surface
from bristle_sim.scenario_cli import Scenario, build, main
from bristle_sim.settings import Settings
from bristle_sim.studies.impacts import single_pendulum


def run(values: Mapping[str, Any]) -> Report:
    """Strike once, by the law asked for."""
    return single_pendulum(
        build(SinglePendulum, values), build(Surface, values), build(Contact, values), build(Settings, values)
    )


def plot(report: Report, path: Path) -> None:
    """Velocities over the normal impulse, and the rebound ratio over impact angle and friction."""
    from bristle_sim.render.impact_figures import single_pendulum_figure
    from bristle_sim.render.style import save_figure
    from bristle_sim.studies.impact_families import single_pendulum_panels

    save_figure(single_pendulum_figure(report.subject, single_pendulum_panels(report.subject)), path)


def video(report: Report, path: Path) -> None:
    """The strike in ultra slow motion, compressed in the printed 50 us unless contact_duration says otherwise."""
    from bristle_sim.render.impact_video import impact_video
    from bristle_sim.studies.timed_contact import with_visible_contact

    impact_video(with_visible_contact(report.subject), path)


def series(report: Report) -> dict[str, Any]:
    """The contact in time, where the law resolves it."""
    return dict(report.subject.strikes[report.subject.law].contact.columns())


SCENARIO = Scenario(
    name="single_pendulum",
    question="Stronge's single pendulum: does the simulated impact follow the closed form?",
    parts=(SinglePendulum, Surface, Contact, Settings),
    run=run,
    plot=plot,
    video=video,
    series=series,
    without=("step", "hub_turn"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
