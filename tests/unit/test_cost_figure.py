"""The figure of error against CPU time: what is drawn, what is left out, and that it can be read."""

import math
from dataclasses import dataclass

import pytest

from bristle_sim.benchmarks.accuracy_cost.measure import Effect, Point
from bristle_sim.render.cost_figure import LEAST, OTHERS, best_methods, cost_figure, verdict


@dataclass
class Case:
    name: str
    title: str
    notes: tuple = ()


def at(method, error, cpu_s):
    return Point("case", method, "step=1", error, cpu_s, cpu_s, 1, "" if math.isfinite(error) else "failed")


class Measured:
    def __init__(self, points, notes=("a peer cannot express this law",)):
        self.cases = tuple(Case(name, f"case {name}", notes) for name in points)
        self.points = points
        self.effects = tuple(
            Effect(what, str(number), 1e-3 * number**2, number**2, "")
            for what in ("links", "bristles")
            for number in (1, 2, 4)
        )

    def of(self, case):
        return self.points[case]


POINTS = {
    "first": [
        at("bristle_sim simulate", 1e-3, 1e-4),
        at("bristle_sim simulate", 1e-6, 2e-4),
        at("scipy rk45", 1e-2, 1e-4),
        at("scipy rk45", 1e-7, 9e-4),
        at("scipy dop853", 1e-5, 3e-4),
        at("scipy dop853", 0.0, 5e-4),
        at("mujoco rk4", math.inf, math.nan),
    ],
    "second": [at("numpy rk44", 1e-2, 1e-3), at("mujoco euler", 1e-1, 1e-2)],
    "third": [at("bristle_sim energetic", 2e-16, 1e-3)],
}


@pytest.fixture(scope="module")
def figure():
    return cost_figure(Measured(POINTS))


def test_the_best_of_each_peer_has_a_colour_and_the_others_are_grey(figure):
    """At 1e-6 dop853 takes 0.5 ms and rk45 0.9 ms; the grey one is named below the panel."""
    assert best_methods(POINTS["first"]) == {"bristle_sim": "bristle_sim simulate", "scipy": "scipy dop853"}
    lines = {line.get_gid(): line for line in figure.axes[0].get_lines()}
    assert lines["scipy rk45"].get_color() == OTHERS
    assert [text.get_text() for text in figure.axes[0].get_legend().get_texts()] == [
        "bristle_sim simulate",
        "scipy dop853",
    ]
    assert any("grey: scipy rk45" in text.get_text() for text in figure.axes[0].texts)


def test_a_package_that_does_not_get_to_1e_6_is_judged_by_what_it_reaches():
    assert best_methods(POINTS["second"]) == {"numpy": "numpy rk44", "mujoco": "mujoco euler"}


def test_the_title_says_what_the_reader_should_see(figure):
    shown = [text.get_text() for text in figure.axes[0].texts]
    assert "to $10^{-6}$: simulate 0.2 ms, scipy dop853 0.5 ms" in shown
    assert verdict(POINTS["third"]) == "to $10^{-6}$: energetic 1 ms, no peer gets there"
    assert verdict(POINTS["second"]) == "none of our methods is within 1"


def test_an_error_of_zero_is_drawn_at_the_bottom_and_a_failure_is_not(figure):
    lines = {line.get_gid(): line for line in figure.axes[0].get_lines()}
    assert list(lines["scipy dop853"].get_ydata()) == [1e-5, LEAST]
    assert "mujoco rk4" not in lines


def test_no_case_is_refused():
    with pytest.raises(ValueError, match="must be one case or more"):
        cost_figure(Measured({}))
