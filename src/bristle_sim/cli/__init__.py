"""The command line that every scenario script shares: keys, table, JSON, CSV, picture, video and exit status."""

from bristle_sim.cli.main import main
from bristle_sim.cli.scenario import Columns, Scenario

__all__ = ["Columns", "Scenario", "main"]
