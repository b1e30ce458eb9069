"""Finds the scripts of the scenarios, and loads the scenario of a script.

An installed package has the scripts in ``bristle_sim/scenarios``. A work tree has them in
``scenarios/`` beside ``src``.
"""

from __future__ import annotations

import runpy
from pathlib import Path

from bristle_sim.cli.scenario import Scenario


def script_paths() -> dict[str, Path]:
    """Return the paths of the scenarios' scripts by name, in the installed package or the work
    tree.
    """
    package = Path(__file__).parents[1]
    folder = package / "scenarios"
    if not folder.is_dir():
        folder = package.parents[1] / "scenarios"
    return {path.stem: path for path in sorted(folder.glob("*.py"))}


def load_scenario(path: Path) -> Scenario:
    """Execute the script at a path, and return its scenario."""
    scenario = runpy.run_path(str(path), run_name=f"bristle_sim.scenarios.{path.stem}")["SCENARIO"]
    assert isinstance(scenario, Scenario)
    return scenario


def main_scenario() -> Scenario:
    """Return the scenario of the whole pass, which the commands such as ``compare`` use."""
    return load_scenario(script_paths()["cue_and_impact"])
