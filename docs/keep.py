"""Make the results anew that take longer than a build of the site may: ``python docs/keep.py [SCENARIO ...]``, some minutes."""

import subprocess
import sys
from pathlib import Path

KEPT = {
    "tolerances": [],
    "film": [],
    "accuracy_cost": [],
    "hard_cases": ["--set", "effort=quick"],
    "dissertation_audit": [],
    "dissertation_figures": [],
}
"""Scenarios and their options."""


def keep(name: str, folder: Path) -> None:
    """Run a scenario and write its JSON, its printed lines and its picture.

    Raises:
        CalledProcessError: if it refuses its input.
    """
    plot = [] if name in ("hard_cases", "dissertation_audit", "dissertation_figures") else ["--plot", f"{name}.png"]
    options = [*KEPT[name], "--json", f"{name}.json", *plot]
    command = [sys.executable, "-m", "bristle_sim", name, *options]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        raise subprocess.CalledProcessError(done.returncode, command, done.stdout, done.stderr)
    (folder / f"{name}.txt").write_text(done.stdout, encoding="utf-8")


if __name__ == "__main__":
    for scenario in sys.argv[1:] or KEPT:
        keep(scenario, Path(__file__).parent / "kept")
