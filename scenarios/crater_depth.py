"""Crater depth: chapter 4's two estimates, each computed in two ways, and what a contact simulated in time gives.

Merchant's modified circle and the work-energy sum take force and motion from print. The bristle's contact in the scene
gives force, path and energy of one event, and from them depths that can be compared with the measured 130 um.
"""

import sys

from bristle_sim.cli import Scenario, main
from bristle_sim.cli.scenario import figure, series_of_contact, study
from bristle_sim.parameters import WIRE_KEYS, Bristle, Hub
from bristle_sim.parameters.experiments import Crater
from bristle_sim.settings import Settings

SCENARIO = Scenario(
    name="crater_depth",
    question="How deep is the crater by chapter 4, and by the simulated contact?",
    parts=(Hub, Bristle, Crater, Settings),
    run=study("studies.crater_study.crater_study"),
    plot=figure("crater_figure"),
    series=series_of_contact,
    without=("wire_diameter", "knee_position", "knee_angle_deg", *WIRE_KEYS, "step", "hub_turn"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
