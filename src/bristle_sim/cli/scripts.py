"""The scripts of the scenarios, and the scenario of each script.

A wheel has the folder ``scenarios/`` as ``bristle_sim/scenarios``; a work tree has it beside
``src``.
"""

from __future__ import annotations

import runpy
from pathlib import Path

from bristle_sim.cli.scenario import Scenario


def script_paths() -> dict[str, Path]:
    """Return the scripts of the scenarios by name, from the installed package or the work tree."""
    package = Path(__file__).parents[1]
    folder = package / "scenarios"
    if not folder.is_dir():
        folder = package.parents[1] / "scenarios"
    return {path.stem: path for path in sorted(folder.glob("*.py"))}


def load_scenario(path: Path) -> Scenario:
    """Return the scenario of a script."""
    scenario = runpy.run_path(str(path), run_name=f"bristle_sim.scenarios.{path.stem}")["SCENARIO"]
    assert isinstance(scenario, Scenario)
    return scenario


def main_scenario() -> Scenario:
    """Return the scenario of the whole pass, which the further commands use."""
    return load_scenario(script_paths()["cue_and_impact"])
