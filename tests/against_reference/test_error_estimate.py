"""A run's estimate of its error holds, up to the instant that it names, against the same run at 1e-10."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

from against_reference.test_many_tools import tool_of
from bristle_sim.parameters import Tool
from bristle_sim.scene.simulate import simulate
from bristle_sim.scene.tool import tool_units
from bristle_sim.settings import Settings

FINE = 1e-10
"""Its error is some 1e-4 of the smallest estimate here."""


def faults(seed: int, bar: bool, accuracy: float) -> Iterator[str]:
    """Compare angles and rates, in the scene's units, at the end of a pass and at two instants on the way."""
    tool = tool_of(seed, bar)
    for turn in (1.5 * math.pi, *np.random.default_rng([seed, bar]).uniform(1.3, 4.0, 2).tolist()):
        run, fine = (
            simulate(tool, Settings(accuracy=each, hub_turn=turn)) for each in (accuracy, FINE)
        )
        rates = np.abs(run.rates[-1] - fine.rates[-1]).max() * tool_units(tool).time
        error = max(rates, np.abs(run.angles[-1] - fine.angles[-1]).max())
        estimate = run.cost.error_estimate
        assert estimate is not None
        if run.cost.holds_until is None and not (error <= estimate < math.inf):
            yield f"{seed}, {bar}, {accuracy:g}, turn {turn:.3f}: {error:.1e} instead of {estimate:.1e}"


@pytest.mark.parametrize(
    ("seed", "bar", "accuracy"),
    [
        (0, False, 1e-3),
        (40, False, 1e-3),
        (47, False, 1e-6),
        (1, False, 1e-6),
        (3, True, 1e-6),
        (4, True, 1e-4),
    ],
)
def test_a_tool(seed: int, bar: bool, accuracy: float) -> None:
    """Slip and approach that end together, within 1e-3; a release that is located beyond the last step that can push."""
    assert list(faults(seed, bar, accuracy)) == []


@pytest.mark.nightly
@pytest.mark.parametrize("accuracy", [1e-3, 1e-6])
def test_sixty_tools(accuracy: float) -> None:
    assert [
        each for seed in range(30) for bar in (False, True) for each in faults(seed, bar, accuracy)
    ] == []


def test_it_holds_for_the_strike_and_ends_with_the_chatter() -> None:
    """Hops on the workpart, each lower than the last, end within a finite time: no accuracy resolves the last of them."""
    run = simulate(Tool())
    strike = run.event_time("strike")
    end = run.cost.holds_until
    assert strike is not None
    assert end is not None
    assert strike < end < run.event_time("workpart release", last=True)  # type: ignore[operator]
    assert simulate(Tool(), stop_after="strike").cost.holds_until is None


def test_a_drag_ends_the_errors_of_the_taps_before_it() -> None:
    """Taps on the bar magnify the error a thousandfold; in contact, geometry and hub alone give angle and rate."""
    tool = Tool().replace(belt_damping_ratio=0.1, bar_restitution=0.2)
    run, fine = (
        simulate(tool, Settings(accuracy=each), stop_after="strike") for each in (1e-6, FINE)
    )
    error = np.abs(run.rates[-1] - fine.rates[-1]).max() * tool_units(tool).time
    # Since the drag only the errors of intervals have added up, each within the requested accuracy.
    assert error <= run.cost.error_estimate <= 1e-6  # type: ignore[operator]


def test_a_contact_in_the_rigid_limit_counts_its_difference_from_the_law() -> None:
    """At 1e-9 this difference, not an interval's error, is the strike's error; a contact of 1 ms stands for no law."""
    fine = Settings(accuracy=1e-9)
    law, limit = (
        simulate(tool, fine, stop_after="strike")
        for tool in (Tool(), Tool().replace(contact="compliant"))
    )
    error = np.abs(law.rates[-1] - limit.rates[-1]).max() * tool_units(Tool()).time
    assert law.cost.error_estimate < error <= limit.cost.error_estimate  # type: ignore[operator]
    lasting = Tool().replace(contact="compliant", contact_duration=1e-3)
    run = simulate(lasting, Settings(accuracy=1e-6), stop_after="strike")
    # A dozen intervals, each within the requested accuracy.
    assert run.cost.error_estimate <= 1.2e-5  # type: ignore[operator]
