"""Tools that ``cue_map`` finds and writes run in every other scenario that takes a tool, in ``compare`` and on the page.

The scripts judge themselves: status 0 means that simulation, reference and balances agree within their tolerances.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import bristle_sim as bs
from bristle_sim.cli import command
from bristle_sim.cli.explore.bench import run_of, typed_of
from bristle_sim.cli.scenario import main_scenario

EVERYDAY = (2500.0, 40.0, 1.0)
"""Hub speed, rpm, length, mm, and belt stiffness over the default; the bar stands at 112 degrees."""

RNG = np.random.default_rng(1)
OTHER_TOOLS = [
    (3400.0, 30.0, 1.0),
    *(
        (RNG.uniform(1800.0, 3800.0), RNG.uniform(25.0, 40.0), RNG.uniform(0.8, 2.0))
        for _ in range(18)
    ),
]

OTHERS = {
    "cue_and_impact": ["--set", "reference=yes"],
    "cue_timing": [],
    "whole_tool": [],
    "inertia_driven": [],
    "neighbours": ["--set", "search=no", "--set", "pitch_deg=40"],
    "oblique_impact": [],
    "bent_bristles": [],
    "crater_depth": [],
    "force_history": [],
    "flexible_wire": ["--set", "wire_links=2"],
}


@pytest.mark.parametrize(
    ("speed", "length", "stiffness"),
    [EVERYDAY, *(pytest.param(*each, marks=pytest.mark.nightly) for each in OTHER_TOOLS)],
)
def test_a_tool_that_was_found_runs_everywhere(
    speed: float,
    length: float,
    stiffness: float,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    file = str(tmp_path / "found.toml")
    page = tmp_path / "page.html"
    keys = (
        f"hub_speed={speed}rpm",
        f"bristle_length={length}mm",
        f"belt_stiffness={stiffness * 0.0234913}",
    )
    wanted = [word for key in (*keys, "reference=no", "accuracy=1e-7") for word in ("--set", key)]
    assert command.main(["cue_map", *wanted, "--write-tool", file]) == 0
    capsys.readouterr()
    for name, options in OTHERS.items():
        report = ["--report", str(page)] if name == "cue_and_impact" else []
        status = command.main([name, "--parameters", file, *options, *report])
        printed = capsys.readouterr()
        assert status == 0, (name, printed)
        if name == "cue_and_impact":
            assert "no bar touches" not in printed.out
            assert ", radial, " in printed.out.replace("\n ", "")
        if name == "crater_depth":
            assert "no chip" not in printed.out  # the cut keeps its own friction
    assert page.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert command.main(["compare", file, file]) == 0
    scenario = main_scenario()
    found = run_of(scenario, typed_of(bs.read_tool(file), scenario), {})
    assert ", radial, " in found["answer"]
