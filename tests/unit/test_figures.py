"""Every figure for tools that are not the one it was made for: nothing overlaps, is cut, empty or contradicted by its data."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from bristle_sim.benchmarks.accuracy_cost.measure import Point
from bristle_sim.benchmarks.accuracy_cost.study import TARGETS
from bristle_sim.cli import Scenario
from bristle_sim.cli.scenario import assigned, load_scenario, script_paths
from bristle_sim.dissertation.figures import NUMBERS, redrawn
from bristle_sim.render.cost_figure import LEAST, cost_figure, verdict
from bristle_sim.render.dissertation_figures import draw
from bristle_sim.render.style import PURPLE, blank_figure, span_at_least
from figure_faults import faults

PASSES = (
    "", "knee_angle_deg=-30", "knee_angle_deg=45", "hub_speed=500", "friction=0.9", "penetration=-0.01", "wire_links=4",
    "contact=compliant contact_duration=0.1ms", "restitution=0", "belt_stiffness=0.00041",
    "bar_vertical=0.5 friction=0.6", "bar_friction=0.8", "hub_radius=0.1 bar_horizontal=0.11", "bristle_length=0.06",
    "hub_turn=20", "bar_restitution=0.6", "belt_damping_ratio=1", "hub_speed=20", "bristle_mass=0.002", "contact=engine",
)  # fmt: skip
"""Twenty tools: bent, fast, sticking, out of reach, of many links, in time, soft, jammed, large, long, slow and heavy ones."""

OTHERS = {
    "oblique_impact": (
        "",
        "friction=0.9",
        "restitution=0",
        "impact_angle_deg=80",
        "bristle_mass=5",
    ),
    "double_pendulum": ("", "mass_ratio=100", "rate_2=-2000 rate_1=-100", "friction=0.7"),
    "single_pendulum": ("friction=0", "impact_angle_deg=60"),
    "cue_timing": ("hub_speed=500", "belt_damping_ratio=0.5"),
    "bent_bristles": ("friction=0.9", "knee_angle_deg=60", "penetration=-0.01"),
    "inertia_driven": ("", "belt_stiffness=0.1", "penetration=-0.01"),
    "neighbours": ("pitch_deg=15 search=no", "pitch_deg=50 search=no"),
    "crater_depth": ("", "cutting_friction=0.3", "impact_angle_deg=5", "shear_yield_stress=1e9"),
    "force_history": ("", "restitution=0.6"),
    "surface": (
        "ground_length=4mm cell=20um crater_rule=plane",
        "ground_length=4mm cell=20um places=random coverage=0.5",
    ),
    "whole_tool": ("", "hub_speed=500 friction=0.6"),
    "film": ("wire_links=2 map_durations=3 map_dampings=2 workers=1",),
    "measured_impacts": ("",),
    "tolerances": ("samples=32",),
    "flexible_wire": ("wire_links=4 friction=0.6 contact_duration=0.2ms",),
}
QUICK = {
    ("cue_and_impact", PASSES[7]),
    ("crater_depth", "friction=0.3"),
    ("oblique_impact", "friction=0.9"),
}
QUICK |= {("crater_depth", "impact_angle_deg=5")}
QUICK |= {("bent_bristles", "penetration=-0.01"), ("cue_timing", "belt_damping_ratio=0.5")}
"""Drawn with every run of the tests; the others are many."""


@cache
def scenario(name: str) -> Scenario:
    return load_scenario(script_paths()[name])


def drawn(name: str, assignments: str, film: bool = False) -> Figure:
    """The figure of a scenario, or the still part of its film."""
    declared = scenario(name)
    draw = declared.film if film else declared.plot
    assert draw is not None
    made = draw(
        declared.run(**declared.built(declared.values_of(assigned("--set", assignments.split()))))
    )
    return made.figure if film else made


CASES = [("cue_and_impact", each) for each in PASSES]
CASES += [(name, each) for name, given in OTHERS.items() for each in given]


@pytest.mark.parametrize(
    ("name", "assignments"),
    [pytest.param(*each, marks=() if each in QUICK else pytest.mark.nightly) for each in CASES],
)
def test_nothing_overlaps_is_cut_or_empty(name: str, assignments: str):
    assert faults(drawn(name, assignments)) == []


FILMS = [
    ("cue_and_impact", PASSES[3]),
    ("oblique_impact", "impact_angle_deg=80"),
    ("inertia_driven", ""),
]
FILMS += [("neighbours", "pitch_deg=15 search=no"), ("flexible_wire", "wire_links=4")]


@pytest.mark.nightly
@pytest.mark.parametrize(("name", "assignments"), FILMS)
def test_nothing_that_is_still_in_a_film_overlaps_is_cut_or_empty(name: str, assignments: str):
    assert faults(drawn(name, assignments, film=True)) == []


@pytest.mark.nightly
@pytest.mark.parametrize("number", NUMBERS)
def test_the_dissertations_figures_can_be_read(number: str):
    assert faults(draw(redrawn(number))) == []


def at(method: str, error: float, cpu_s: float) -> Point:
    return Point("case", method, "step=1", error, cpu_s, 1, "" if np.isfinite(error) else "failed")


REACHED = [
    *(
        at(f"bristle_sim {name}", 10.0**-power, 1e-4 * power)
        for name in ("simulate", "extrapolation", "plain steps")
        for power in (3, 6)
    ),
    *(at("scipy dop853", error, cpu_s) for error, cpu_s in ((1e-6, 8e-4), (0.0, 9e-4))),
    *(at("scipy rk45", 1e-2, 1e-3), at("mujoco rk4", np.inf, np.nan)),
]


@pytest.mark.parametrize("count", [1, 4])
def test_the_cost_is_drawn_so_that_methods_differ_and_captions_are_of_what_is_drawn(count: int):
    """Each of our methods has a colour; a failure is not drawn, an error of 0 is."""
    cases = tuple(
        SimpleNamespace(name=name, title=f"case {name}") for name in list(TARGETS)[:count]
    )
    figure = cost_figure(SimpleNamespace(cases=cases, of=lambda _: REACHED))  # type: ignore[arg-type]
    assert faults(figure) == []
    lines = {str(line.get_gid()): line for line in figure.axes[0].lines}
    own = [name for name in lines if name.startswith("bristle_sim")]
    assert len({lines[name].get_color() for name in own}) == len(own) == 3
    assert "mujoco rk4" not in lines
    assert list(lines["scipy dop853"].get_ydata()) == [1e-6, LEAST]
    assert "scipy rk45" in lines
    said = figure.axes[0].get_title(loc="left")
    assert said.endswith("to $10^{-6}$: simulate 0.6 ms, scipy dop853 0.8 ms")


def test_the_words_above_a_panel_name_both_methods():
    coarse = at("bristle_sim simulate", 1e-2, 2e-3)
    assert verdict(1e-2, coarse, None) == "to $10^{-2}$: simulate 2 ms; no other package"
    assert "none of our methods" in verdict(1e-2, None, coarse)


def test_a_fault_is_seen():
    figure = blank_figure(10.0, 8.0)
    figure.set_layout_engine("none")
    empty = figure.add_axes((0.1, 0.1, 0.3, 0.4))
    empty.set_title("nothing", loc="left")
    axes = figure.add_axes((0.6, 0.1, 0.3, 0.4))
    axes.set_title("a title that goes on and on, far beyond the page's edge", loc="left")
    axes.plot([0.0, 1.0], [0.0, 1.0], label="named")
    axes.plot([0.0, 1.0], [1.0, 0.0], color=PURPLE)
    axes.legend()
    axes.set_ylabel("(°)")
    for shift in (0.0, 0.05):
        axes.text(0.5, 0.5 + shift, "words")
    assert {each.split()[0] for each in faults(figure)} == {"empty", "cut:", "a", "overlap:", "not"}


def test_an_axis_of_equal_values_shows_no_rounding():
    """Values that differ by 1e-8 would fill the axis, and its numbers would have an offset."""
    axes = blank_figure(4.0, 4.0).add_axes((0.2, 0.2, 0.7, 0.7))
    axes.plot([0.0, 1.0], [28.67543, 28.67543 * (1.0 + 1e-8)])
    span_at_least(axes, 0.02)
    low, high = axes.get_ylim()
    assert high - low == pytest.approx(0.02 * 28.67543, rel=0.05)
    assert not axes.yaxis.get_major_formatter().get_useOffset()
