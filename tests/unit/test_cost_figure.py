"""The figure of error against CPU time: what is drawn, what is left out, and that it can be read."""

import math
from dataclasses import dataclass

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from bristle_sim.render.cost_figure import LEAST, WIDTH, cost_figure
from bristle_sim.render.style import BLUE, ORANGE, save_figure


@dataclass
class Case:
    name: str
    title: str
    notes: tuple = ()


@dataclass
class Point:
    method: str
    error: float
    cpu_s: float


class Measured:
    def __init__(self, points, notes=("a peer cannot express this law",)):
        self.cases = tuple(Case(name, f"case {name}", notes) for name in points)
        self.points = points

    def of(self, case):
        return self.points[case]


POINTS = {
    "first": [
        Point("bristle_sim simulate", 1e-3, 1e-4),
        Point("bristle_sim simulate", 1e-6, 2e-4),
        Point("scipy dop853", 1e-5, 3e-4),
        Point("scipy dop853", 0.0, 5e-4),
        Point("mujoco rk4", math.inf, math.nan),
    ],
    "second": [Point("exudyn rk44", 1e-2, 1e-3), Point("pybullet euler", 1e-1, 1e-2)],
    "third": [Point("bristle_sim energetic", 2e-16, 1e-3)],
}


@pytest.fixture(scope="module")
def figure():
    return cost_figure(Measured(POINTS))


def test_one_panel_a_case_on_logarithmic_axes(figure):
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["case first", "case second", "case third"]
    assert all(axes.get_xscale() == axes.get_yscale() == "log" for axes in figure.axes)


def test_curves_are_the_points_in_milliseconds(figure):
    lines = {line.get_gid(): line for line in figure.axes[0].get_lines()}
    assert list(lines["bristle_sim simulate"].get_xdata()) == pytest.approx([0.1, 0.2])
    assert list(lines["bristle_sim simulate"].get_ydata()) == [1e-3, 1e-6]
    assert lines["bristle_sim simulate"].get_color() == BLUE
    assert lines["scipy dop853"].get_color() == ORANGE


def test_an_error_of_zero_is_drawn_at_the_bottom_and_a_failure_is_not(figure):
    lines = {line.get_gid(): line for line in figure.axes[0].get_lines()}
    assert list(lines["scipy dop853"].get_ydata()) == [1e-5, LEAST]
    assert "mujoco rk4" not in lines


def test_notes_are_shown(figure):
    assert all("a peer cannot express this law" in [text.get_text() for text in axes.texts] for axes in figure.axes)


def test_all_text_is_inside_the_page_and_nothing_overlaps(figure):
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    page = figure.bbox
    boxes = [axes.get_tightbbox(canvas.get_renderer()) for axes in figure.axes]
    for box in boxes:
        assert box.x0 >= page.x0
        assert box.x1 <= page.x1
        assert box.y0 >= page.y0
        assert box.y1 <= page.y1
    for index, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[index + 1 :])


def test_it_is_sixteen_centimetres_wide(figure):
    assert figure.get_size_inches()[0] * 2.54 == pytest.approx(WIDTH) == pytest.approx(16.0)


def test_no_case_is_refused():
    with pytest.raises(ValueError, match="at least one case is allowed"):
        cost_figure(Measured({}))


def test_it_can_be_saved(figure, tmp_path):
    assert save_figure(figure, tmp_path / "cost.png").stat().st_size > 10_000
