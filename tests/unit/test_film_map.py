"""The map over contact stiffness and wire damping: its measures against closed forms, its nearest pair, and its store."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("zarr", reason="needs the extra sweep")

from bristle_sim import simulate
from bristle_sim.parameters import FilmGrid, Tool
from bristle_sim.settings import Settings
from bristle_sim.studies import film as module
from bristle_sim.studies.film import MEASURED, _answer, film, simulate_variant
from bristle_sim.studies.strike_point import crater_depth
from bristle_sim.theory.crater import CUTTING_FRICTION

BENT = Tool().replace(wire_links=2, knee_angle_deg=30.0)
SMALL = FilmGrid(durations=3, dampings=2, largest_damping=0.5, workers=1)
ROUGH = Settings(accuracy=1e-2)
"""Maps are compared with single cases of the same accuracy, whatever it is."""


@pytest.fixture(scope="module")
def two_links():
    return film(BENT, SMALL, ROUGH)


def test_a_stiff_contact_of_a_rigid_bristle_is_compressed_for_a_quarter_period():
    """Frictionless: k = (pi (1 + e*)/(2 T))^2/K_nn, so a quarter period is T/(1 + e*), and the spring takes v_n^2/(2 K_nn)."""
    smooth = Tool().replace(friction=0.0, contact="compliant")
    accuracy = Settings(accuracy=1e-6)
    found = simulate_variant(accuracy, smooth, contact_duration=1e-7)
    # In 0.07 us hub and bristle turn by 8e-5 rad, which changes the approach by as much over tan(gamma).
    assert found["compression_time"] == pytest.approx(1e-7 / 1.42, rel=1e-3)
    strike = simulate(
        smooth.replace(contact="energetic"), accuracy, stop_after="strike"
    ).first_contact("workpart")
    assert strike is not None
    approach = -strike.velocity_before[0]
    along = strike.velocity_before[1]
    inverse_mass = (0.027 * math.sin(strike.angles[0])) ** 2 / smooth.bristle.inertia_about_root
    lost = approach**2 / (2.0 * inverse_mass)
    expected = float(crater_depth(lost, CUTTING_FRICTION, math.atan2(approach, along), 7.1e-4))
    assert found["crater_depth"] == pytest.approx(expected, rel=1e-3)
    assert found["touches"] == 1.0


def test_the_map_has_the_measures_of_single_cases(two_links):
    found = two_links.subject
    assert found.dampings.tolist() == [0.0, 0.5]
    assert found.durations == pytest.approx([5e-5, math.sqrt(1.5) * 1e-4, 3e-4], rel=1e-12)
    tool = Tool().replace(wire_links=2, contact="compliant")
    keys = {"contact_duration": found.durations[1], "wire_damping_ratio": 0.5}
    alone = simulate_variant(ROUGH, tool, **keys)
    assert {name: each[1, 1] for name, each in found.results.items()} == alone
    map_in_json = two_links.extra["map"]
    assert np.array(map_in_json["crater_depth"]) == pytest.approx(
        found.results["crater_depth"], rel=0.0
    )


def test_the_nearest_pair_misses_least_of_the_measured_values(two_links):
    found = two_links.subject
    missed = {}
    for row, column in np.ndindex(2, 3):
        ratios = [found.results[name][row, column] / value for name, value in MEASURED.items()]
        missed[row, column] = math.hypot(*map(math.log, ratios))
    assert found.nearest == min(missed, key=missed.get)
    values = {each.name: each for each in two_links.quantities}
    assert values["nearest_contact_duration"].simulated == found.durations[found.nearest[1]]
    assert values["crater_depth"].printed == 1.3e-4
    assert two_links.answer.startswith(
        "No pair of the map explains all three facts; the nearest, a contact of"
    )
    assert "crater depth by energy" in two_links.answer  # no pair reaches it
    straight = two_links.extra["variants"][0]
    assert straight["crater_depth"] == values["crater_depth"].simulated


def test_frames_are_a_step_apart_and_blur_by_the_exposure(two_links):
    frames = two_links.extra["frames"]
    assert np.diff([each["time"] for each in frames]) == pytest.approx(5e-5, rel=1e-9)
    found = two_links.subject
    during = frames[0]["time"] + 1e-5 * np.linspace(-0.5, 0.5, 101)
    heights = found.run.at(during).tip[:, 1] + found.tool.workpart_depth
    # The tip falls evenly within 10 us, but for 1e-4 of it.
    assert frames[0]["tip_height"] == pytest.approx(
        heights.mean(), abs=1e-3 * float(np.ptp(heights))
    )


@pytest.mark.nightly
def test_an_interrupted_map_goes_on_from_its_store(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, two_links
):
    """The fourth case is interrupted; the next call computes it, and none of the first three."""
    kept = dataclasses.replace(SMALL, store=str(tmp_path))
    tool = BENT
    cases: list[tuple[float | None, float]] = []

    def noted(simulated: Tool, *arguments: Any, **options: Any) -> Any:
        if "stop_after" not in options:
            cases.append((simulated.contact.duration, simulated.bristle.bending_damping_ratio))
            if len(cases) == 4:
                raise KeyboardInterrupt
        return simulate(simulated, *arguments, **options)

    monkeypatch.setattr(module, "simulate", noted)
    with pytest.raises(KeyboardInterrupt):
        film(tool, kept, ROUGH)
    finished = cases[:3]
    cases[:] = [(None, 0.0)] * 4  # no further interruption
    again = film(tool, kept, ROUGH)
    assert again.quantities == two_links.quantities
    assert len(set(finished)) == 3
    assert not set(finished) & set(cases)


def test_a_pair_that_explains_all_three_facts_is_named():
    assert _answer(MEASURED, 1e-4, 0.3).startswith(
        "A contact of 100 µs and a damping ratio of 0.3 explain touches,"
    )


def test_a_map_without_a_strike_says_so():
    high = Tool().replace(wire_links=1, penetration=-0.01)
    with pytest.raises(ValueError, match="no pass of the map has a strike"):
        film(high, SMALL, Settings(accuracy=1e-3))
    with pytest.raises(
        ValueError, match=r"shortest_duration = 0\.0003: must be below longest_duration"
    ):
        FilmGrid(shortest=3e-4)
