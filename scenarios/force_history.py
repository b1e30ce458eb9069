"""Force history: the curve that chapter 3 assumes compared with the contact force of a bristle in the scene.

Both have the same compressive impulse and compression time; the peak force is the finding. A measured force history takes
the curve's place with ``--set force_csv=FILE``, a file as an oscilloscope exports it: the contact is found on any clock and
above any zero, units are read from headings, ``time_column`` and ``force_column`` choose among several columns, and
``force_per_volt`` is the sensitivity of a force recorded as a voltage.
"""

import sys

from bristle_sim.cli import Scenario, main
from bristle_sim.cli.scenario import figure, series_of_contact, study
from bristle_sim.parameters import WIRE_KEYS, Bristle, Hub, Surface
from bristle_sim.parameters.experiments import ForceHistory, Measurement
from bristle_sim.settings import Settings

SCENARIO = Scenario(
    name="force_history",
    question="Does a simulated contact push as the force curve of chapter 3 assumes?",
    parts=(Hub, Bristle, Surface, ForceHistory, Measurement, Settings),
    run=study("studies.force_comparison.force_comparison"),
    plot=figure("force_figure"),
    series=series_of_contact,
    without=("wire_diameter", "knee_position", "knee_angle_deg", *WIRE_KEYS, "step", "hub_turn"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
