"""Make the results anew that take longer than a build of the site may: ``python docs/keep.py [SCENARIO ...]``, some minutes.

README's sentences on the cost of a pass are made anew with those of ``accuracy_cost``.
"""

import json
import re
import subprocess
import sys
from pathlib import Path

DOCS = Path(__file__).parent

KEPT = ("film", "accuracy_cost", "hard_cases", "dissertation_audit", "dissertation_figures")
DRAWN = ("film", "accuracy_cost")
"""Scenarios whose results are kept, and those of them with a picture."""


def keep(name: str, folder: Path) -> None:
    """Run a scenario and write its JSON, its printed lines and its picture.

    Raises:
        CalledProcessError: if it refuses its input.
    """
    plot = ["--plot", f"{name}.png"] if name in DRAWN else []
    command = [sys.executable, "-m", "bristle_sim", name, "--json", f"{name}.json", *plot]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        raise subprocess.CalledProcessError(done.returncode, command, done.stdout, done.stderr)
    (folder / f"{name}.txt").write_text(done.stdout, encoding="utf-8")


def costs() -> str:
    """Return README's sentences on the cost of a pass, from the kept results."""
    curves = json.loads((DOCS / "kept" / "accuracy_cost.json").read_text(encoding="utf-8"))[
        "curves"
    ]
    passes = [each for each in curves if each["case"] == "whole_pass" and each["error"] is not None]
    own = {each["setting"]: each for each in passes if each["method"] == "bristle_sim simulate"}
    asked = [
        f"{1e3 * own[f'accuracy={accuracy}']['cpu_s']:.0f}"
        for accuracy in ("0.001", "1e-06", "1e-10")
    ]
    reference = [each for each in passes if each["method"] == "scipy dop853"]
    ours, theirs = (
        min(each["cpu_s"] for each in found if each["error"] <= 1e-6)
        for found in (own.values(), reference)
    )
    return (
        f"A whole pass to the strike costs {asked[0]}, {asked[1]} and {asked[2]} ms of CPU at 1e-3, 1e-6 and 1e-10.\n"
        f"An error below 1e-6 costs {1e3 * ours:.0f} ms, by the SciPy reference {theirs / ours:.0f} times as much."
    )


if __name__ == "__main__":
    for scenario in sys.argv[1:] or KEPT:
        keep(scenario, DOCS / "kept")
    readme = DOCS.parent / "README.md"
    written = re.sub(
        r"A whole pass to the strike costs .*\n.* times as much\.",
        costs(),
        readme.read_text(encoding="utf-8"),
    )
    readme.write_text(written, encoding="utf-8")
