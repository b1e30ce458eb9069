"""Crater depth: chapter 4's two estimates, each computed in two ways, and the depth that follows
from a contact simulated over time.

Merchant's modified circle and the work-energy sum use the printed force and motion. The simulated
contact gives force, path and energy of a single event. All depths are compared with the measured
130 um.
"""

import sys

from bristle_sim.cli import Picture, Scenario, main
from bristle_sim.cli.impact import contact_series
from bristle_sim.comparison import Report
from bristle_sim.parameters import SHAPE_KEYS, Bristle, Crater, Hub
from bristle_sim.settings import Settings


def run(hub: Hub, bristle: Bristle, crater: Crater, settings: Settings) -> Report:
    """Estimate the crater's depth by chapter 4 and from the simulated contact."""
    from bristle_sim.studies.crater_study import crater_study

    return crater_study(hub, bristle, crater, settings)


def plot(report: Report) -> Picture:
    """Draw the depths from both estimates and from the simulated contact."""
    from bristle_sim.render.measurement_figures import crater_figure

    return crater_figure(report.subject)


SCENARIO = Scenario(
    name="crater_depth",
    question="How deep is the crater by chapter 4, and by the simulated contact?",
    run=run,
    plot=plot,
    series=contact_series,
    without=(*SHAPE_KEYS, "hub_turn"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
