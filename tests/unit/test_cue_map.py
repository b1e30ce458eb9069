"""Where the bar must stand, against the independent solution, a closed form and synthetic strikes."""

import math
import re
from collections.abc import Callable

import numpy as np
import pytest

from bristle_sim.parameters import Bar, Belt, Hub, Tool
from bristle_sim.settings import Settings
from bristle_sim.studies.bar_search import (
    Measures,
    Place,
    Strike,
    fastest_place,
    placed,
    radial_place,
    simulation,
)
from bristle_sim.studies.cue_map import MapGrid, cue_map, position_map
from bristle_sim.studies.strike_point import STRIKE_UNITS, NotCuedError, strike_of_keys
from bristle_sim.studies.whole_pass import GivenUpError

FINE = Settings(accuracy=1e-9)


@pytest.fixture(scope="module")
def radial() -> Place:
    return radial_place(Tool(), simulation(FINE))


def test_the_operating_point(radial: Place):
    """Two independent computations gave 68.145 degrees and 878.7 rad/s, and with the bar's distance 51.20 and 20.54 mm."""
    bar = placed(Tool(), radial.direction).bar
    assert bar is not None
    assert math.degrees(radial.direction) == pytest.approx(68.145, abs=5e-4)
    assert bar.horizontal == pytest.approx(0.05120, abs=5e-6)
    assert bar.vertical == pytest.approx(0.02054, abs=5e-6)
    assert radial.strike["relative_speed_at_contact"] == pytest.approx(878.7, abs=0.05)


def test_the_answer_names_the_place_and_the_strike_where_the_bar_stands():
    """68.145 degrees, 51.20 and 20.54 mm by two independent computations; print is 2.74 degrees short of radial."""
    answer = cue_map(Tool(), Settings(), with_reference=False).answer
    assert answer.startswith(
        "The bar must stand at 68.14° from the workpart's normal, 51.20 mm before the hub's axis and 20.54 mm below it; there"
        " the tip is also fastest, 38 m/s. Where it stands, at 65.93° as printed, the strike is 2.74° short of radial."
    )
    beyond = cue_map(
        Tool(bar=Bar(horizontal=0.0515, vertical=0.0198)), Settings(), with_reference=False
    ).answer
    assert re.search(r"Where it stands, at 68\.97°, the strike is [\d.]+° beyond radial\.$", beyond)
    away = cue_map(
        Tool(bar=Bar(horizontal=0.01, vertical=0.05425)), Settings(), with_reference=False
    ).answer
    assert "there is no cued strike: " in away


@pytest.mark.parametrize(
    ("tool", "words"),
    [
        (
            Tool(belt=Belt(stiffness=0.00041)),
            "no direction at this distance cues the bristle; .*retraction limit",
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
        radial_place(tool, simulation(Settings(accuracy=1e-4)))
    assert "\n" not in str(refusal.value)


def by_direction(
    lag: Callable[[float], float], speed: Callable[[float], float] = math.cos
) -> Strike:
    """A strike that depends on the bar's direction alone, in degrees and rad."""

    def strike(tool: Tool) -> Measures:
        assert tool.bar is not None
        direction = math.atan2(tool.bar.horizontal, tool.bar.vertical)
        return {
            "lag_deg_at_contact": lag(math.degrees(direction)),
            "tip_speed_at_contact": speed(direction),
        }

    return strike


@pytest.mark.parametrize("root", [0.4, 12.0, 67.0, 178.0])
def test_a_root_is_found_wherever_it_is(root: float):
    found = radial_place(
        Tool(), by_direction(lambda direction: (root - direction) ** 3 + root - direction)
    )
    assert math.degrees(found.direction) == pytest.approx(root, abs=1e-8)


def test_a_jump_or_a_rise_is_no_root():
    """As the lag falls with the direction, a rise is where the strike has jumped to another swing."""
    with pytest.raises(NotCuedError, match=r"at (7\d|70) deg the lag jumps"):
        radial_place(Tool(), by_direction(lambda direction: 1.0 if direction < 70.0 else -1.0))
    found = radial_place(
        Tool(), by_direction(lambda direction: math.sin(math.radians(8.0 * (direction - 67.5))))
    )
    assert abs(math.degrees(found.direction) - 67.5) == pytest.approx(22.5, abs=1e-8)


def test_passes_that_are_given_up_end_a_search_that_has_no_answer_yet():
    """Three are tried."""
    tried = []

    def strike(tool: Tool):
        tried.append(tool)
        raise GivenUpError("step budget spent")

    with pytest.raises(GivenUpError, match=r"^step budget spent$"):
        radial_place(Tool(), strike)
    assert len(tried) == 3


@pytest.mark.parametrize("peak", [0.3, 1.15, 2.9])
def test_a_maximum_is_found_uphill(peak: float):
    found = fastest_place(
        Tool(), by_direction(lambda _: 0.0, lambda direction: 2.0 - (direction - peak) ** 2), 1.2
    )
    assert found.direction == pytest.approx(peak, abs=1e-5)


def test_maps_hold_the_passes_at_their_positions():
    pytest.importorskip("zarr", reason="needs the extra sweep")
    found = position_map(Tool(), Settings(accuracy=1e-5), MapGrid(points=3.0, half_width=0.004))
    assert found.sizes == {"bar_vertical": 3, "bar_horizontal": 3}
    assert {name: found[name].attrs["units"] for name in STRIKE_UNITS} == STRIKE_UNITS
    alone = strike_of_keys(Settings(accuracy=1e-5))
    centre = found.isel(bar_vertical=1, bar_horizontal=1)
    for name, value in alone.items():
        assert centre[name].item() == value
    far = found.isel(bar_vertical=2, bar_horizontal=2)
    assert np.isnan(far["lag_deg_at_contact"].item())
    assert far["failure"].item().startswith("the bristle must")
