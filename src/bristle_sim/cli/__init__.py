"""The command line of every scenario script.

It reads the values of the parameters, writes the table, JSON, CSV, picture and video, and returns
the exit status.
"""

from bristle_sim.cli.command import run_scenario as main
from bristle_sim.cli.scenario import Columns, Film, Picture, Scenario

__all__ = ["Columns", "Film", "Picture", "Scenario", "main"]
