"""The command line of every scenario script.

It reads the values of the parameters and writes the table, JSON, CSV, picture, video and exit
status.
"""

from bristle_sim.cli.command import run_scenario as main
from bristle_sim.cli.scenario import Columns, Film, Picture, Scenario

__all__ = ["Columns", "Film", "Picture", "Scenario", "main"]
