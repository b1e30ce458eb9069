"""Force history: the curve that chapter 3 assumes compared with the contact force of a bristle in
the scene.

Both have the same compressive impulse and compression time; the peak force is the result. A
measured force history replaces the curve with ``--set force_csv=FILE``, a file of columns. The
contact is found whatever the origin of time and the baseline of the force, and units are read from
headings. ``time_column`` and ``force_column`` choose among several columns, and ``force_per_volt``
is the sensitivity of a force recorded as a voltage.
"""

import sys

from bristle_sim.cli import Picture, Scenario, main
from bristle_sim.cli.impact import contact_series
from bristle_sim.comparison import Report
from bristle_sim.parameters import SHAPE_KEYS, Bristle, ForceHistory, Hub, Measurement, Surface
from bristle_sim.settings import Settings


def run(
    hub: Hub,
    bristle: Bristle,
    surface: Surface,
    history: ForceHistory,
    measurement: Measurement,
    settings: Settings,
) -> Report:
    """Compare the simulated contact force with the curve of chapter 3, or with a measured force."""
    from bristle_sim.studies.force_comparison import force_comparison

    return force_comparison(hub, bristle, surface, history, measurement, settings)


def plot(report: Report) -> Picture:
    """Draw the forces over time."""
    from bristle_sim.render.force_figures import force_figure

    return force_figure(report.subject)


SCENARIO = Scenario(
    name="force_history",
    question="Does a simulated contact push as the force curve of chapter 3 assumes?",
    run=run,
    plot=plot,
    series=contact_series,
    without=(*SHAPE_KEYS, "hub_turn"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
