"""Where the bar must stand, against the independent solution, a closed form and synthetic strikes."""

import logging
import math
import re
from collections.abc import Callable, Mapping

import numpy as np
import pytest

from bristle_sim.parameters import Bar, Belt, Hub, Tool
from bristle_sim.settings import Settings
from bristle_sim.studies.bar_search import (
    STEP,
    Place,
    Strikes,
    fastest_place,
    placed,
    radial_place,
    strikes_of,
)
from bristle_sim.studies.cue_map import MapGrid, cue_map, position_map
from bristle_sim.studies.strike_point import STRIKE_UNITS, NotCuedError, strike_of_keys
from bristle_sim.studies.sweep_point import FAILURE

FINE = Settings(accuracy=1e-9)


@pytest.fixture(scope="module")
def radial() -> Place:
    return radial_place(Tool(), *strikes_of(Tool(), FINE))


def test_the_operating_point(radial: Place):
    """Two independent computations gave 68.145 degrees and 878.7 rad/s, and with the bar's distance 51.20 and 20.54 mm."""
    bar = placed(Tool(), radial.direction).bar
    assert bar is not None
    assert math.degrees(radial.direction) == pytest.approx(68.145, abs=5e-4)
    assert bar.horizontal == pytest.approx(0.05120, abs=5e-6)
    assert bar.vertical == pytest.approx(0.02054, abs=5e-6)
    assert radial.strike["relative_speed_at_contact"] == pytest.approx(878.7, abs=0.05)


def test_the_progress_says_that_simulations_check_the_passes(caplog: pytest.LogCaptureFixture):
    """They take most of the time, after the last passes in arrays are finished."""
    caplog.set_level(logging.INFO, "bristle_sim")
    cue_map(Tool(), Settings(), with_reference=False)
    messages = caplog.messages
    first = messages.index("single simulations check the passes")
    assert "100 % of the passes finished" in messages[:first]
    assert messages[first:].count("single simulations check the passes") == 9


def test_the_answer_names_the_place_and_the_strike_where_the_bar_stands():
    """68.145 degrees, 51.20 and 20.54 mm by two independent computations; print is 2.74 degrees short of radial."""
    answer = cue_map(Tool(), Settings(), with_reference=False).answer
    assert answer.startswith(
        "For a radial strike the bar must stand at 68.14° from the workpart's normal, 51.20 mm before the hub's axis and 20.54 mm below it; there"
        " the tip is also fastest, 38 m/s. In its present place, at 65.93° as printed, the strike is 2.74° short of radial; the time-domain simulation agrees to "
    )
    beyond = cue_map(
        Tool(bar=Bar(horizontal=0.0515, vertical=0.0198)), Settings(), with_reference=False
    ).answer
    assert re.search(
        r"In its present place, at 68\.97°, the strike is [\d.]+° beyond radial; the time-domain simulation",
        beyond,
    )
    away = cue_map(
        Tool(bar=Bar(horizontal=0.01, vertical=0.05425)), Settings(), with_reference=False
    ).answer
    assert "there is no cued strike: " in away


@pytest.mark.parametrize(
    ("tool", "words"),
    [
        (
            Tool(belt=Belt(stiffness=0.00041)),
            "no direction at this distance cues the bristle; refused: it folds back",
        ),
        (
            Tool(belt=Belt(damping_ratio=1.0)),
            "no direction at this distance gives a radial strike; .* lag of",
        ),
        (Tool(hub=Hub(speed=0.0)), "no direction at this distance cues the bristle"),
        (Tool(bar=Bar(horizontal=0.056)), "bar_horizontal, bar_vertical: tip radius = "),
    ],
)
def test_one_line_says_why_there_is_no_radial_strike(tool: Tool, words: str):
    """A hub at rest moves nothing, a critically damped bristle never gets there, a soft belt gives way altogether."""
    with pytest.raises(ValueError, match=words) as refusal:
        radial_place(tool, *strikes_of(tool, Settings(accuracy=1e-4)))
    assert "\n" not in str(refusal.value)


def by_direction(
    lag: Callable[[float], float], speed: Callable[[float], float] = math.cos
) -> Strikes:
    """A strike that depends on the bar's direction alone, in degrees and rad."""

    def strikes(directions: np.ndarray) -> Mapping[str, np.ndarray]:
        return {
            "lag_deg_at_contact": np.array([lag(math.degrees(each)) for each in directions]),
            "tip_speed_at_contact": np.array([speed(each) for each in directions]),
            FAILURE: np.full(len(directions), "", dtype=object),
        }

    return strikes


@pytest.mark.parametrize("root", [0.4, 12.0, 67.0, 178.0])
def test_a_root_is_found_wherever_it_is(root: float):
    found = radial_place(
        Tool(), by_direction(lambda direction: (root - direction) ** 3 + root - direction), STEP
    )
    assert math.degrees(found.direction) == pytest.approx(root, abs=1e-8)


def test_a_jump_or_a_rise_is_no_root():
    """As the lag falls with the direction, a rise is where the strike has jumped to another swing."""
    with pytest.raises(NotCuedError, match=r"at (69\.9\d*|70) deg the lag jumps"):
        radial_place(
            Tool(), by_direction(lambda direction: 1.0 if direction < 70.0 else -1.0), STEP
        )
    found = radial_place(
        Tool(),
        by_direction(lambda direction: math.sin(math.radians(8.0 * (direction - 67.5)))),
        STEP,
    )
    assert abs(math.degrees(found.direction) - 67.5) == pytest.approx(22.5, abs=1e-8)


@pytest.mark.parametrize("peak", [0.3, 1.15, 2.9])
def test_a_maximum_is_found_uphill(peak: float):
    speeds = by_direction(lambda _: 0.0, lambda direction: 2.0 - (direction - peak) ** 2)
    assert fastest_place(speeds, STEP, 1.2).direction == pytest.approx(peak, abs=1e-5)


def test_a_wire_with_a_knee_is_searched_by_the_scene():
    """A knee of a tenth of a degree at the middle moves the tip by 1e-3 of its length, and the direction by some of that."""
    tool = Tool().replace(knee_angle_deg=0.1)
    strikes, step = strikes_of(tool, Settings(accuracy=1e-5))
    found = radial_place(tool, strikes, step)
    straight = radial_place(Tool(), *strikes_of(Tool(), FINE))
    assert found.direction == pytest.approx(straight.direction, abs=0.01)


def test_maps_hold_the_passes_at_their_positions():
    """The scene computes the one in the middle, to its accuracy."""
    found = cue_map(Tool(), FINE, MapGrid(points=3, half_width=0.004), with_reference=False).subject
    horizontal, vertical, maps = position_map(found)
    assert len(horizontal) == len(vertical) == 3
    assert {
        name: each.shape for name, each in maps.items() if name in STRIKE_UNITS
    } == dict.fromkeys(STRIKE_UNITS, (3, 3))
    alone = strike_of_keys(FINE, bar_horizontal=horizontal[1], bar_vertical=vertical[1])
    for name, value in alone.items():
        assert maps[name][1, 1] == pytest.approx(value, rel=1e-6)
    assert np.isnan(maps["lag_deg_at_contact"][2, 2])
    assert maps["failure"][2, 2].startswith("the bristle must")


def test_maps_show_the_places_that_were_found():
    """Also those of a bar that stands far from them."""
    tool = placed(Tool(), math.radians(85.0))
    found = cue_map(tool, Settings(), MapGrid(points=3), with_reference=False).subject
    horizontal, vertical, _ = position_map(found)
    for direction in (math.radians(85.0), found.radial.direction, found.fastest.direction):
        bar = placed(tool, direction).bar
        assert horizontal[0] < bar.horizontal < horizontal[-1]
        assert vertical[0] < bar.vertical < vertical[-1]
