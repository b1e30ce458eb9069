"""Crater depth: chapter 4's two estimates, reckoned twice, and what a contact simulated in time says.

Merchant's modified circle and the work-energy sum take force and motion from print. The bristle's contact in the scene
gives force, path and energy of one event, and from them depths that can be laid beside the measured 130 um.
"""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bristle_sim.comparison import Report
from bristle_sim.crater_parameters import Crater
from bristle_sim.parameters import Bristle, Hub
from bristle_sim.scenario_cli import Scenario, build, main
from bristle_sim.settings import Settings
from bristle_sim.studies.crater_study import crater_study


def run(values: Mapping[str, Any]) -> Report:
    """Cut once, by every estimate."""
    return crater_study(build(Hub, values), build(Bristle, values), build(Crater, values), build(Settings, values))


def plot(report: Report, path: Path) -> None:
    """Depth over the number of plies, the chip to scale, the crater in three dimensions, and all estimates."""
    from bristle_sim.render.crater_figure import crater_figure
    from bristle_sim.render.style import save_figure

    save_figure(crater_figure(report.subject), path)


def series(report: Report) -> dict[str, Any]:
    """The simulated contact in time."""
    if report.subject.contact is None:
        raise ValueError(report.subject.no_contact)
    return dict(report.subject.contact.record.columns())


SCENARIO = Scenario(
    name="crater_depth",
    question="How deep is the crater by chapter 4, and by the simulated contact?",
    parts=(Hub, Bristle, Crater, Settings),
    run=run,
    plot=plot,
    series=series,
    without=("wire_diameter", "knee_position", "knee_angle_deg", "step", "hub_turn"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
