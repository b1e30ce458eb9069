"""Force history: the curve that chapter 3 assumes compared with the contact force of a bristle in the scene.

Both have the same compressive impulse and compression time; the peak force is the finding. A measured force history takes
the curve's place with ``--set force_csv=FILE``, a file as an oscilloscope exports it: the contact is found on any clock and
above any zero, units are read from headings, ``time_column`` and ``force_column`` choose among several columns, and
``force_per_volt`` is the sensitivity of a force recorded as a voltage.
"""

import sys
from collections.abc import Mapping
from typing import Any

from bristle_sim.comparison import Report
from bristle_sim.parameters import WIRE_KEYS, Bristle, Hub, Surface
from bristle_sim.parameters.experiments import ForceHistory, Measurement
from bristle_sim.scenario_cli import Scenario, build, main
from bristle_sim.scenario_cli.scenario import figure, series_of_contact
from bristle_sim.settings import Settings


def run(values: Mapping[str, Any]) -> Report:
    """Strike with the curve's impulse in the curve's time."""
    from bristle_sim.studies.force_comparison import force_comparison

    return force_comparison(
        build(Hub, values),
        build(Bristle, values),
        build(Surface, values),
        build(ForceHistory, values),
        build(Measurement, values),
        build(Settings, values),
    )


SCENARIO = Scenario(
    name="force_history",
    question="Does a simulated contact push as the force curve of chapter 3 assumes?",
    parts=(Hub, Bristle, Surface, ForceHistory, Measurement, Settings),
    run=run,
    plot=figure("force_figure"),
    series=series_of_contact,
    without=("wire_diameter", "knee_position", "knee_angle_deg", *WIRE_KEYS, "step", "hub_turn"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
