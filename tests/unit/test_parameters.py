"""The declared parameters: the printed operating point, what follows from it, and what is refused."""

from __future__ import annotations

import cmath
import dataclasses
import itertools
import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from bristle_sim.parameters import (
    RETRACTION_AT_RELEASE,
    Bar,
    Belt,
    Bristle,
    Contact,
    Hub,
    Release,
    Strike,
    Tool,
    Workpart,
)
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.simulate import simulate


def test_operating_point_is_the_printed_one():
    """Zhang 2020, eqs. 2.2 and 2.3, captions of figs. 2.7, 2.8 and 2.13."""
    tool = Tool()
    assert (tool.hub.speed, tool.hub.radius) == (261.8, 0.0275)
    assert (tool.bristle.length, tool.bristle.mass, tool.bristle.wire_diameter) == (
        0.027,
        8.387e-5,
        7.1e-4,
    )
    assert (tool.bar.horizontal, tool.bar.vertical) == (0.05037, 0.0225)
    assert tool.bar.centre == (-0.05037, -0.0225)
    assert tool.workpart.penetration == 0.0045
    assert (tool.workpart.friction, tool.workpart.restitution) == (0.31, 0.42)
    assert (Strike().speed_ratio, Strike().impact_angle_deg, Release().retraction_deg) == (
        3.23,
        23.4,
        44.5,
    )
    assert (tool.belt.damping_ratio, tool.bar.friction, tool.bar.restitution, tool.gravity) == (
        0.0,
        0.0,
        0.0,
        0.0,
    )
    assert tool.contact.law == "energetic"


def test_bar_touches_the_wire_at_the_printed_retraction():
    """The tip, one bristle off the root and retracted by 44.5 deg, is half a wire and a bar radius short of the bar."""
    tip = 0.0275 + 0.027 * cmath.exp(-1j * math.radians(44.5))
    distance = abs(complex(0.05037, 0.0225))
    assert math.radians(44.5) == RETRACTION_AT_RELEASE
    assert abs(tip) + Bar().radius + 7.1e-4 / 2.0 == pytest.approx(distance, rel=1e-14)  # roundings
    # Evaluated by hand from the printed figures, to the micrometre.
    assert Bar().radius == pytest.approx(4.370e-3, abs=5e-7)


def wire(bristle: Bristle, pieces: int = 100_000) -> np.ndarray:
    """Points at equal distances along the centre line, as x + iy from the root with the shank along -i."""
    along = (np.arange(pieces) + 0.5) / pieces * bristle.length
    knee = bristle.knee_position * bristle.length
    beyond = np.maximum(along - knee, 0.0)
    return -1j * (
        np.minimum(along, knee) + beyond * np.exp(1j * math.radians(bristle.knee_angle_deg))
    )


@pytest.mark.parametrize("knee", [0.0, 30.0, -30.0, 90.0])
def test_mass_and_shape_of_a_wire(knee: float):
    """Sums over the points of the wire; a positive knee bends the tip forward, along +x."""
    bristle = Bristle(length=0.3, mass=0.02, knee_position=0.6, knee_angle_deg=knee)
    points = wire(bristle)
    centre = np.mean(points)
    # Midpoint sums of squares are low by 1/(12 n^2) of the length squared, n = 1e5; the last point is half a piece short.
    assert complex(*bristle.centre) == pytest.approx(centre, rel=1e-9)
    assert bristle.inertia_about_centre == pytest.approx(
        0.02 * np.mean(abs(points - centre) ** 2), rel=1e-9
    )
    assert bristle.inertia_about_root == pytest.approx(0.02 * np.mean(abs(points) ** 2), rel=1e-9)
    assert complex(*bristle.path[-1]) == pytest.approx(points[-1], abs=0.3 / 1e5)
    assert np.sign(bristle.path[-1][0]) == np.sign(knee)
    tool = Tool(bristle=bristle)
    assert tool.workpart_depth == pytest.approx(abs(points[-1] - 0.0275j) - 0.0045, abs=0.3 / 1e5)


LARGEST_BAR = math.hypot(0.05037, 0.0225) - 3.55e-4 - 0.0275


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"penetration": 0.027}, r"penetration = 0\.027: must be less .* 0\.027, .*\(in m\)$"),
        ({"penetration": 0.03}, r"penetration = 0\.03: must be less .* 0\.027, .*\(in m\)$"),
        (
            {"bar_radius": 1.001 * LARGEST_BAR},
            f"bar_radius = .*: must be less .* = {LARGEST_BAR:g}, .*in m",
        ),
        (
            {"contact": "engine", "contact_duration": 1e-4},
            r"contact_duration = 0\.0001: must be left out with .*in s\)$",
        ),
        ({"hub_sped": 1.0}, r"unknown key 'hub_sped'; did you mean hub_speed\?$"),
        ({"links": 2}, r"unknown key 'links'; did you mean wire_links\?$"),
        ({"hub_speed": -1.0}, r"hub_speed = -1\.0: must be"),
        (
            {"bar_radius": 0.004, "bar": None},
            r"bar = None: must be present where one of its keys is given$",
        ),
        ({"bar": 3}, r"bar = 3: must be a Bar or None$"),
    ],
)
def test_a_tool_that_there_cannot_be_is_refused(changes: dict[str, Any], line: str):
    with pytest.raises(ValueError, match=f"^{line}"):
        Tool().replace(**changes)


def test_values_that_just_fit_together():
    Tool(
        bar=Bar(radius=0.999 * LARGEST_BAR),
        workpart=Workpart(penetration=math.nextafter(0.027, 0.0) - 1e-17),
    )
    assert Tool(workpart=Workpart(penetration=-0.1)).workpart_depth == pytest.approx(
        0.1545, rel=1e-15
    )
    assert Contact("compliant", 1e-4).duration == 1e-4


def test_a_tool_is_changed_by_the_keys_of_the_command_line():
    tool = Tool(contact=Contact("compliant", 1e-4))
    found = tool.replace(
        hub_speed="3000rpm",
        friction=0.4,
        bristle_length="30 mm",
        penetration=0.007,
        bar=None,
        gravity=9.81,
    )
    assert found == Tool(
        Hub(speed="3000rpm"),
        Belt(),
        Bristle(length=0.03),
        None,
        Workpart(friction=0.4, penetration=0.007),
        tool.contact,
        9.81,
    )
    assert tool.replace(contact=Contact("engine")).contact == Contact("engine")
    assert Tool().replace(contact="engine").contact == Contact("engine")
    assert found.replace(bar=Bar(), bar_radius=0.004).bar == Bar(radius=0.004)


def test_a_mass_follows_from_the_wire_unless_it_is_given():
    """Density times pi/4 d^2 L; the printed wire of 83.87 mg has 7845.78 kg/m^3."""
    assert Bristle().density == pytest.approx(7845.78, abs=5e-3)
    thin = Tool().replace(wire_diameter="0.35 mm").replace(bristle_length=0.04, wire_density=8000.0)
    assert thin.bristle.mass == pytest.approx(
        8000.0 * math.pi / 4.0 * 3.5e-4**2 * 0.04, rel=1e-14
    )  # roundings
    assert dataclasses.replace(thin.bristle, length=0.02).mass == pytest.approx(
        0.5 * thin.bristle.mass, rel=1e-14
    )
    given = Tool().replace(bristle_mass=9e-5, bristle_length=0.03)
    assert given.bristle.mass == 9e-5
    assert given.replace(bristle_length=0.04, wire_diameter=1e-3).bristle.mass == 9e-5
    assert (
        Tool().replace(bristle_mass=Tool().bristle.mass).replace(bristle_length=0.04).bristle.mass
        == 8.387e-5
    )
    with pytest.raises(
        ValueError,
        match=r"^bristle_mass = 0\.0: must be .* it follows from bristle_length, wire_diam",
    ):
        Bristle(wire_diameter=0.0)


def first_covered(tool: Tool) -> float:
    """The hub angle at which the undeflected wire first touches the bar, from 100,000 angles of the bar seen from the root."""
    path = np.array([0.0, *(complex(-y, x) for x, y in tool.bristle.path)]) + tool.hub.radius
    turns = np.linspace(-math.pi, math.pi, 100_001)
    centre = math.hypot(*tool.bar.centre) * np.exp(1j * turns)
    distance = np.full(turns.shape, math.inf)
    for begin, end in itertools.pairwise(path):
        along = np.clip(
            (np.conj(end - begin) * (centre - begin)).real / abs(end - begin) ** 2, 0.0, 1.0
        )
        distance = np.minimum(distance, abs(begin + along * (end - begin) - centre))
    covered = turns[distance < tool.bar_reach]
    return -math.atan2(tool.bar.horizontal, tool.bar.vertical) - covered.max(initial=-math.inf)


def test_a_pass_starts_a_quarter_turn_before_the_workpart_or_5_deg_before_the_bar():
    """Against the distances of sampled places; every start is clear of the bar, which is met after less than a turn."""
    rng = np.random.default_rng(1)
    starts = list[float]()
    for knee in np.where(rng.random(100) < 0.5, 0.0, rng.uniform(-90.0, 90.0, 100)):
        direction = rng.uniform(0.0, math.pi)
        length = rng.uniform(0.01, 0.06)
        away = 0.0275 + rng.uniform(0.3, 1.1) * length + 3e-3
        tool = Tool(
            bar=Bar(
                radius=2e-3,
                horizontal=away * math.sin(direction),
                vertical=away * math.cos(direction),
            ),
            bristle=Bristle(
                length=length, knee_angle_deg=float(knee), knee_position=rng.uniform(0.1, 0.9)
            ),
            workpart=None,
        )
        meeting = first_covered(tool)
        if math.isinf(meeting):
            assert tool.start_hub_angle == -math.pi / 2.0
            continue
        expected = -math.pi / 2.0 if meeting > -math.pi / 2.0 else meeting - math.radians(5.0)
        # Two of the sampled angles; the covered ones begin within that of the touch, where the wire crosses the bar's circle.
        assert tool.start_hub_angle == pytest.approx(expected, abs=1e-4)
        starts.append(tool.start_hub_angle)
    assert min(starts) < -math.pi / 2.0 == max(starts)
    assert Tool(start_hub_angle_deg=-100.0).start_hub_angle == math.radians(-100.0)


def test_a_tool_is_shown_one_line_a_part_in_engineering_units():
    lines = repr(Tool(bar=None)).splitlines()
    assert lines[0] == "Tool:"
    assert lines[1] == "  hub: speed 2500 rpm, radius 27.5 mm"
    assert "  bar: absent" in lines
    assert max(map(len, lines)) < 200
    assert "<th>hub</th>" in Tool()._repr_html_()


def test_a_misspelt_field_and_a_path_in_place_of_a_tool_are_named():
    with pytest.raises(ValueError, match=r"^Hub: unknown field 'sped'; did you mean speed\?$"):
        Hub(sped=3)  # type: ignore[call-arg]
    with pytest.raises(TypeError):
        Hub(sped=3)  # type: ignore[call-arg]
    with pytest.raises(ValueError, match=r"must be a Tool; read_tool\('tool.toml'\) reads one"):
        simulate("tool.toml")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"must be a Tool; read_tool\('tool.toml'\) reads one"):
        simulate_reference("tool.toml")  # type: ignore[arg-type]


def test_fractions_are_numbers_and_durations_of_numpy_are_not():
    assert Hub(speed=Fraction(523, 2)).speed == 261.5
    with pytest.warns(UserWarning, match=r"^hub_speed = 2000 rad/s is .*hub_speed='2000 rpm'$"):
        Hub(speed=Fraction(2000))
    with pytest.raises(ValueError, match=r"^hub_speed = [^\n]*timedelta64[^\n]*: must be a finite"):
        Hub(speed=np.timedelta64(3, "s"))


def test_a_hub_that_leaves_no_room_for_any_bar_is_named_itself():
    """The bar's centre is hypot(50.37, 22.5) = 55.17 mm from the hub's; less 4.37 mm and 0.355 mm are 50.44 mm."""
    with pytest.raises(ValueError, match=r"^hub_radius = 0\.08: must be less .* = 0\.0504"):
        Tool().replace(hub_radius="80 mm")
